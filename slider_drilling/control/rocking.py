"""The rocking trajectory of the paper's Fig. 22: a triangle wave with rounded peaks."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.errors import InputError


@dataclass(frozen=True)
class Rocking:
    """Triangle wave of the top-drive angle about its centre, with rounded peaks.

    The straight lines have the slopes +-4 D/T. The paper rounds the peaks with a circular arc. Drawn over s and rad, in
    the paper's own case (10 rad, 10 s, 0.2 s), that arc needs 340 rad/s2 at the joints. A parabola through the same two
    points with the same tangents has the smallest peak acceleration of all curves, 4 D/(T delta) = 20 rad/s2. Since
    acceleration is what limits a drive, the peaks are parabolas; they turn at D (1 - 2 delta/T).

    Attributes:
        amplitude: Of the triangle, rad (paper: D_y).
        period: s (paper: T).
        rounding: Half the width of a rounded peak, s (paper: delta).

    Raises:
        InputError: A value is not finite, amplitude < 0, period <= 0, or not 0 < rounding <= period/6 (the start from
            rest and the first peak would overlap).
    """

    amplitude: float
    period: float
    rounding: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.amplitude) and self.amplitude >= 0.0):
            raise InputError(f"rocking: amplitude = {self.amplitude} rad: must be finite and not negative")
        if not (math.isfinite(self.period) and self.period > 0.0):
            raise InputError(f"rocking: period = {self.period} s: must be finite and positive")
        if not 0.0 < self.rounding <= self.period / 6.0:
            raise InputError(f"rocking: rounding = {self.rounding} s: must be positive and at most a sixth of "
                             f"the period ({self.period / 6.0:g} s)")

    @property
    def speed(self) -> float:
        """Speed along the straight lines, rad/s."""
        return 4.0 * self.amplitude / self.period

    @property
    def acceleration(self) -> float:
        """Magnitude of the acceleration in the rounded peaks, rad/s2."""
        return self.speed / self.rounding

    @property
    def turning_angle(self) -> float:
        """Turning point of the rounded motion, rad from the centre: slightly inside the amplitude."""
        return self.amplitude - self.speed * self.rounding / 2.0

    def point(self, phase: float) -> tuple[float, float]:
        """Return angle from the centre (rad) and speed (rad/s), `phase` s after passing the centre clockwise."""
        quarter = self.period / 4.0
        folded = phase % self.period
        half, side = (folded, 1.0) if folded < 2.0 * quarter else (folded - 2.0 * quarter, -1.0)
        from_peak = half - quarter
        if abs(from_peak) >= self.rounding:
            rising = 1.0 if from_peak < 0.0 else -1.0
            return side * (self.amplitude - self.speed * abs(from_peak)), side * rising * self.speed
        angle = self.turning_angle - 0.5 * self.acceleration * from_peak * from_peak
        return side * angle, -side * self.acceleration * from_peak

    def from_rest(self, elapsed: float) -> tuple[float, float]:
        """Return angle (rad) and speed (rad/s) of the wave, `elapsed` s after a start from rest at the centre.

        The drive accelerates as in the peaks for `rounding` seconds; then it follows `point(elapsed - rounding/2)`.
        """
        if elapsed <= 0.0:
            return 0.0, 0.0
        if elapsed < self.rounding:
            return 0.5 * self.acceleration * elapsed * elapsed, self.acceleration * elapsed
        return self.point(elapsed - self.rounding / 2.0)
