"""The well path: survey stations joined by minimum curvature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def tangent(inclination: Array, azimuth: Array) -> Array:
    """Unit vectors along the hole, (..., 3) as north, east, down; angles in rad."""
    sine = np.sin(inclination)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(inclination)], axis=-1)


@dataclass(frozen=True)
class WellPath:
    """Stations of a survey: measured depth m (n,), tangents (n, 3), positions m (n, 3) as north, east, down."""

    depth: Array
    tangent: Array
    position: Array

    @classmethod
    def from_survey(cls, survey: tuple[tuple[float, float, float], ...]) -> WellPath:
        """The path of rows (measured depth m, inclination deg, azimuth deg), depth increasing."""
        rows = np.asarray(survey, dtype=float)
        directions = tangent(np.radians(rows[:, 1]), np.radians(rows[:, 2]))
        legs = np.diff(rows[:, 0])[:, None] * _chord_ratio(directions[:-1], directions[1:])[:, None]
        steps = 0.5 * legs * (directions[:-1] + directions[1:])
        position = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
        return cls(rows[:, 0], directions, position)

    def interpolate(self, depth: Array) -> tuple[Array, Array]:
        """Tangents and positions, each (m, 3), at measured depths (m,) within the survey.

        Between two stations the tangent turns along the great circle at a constant rate (minimum curvature).
        """
        leg = np.clip(np.searchsorted(self.depth, depth, side="right") - 1, 0, len(self.depth) - 2)
        start, end = self.tangent[leg], self.tangent[leg + 1]
        fraction = (depth - self.depth[leg]) / (self.depth[leg + 1] - self.depth[leg])
        angle = _angle(start, end)
        flat = angle < 1e-9
        safe = np.where(flat, 1.0, np.sin(angle))
        weight_start = np.where(flat, 1.0 - fraction, np.sin((1.0 - fraction) * angle) / safe)
        weight_end = np.where(flat, fraction, np.sin(fraction * angle) / safe)
        here = weight_start[:, None] * start + weight_end[:, None] * end
        chord = ((depth - self.depth[leg]) * _chord_ratio(start, here))[:, None]
        return here, self.position[leg] + 0.5 * chord * (start + here)


def _angle(a: Array, b: Array) -> Array:
    """Angle between unit vectors, accurate for small ones too."""
    return 2.0 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))


def _chord_ratio(a: Array, b: Array) -> Array:
    """The minimum-curvature ratio factor ``tan(angle / 2) / (angle / 2)``."""
    half = 0.5 * _angle(a, b)
    return np.where(half < 1e-6, 1.0 + half**2 / 3.0, np.tan(half) / np.where(half < 1e-6, 1.0, half))
