"""The detection limit: the size at which an effect is named half the time, from a logistic curve over log size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_expit
from scipy.stats import chi2

Array = NDArray[np.float64]
_LEVEL = 0.95
# The limit is searched from the smallest size divided by this factor to the largest one times it.
_RANGE_FACTOR = 8.0
_CENTRES = 241
# Slopes of the curve, per unit of the natural logarithm of size.
_SLOPES = np.geomspace(0.3, 30.0, 60)


@dataclass(frozen=True)
class DetectionLimit:
    """The size at which an effect is named half the time.

    Attributes:
        size: In noise floors; None where every size that was tried is named, or none is.
        interval: 95 % interval; an end beyond the sizes that were tried is None.
        named: Number of logs in which the effect is named.
        total: Number of logs.
    """

    size: float | None
    interval: tuple[float | None, float | None]
    named: int
    total: int


def detection_limit(sizes: Sequence[float], named: Sequence[bool]) -> DetectionLimit:
    """Returns the detection limit by logistic regression with Firth's penalised likelihood.

    The penalty keeps the estimate finite where the sizes that are named and those that are not do not overlap. The
    interval comes from the profile likelihood. Only slopes above zero are tried: chance grows with size.

    Args:
        sizes: In noise floors, (n,).
        named: Whether the effect is named at each size, (n,).
    """
    count, total = int(sum(named)), len(named)
    if total == 0:
        return DetectionLimit(None, (None, None), 0, 0)
    x, y = np.log(np.asarray(sizes, dtype=float)), np.asarray(named, dtype=float)
    centres = np.linspace(x.min() - np.log(_RANGE_FACTOR), x.max() + np.log(_RANGE_FACTOR), _CENTRES)
    profile = _profile_likelihood(x, y, centres)
    inside = centres[profile >= profile.max() - 0.5 * chi2.ppf(_LEVEL, 1)]
    interval = (
        None if inside[0] <= x.min() - 1e-9 else float(np.exp(inside[0])),
        None if inside[-1] >= x.max() + 1e-9 else float(np.exp(inside[-1])),
    )
    if count in (0, total):
        return DetectionLimit(None, interval, count, total)
    return DetectionLimit(float(np.exp(centres[int(profile.argmax())])), interval, count, total)


def _profile_likelihood(x: Array, y: Array, centres: Array) -> Array:
    """(m,) the penalised log likelihood at the best slope for each centre."""
    x, same, counts = np.unique(x, return_inverse=True, return_counts=True)
    successes = np.bincount(same.reshape(-1), weights=y)
    t = _SLOPES[:, None, None] * (x - centres[:, None])
    log_p = log_expit(t)
    # log(1 - p) = log p - t
    likelihood = np.sum(counts * log_p - (counts - successes) * t, axis=-1)
    p = np.exp(log_p)
    weight = counts * p * (1.0 - p)
    # Entries of the Fisher information of intercept and slope; Firth's penalty is half its log determinant.
    a, b, c = weight.sum(-1), (weight * x).sum(-1), (weight * x * x).sum(-1)
    best: Array = (likelihood + 0.5 * np.log(np.maximum(a * c - b * b, 1e-12))).max(axis=0)
    return best
