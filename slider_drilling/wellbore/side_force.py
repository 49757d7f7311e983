"""The side force of a whole element, also where the hole bends differently within it.

A metre of pipe is pressed on the wall by ``w |(sin t - x dt/ds, x sin t da/ds)|``, with w its buoyed weight and
x = T / w its tension over that (m). Where the curvature changes inside an element, above all at a survey station, the
average over the element has another form: pipe that lies on the low side before the station and on the high side after
it presses on both, while the element's middle, or its mean curvature, shows no side force. The closest law of the form

    w sqrt((a - x b)^2 + (x c)^2)

is exact without tension (a is the mean of sin t), with b and c by least squares over the tensions that a string of the
well may have. Where the curvature is constant, a, b and c are sin t, dt/ds and sin t da/ds at the middle, accurate to
the square of the element's length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slider_drilling.wellbore.well_path import Array, WellPath

_PARTS = 8  # of an element, besides those that stations make
_FRICTION = 0.3 * np.linspace(-1.0, 1.0, 5)  # coefficients with which a string may be raised or lowered
_MIN_SQUARE = 1e-6  # of side force over weight: freely hanging pipe has none
_FAR_WEIGHT = 1e-3  # of the mean curvature in the fit, which is the limit of large tension
_TINY = 1e-12


@dataclass(frozen=True)
class SideForceGeometry:
    """The coefficients of side force for pieces of hole, each (m,).

    Attributes:
        sine: sin(inclination) at the middle (a of the module's law).
        vertical_curvature: d inclination / ds, rad/m (b).
        lateral_curvature: sin(inclination) d azimuth / ds, rad/m (c).
    """

    sine: Array
    vertical_curvature: Array
    lateral_curvature: Array

    @classmethod
    def between(cls, path: WellPath, boundaries: Array) -> SideForceGeometry:
        """Geometry at the middle of the pieces between measured depths (m + 1,), m."""
        direction, _ = path.interpolate(boundaries)
        middle, _ = path.interpolate(0.5 * (boundaries[:-1] + boundaries[1:]))
        curvature = np.diff(direction, axis=0) / np.diff(boundaries)[:, None]
        cosine, sine = middle[:, 2], np.hypot(middle[:, 0], middle[:, 1])
        flat = sine < 1e-9
        north = np.where(flat, 1.0, middle[:, 0] / np.where(flat, 1.0, sine))
        east = np.where(flat, 0.0, middle[:, 1] / np.where(flat, 1.0, sine))
        high_side = np.stack([cosine * north, cosine * east, -sine], axis=1)
        across = np.stack([-east, north, np.zeros_like(east)], axis=1)
        return cls(sine, np.sum(curvature * high_side, axis=1), np.sum(curvature * across, axis=1))

    def side_force_per_weight(self, tension: Array) -> Array:
        """Side force over buoyed weight (m,), at a tension over buoyed weight per metre (m,), m."""
        return np.hypot(self.sine - tension * self.vertical_curvature, tension * self.lateral_curvature)


def side_force_geometry(path: WellPath, boundaries: Array, area: Array, falls: Array) -> SideForceGeometry:
    """Side-force coefficients of elements; those without a station inside take those of their middle.

    Args:
        path: The well path.
        boundaries: Of the elements, m, (n + 1,).
        area: Of steel, m2, (n,).
        falls: True vertical depth that each element spans, m, (n,).
    """
    count, length = len(area), np.diff(boundaries)
    even = boundaries[:-1, None] + length[:, None] * np.arange(_PARTS) / _PARTS
    inside = path.depth[(path.depth > boundaries[0]) & (path.depth < boundaries[-1])]
    edges = np.unique(np.concatenate([even.ravel(), boundaries[-1:], inside]))
    owner = _owner(boundaries, 0.5 * (edges[:-1] + edges[1:]))
    pieces, fraction = SideForceGeometry.between(path, edges), np.diff(edges) / length[owner]

    def mean(values: Array) -> Array:
        return np.asarray(np.bincount(owner, fraction * values, count), dtype=np.float64)

    sine, curved = mean(pieces.sine), mean(np.hypot(pieces.vertical_curvature, pieces.lateral_curvature))
    hanging, drag = _carried(area * falls) / area, _carried(area * length * sine) / area
    tensions = hanging + _FRICTION[:, None] * drag
    forces = np.stack([mean(pieces.side_force_per_weight(tension[owner])) for tension in tensions])
    vertical, lateral = _fit_curvatures(sine, curved, tensions, forces)
    lateral = np.where(mean(pieces.lateral_curvature) < 0.0, -lateral, lateral)
    has_station, middle = np.zeros(count, dtype=bool), SideForceGeometry.between(path, boundaries)
    has_station[_owner(boundaries, inside[~np.isin(inside, boundaries)])] = True
    return SideForceGeometry(
        np.where(has_station, sine, middle.sine), np.where(has_station, vertical, middle.vertical_curvature),
        np.where(has_station, lateral, middle.lateral_curvature),
    )  # fmt: skip


def _owner(boundaries: Array, depth: Array) -> NDArray[np.intp]:
    """Index of the element that holds each depth (m,)."""
    return np.clip(np.searchsorted(boundaries, depth, side="right") - 1, 0, len(boundaries) - 2)


def _fit_curvatures(sine: Array, curved: Array, tensions: Array, forces: Array) -> tuple[Array, Array]:
    """b and c (n,) of the module's law by least squares with equal relative errors.

    Args:
        sine: a, (n,).
        curved: Mean curvature, rad/m, (n,): a weak prior, which decides alone where tensions give no information.
        tensions, forces: Tension over weight (m) and side force over weight that are fitted, (K, n).
    """
    weights = 1.0 / (forces**2 + _MIN_SQUARE)
    # (a - x b)^2 + (x c)^2 = a^2 + linear x + square x^2
    first, second, third = (np.sum(weights * tensions**power, axis=0) for power in (2, 3, 4))
    bent = forces**2 - sine**2
    of_linear, of_square = (np.sum(weights * bent * tensions**power, axis=0) for power in (1, 2))
    far = _FAR_WEIGHT * third + _TINY
    firm, third, of_far = first + _TINY, third + far, of_square + far * curved**2
    determinant = firm * third - second**2
    linear = (third * of_linear - second * of_far) / determinant
    square = (firm * of_far - second * of_linear) / determinant
    # Where c would be imaginary the mean curvature alone sets the limit of large tension, which leaves c real.
    real = (square >= 0.0) & (linear**2 <= 4.0 * sine**2 * square)
    square = np.where(real, square, curved**2)
    linear = np.where(real, linear, (of_linear - square * second) / firm)
    size = np.sqrt(square)
    vertical = np.clip(-linear / np.maximum(2.0 * sine, _TINY), -size, size)
    return vertical, np.sqrt(np.maximum(square - vertical**2, 0.0))


def _carried(weights: Array) -> Array:
    """Weight that hangs from the middle of each element (n,)."""
    return np.cumsum(weights[::-1])[::-1] - 0.5 * weights
