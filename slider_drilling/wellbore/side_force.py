"""The side force of a whole element: a wall that turns inside it presses elsewhere than its middle does.

A metre of pipe presses by ``w |(sin t - x dt/ds, x sin t da/ds)|``, w being its buoyed weight and x = T / w its tension
over that (m). Averaged over an element this is no such law any more where the curvature changes inside it, at a survey
station above all: pipe that lies on the low side before the station and on the high side behind it presses on both, and
its middle, or its mean curvature, on neither. What comes nearest is

    w sqrt((a - x b)^2 + (x c)^2),

right without tension (a: the mean of sin t) and by least squares over the tensions that a string of the well may
have. Where nothing changes a, b and c are sin t, dt/ds and sin t da/ds of the middle, right to the square of the
element's length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slider_drilling.wellbore.well_path import Array, WellPath

_PARTS = 8  # of an element, beside those that stations make
_DRAGS = 0.3 * np.linspace(-1.0, 1.0, 5)  # friction by which a string may be raised and lowered
_LEAST = 1e-6  # of the square of what presses, over the weight: pipe that hangs free presses on nothing
_FAR = 1e-3  # share that the mean curvature has in the fit: what tension alone presses
_TINY = 1e-12


@dataclass(frozen=True)
class SideForceGeometry:
    """How pieces of hole lie, each (m,): sine of the inclination at the middle; d inclination / ds; sin(inclination)
    d azimuth / ds, rad/m.
    """

    sine: Array
    vertical_curvature: Array
    lateral_curvature: Array

    @classmethod
    def between(cls, course: WellPath, boundaries: Array) -> SideForceGeometry:
        """Of the pieces between measured depths (m + 1,)."""
        direction, _ = course.interpolate(boundaries)
        middle, _ = course.interpolate(0.5 * (boundaries[:-1] + boundaries[1:]))
        curvature = np.diff(direction, axis=0) / np.diff(boundaries)[:, None]
        cosine, sine = middle[:, 2], np.hypot(middle[:, 0], middle[:, 1])
        flat = sine < 1e-9
        north = np.where(flat, 1.0, middle[:, 0] / np.where(flat, 1.0, sine))
        east = np.where(flat, 0.0, middle[:, 1] / np.where(flat, 1.0, sine))
        high_side = np.stack([cosine * north, cosine * east, -sine], axis=1)
        across = np.stack([-east, north, np.zeros_like(east)], axis=1)
        return cls(sine, np.sum(curvature * high_side, axis=1), np.sum(curvature * across, axis=1))

    def side_force_per_weight(self, tension: Array) -> Array:
        """(m,) side force over the buoyed weight, at a tension (m,) over the buoyed weight per metre."""
        return np.hypot(self.sine - tension * self.vertical_curvature, tension * self.lateral_curvature)


def side_force_geometry(course: WellPath, boundaries: Array, area: Array, falls: Array) -> SideForceGeometry:
    """How elements lie as far as their side force goes; boundaries: (n + 1,) m; area: (n,) m2 of steel; falls: (n,) m
    of true vertical depth. Those without a station inside lie as their middle does.
    """
    count, length = len(area), np.diff(boundaries)
    even = boundaries[:-1, None] + length[:, None] * np.arange(_PARTS) / _PARTS
    inside = course.depth[(course.depth > boundaries[0]) & (course.depth < boundaries[-1])]
    edges = np.unique(np.concatenate([even.ravel(), boundaries[-1:], inside]))
    owner = _owner(boundaries, 0.5 * (edges[:-1] + edges[1:]))
    pieces, share = SideForceGeometry.between(course, edges), np.diff(edges) / length[owner]

    def mean(of: Array) -> Array:
        return np.asarray(np.bincount(owner, share * of, count), dtype=np.float64)

    sine, curved = mean(pieces.sine), mean(np.hypot(pieces.vertical_curvature, pieces.lateral_curvature))
    hanging, drag = _carried(area * falls) / area, _carried(area * length * sine) / area
    tensions = hanging + _DRAGS[:, None] * drag
    pressing = np.stack([mean(pieces.side_force_per_weight(tension[owner])) for tension in tensions])
    vertical, lateral = _bends(sine, curved, tensions, pressing)
    lateral = np.where(mean(pieces.lateral_curvature) < 0.0, -lateral, lateral)
    turns, middle = np.zeros(count, dtype=bool), SideForceGeometry.between(course, boundaries)
    turns[_owner(boundaries, inside[~np.isin(inside, boundaries)])] = True
    return SideForceGeometry(
        np.where(turns, sine, middle.sine), np.where(turns, vertical, middle.vertical_curvature),
        np.where(turns, lateral, middle.lateral_curvature),
    )  # fmt: skip


def _owner(boundaries: Array, depth: Array) -> NDArray[np.intp]:
    """(m,) the element that each depth (m,) is in."""
    return np.clip(np.searchsorted(boundaries, depth, side="right") - 1, 0, len(boundaries) - 2)


def _bends(sine: Array, curved: Array, tensions: Array, pressing: Array) -> tuple[Array, Array]:
    """b and c (n,) of the module's law; tensions, pressing: (K, n) m and - of what it is fitted to, relative errors
    alike; curved: (n,) rad/m, which counts for a little, and alone where tensions tell nothing.
    """
    weights = 1.0 / (pressing**2 + _LEAST)
    # (a - x b)^2 + (x c)^2 = a^2 + linear x + square x^2
    first, second, third = (np.sum(weights * tensions**power, axis=0) for power in (2, 3, 4))
    bent = pressing**2 - sine**2
    of_linear, of_square = (np.sum(weights * bent * tensions**power, axis=0) for power in (1, 2))
    far = _FAR * third + _TINY
    firm, third, of_far = first + _TINY, third + far, of_square + far * curved**2
    determinant = firm * third - second**2
    linear = (third * of_linear - second * of_far) / determinant
    square = (firm * of_far - second * of_linear) / determinant
    # Of no real c: then the mean curvature alone is the far end, which with any tension's pressing leaves c real.
    real = (square >= 0.0) & (linear**2 <= 4.0 * sine**2 * square)
    square = np.where(real, square, curved**2)
    linear = np.where(real, linear, (of_linear - square * second) / firm)
    size = np.sqrt(square)
    vertical = np.clip(-linear / np.maximum(2.0 * sine, _TINY), -size, size)
    return vertical, np.sqrt(np.maximum(square - vertical**2, 0.0))


def _carried(of: Array) -> Array:
    """(n,) what the middle of each element carries of what elements (n,) weigh."""
    return np.cumsum(of[::-1])[::-1] - 0.5 * of
