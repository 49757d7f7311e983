"""What a channel's innovation looks like over one rocking period: its mean, its likeness to the channel, its spread.

The rocking repeats: what the model has wrong repeats with it, and averages over whole periods are steady as long as
nothing changes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.twin.channels import COMPARED, SURFACE
from slider_drilling.twin.samples import Array

FEATURES = ("mean", "gain", "lag", "spread")
_ROWS = {name: row for row, name in enumerate(COMPARED)}
_MIN_SHARE = 0.5  # of a window's samples that must have been measured
_SPREAD_FLOOR = 0.5  # noise levels: nobody acts on what changes far below the noise that the rig file declares
_LEAST_SHAPE = 1e-3  # noise levels


@dataclass(frozen=True)
class Feature:
    """One number of a channel over one window.

    Attributes:
        channel: The channel.
        kind: One of `FEATURES`.
        value: Noise levels; of the spread the logarithm of the RMS that the other three leave, with half a noise level
            added in squares.
        sensitivity: Change per unit of each tracked parameter, (p,).
    """

    channel: str
    kind: str
    value: float
    sensitivity: Array


def features(innovation: Array, expected: Array, sensitivity: Array, noise: dict[str, float]) -> list[Feature]:
    """The features of one window.

    Args:
        innovation: Measured minus expected, (n, channels), NaN where nothing was measured; in the order of `COMPARED`.
        expected: (n, channels), of the plant.
        sensitivity: Of that, (n, channels, p).
        noise: Noise level by channel.
    """
    found: list[Feature] = []
    for name in SURFACE:
        row, sigma = _ROWS[name], noise[name]
        known = np.isfinite(innovation[:, row])
        if known.sum() < max(_MIN_SHARE * known.size, 20):
            continue
        shapes = shapes_of(expected[:, row], _LEAST_SHAPE * sigma)[known]
        solve = np.linalg.pinv(shapes)
        coefficients = solve @ innovation[known, row] / sigma
        rest = innovation[known, row] / sigma - shapes @ coefficients
        slopes = solve @ sensitivity[known, row, :] / sigma
        for index, kind in enumerate(FEATURES[:3]):
            found.append(Feature(name, kind, float(coefficients[index]), slopes[index]))
        spread = 0.5 * math.log(_SPREAD_FLOOR**2 + float(np.mean(rest**2)))
        found.append(Feature(name, "spread", spread, np.zeros(sensitivity.shape[2])))
    return found


def shapes_of(expected: Array, least: float = 0.0) -> Array:
    """(n, 3): one, the channel (n,) about its mean, and its slope, each with an RMS of 1; 0 where that is the least.

    A channel that stands still differs from its mean by rounding alone: another column of ones.
    """
    level = expected - expected.mean()
    slope = np.gradient(expected)
    columns = [np.ones_like(level)]
    for shape in (level, slope - slope.mean()):
        size = float(np.sqrt(np.mean(shape**2)))
        columns.append(shape / size if size > least else np.zeros_like(shape))
    return np.stack(columns, axis=1)
