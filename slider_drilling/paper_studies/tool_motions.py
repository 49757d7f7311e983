"""The motion of the pipe under each vibration tool: one period of motion and load (paper sections 2 and 5).

Every motion adds to a feed down the hole at the rate of penetration. A harmonic one is given, as in the paper, by the
amplitude of its speed or displacement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slider_drilling.control.rocking import Rocking
from slider_drilling.errors import InputError

SAMPLES = 360
"""Samples per period of a harmonic motion, one degree of phase each."""

Series = NDArray[np.float64]


@dataclass(frozen=True)
class ToolMotion:
    """One period of a tool's motion, (n + 1,) samples of which the last repeats the first.

    Attributes:
        time: s, from 0 to the period.
        feed: Rate of penetration, m/s, added to ``axial``.
        axial, tangential: Displacement along and around the hole, m.
        load: Normal force over its mean.
    """

    time: Series
    feed: float
    axial: Series
    tangential: Series
    load: Series

    @property
    def period(self) -> float:
        """Length of the period, s."""
        return float(self.time[-1])

    def repeated(self, cycles: int) -> tuple[Series, Series, Series, Series]:
        """Time (s), axial and tangential displacement (m) and load ratio over some cycles, joined without repeats."""
        n = self.time.size - 1
        time = np.concatenate([self.time[:-1] + k * self.period for k in range(cycles)] + [[cycles * self.period]])
        axial, tangential, load = (
            np.append(np.tile(series[:-1], cycles), series[-1]) for series in (self.axial, self.tangential, self.load)
        )
        assert time.size == n * cycles + 1
        return time, axial + self.feed * time, tangential, load


def longitudinal(rate_of_penetration: float, amplitude: float, frequency: float) -> ToolMotion:
    """NOV's hydraulic oscillation system: the pipe oscillates along the hole by +-amplitude (m) at frequency (Hz).

    rate_of_penetration: m/s.
    """
    time, sine = _harmonic(frequency)
    return ToolMotion(time, rate_of_penetration, amplitude * sine, 0.0 * time, 1.0 + 0.0 * time)


def radial(rate_of_penetration: float, ratio: float, frequency: float) -> ToolMotion:
    """Radial hydraulic oscillator: the normal force varies by +-ratio of its mean (0 <= ratio < 1).

    rate_of_penetration: m/s; frequency: Hz. Raises InputError for a ratio at which the pipe lifts off.
    """
    if not 0.0 <= ratio < 1.0:
        raise InputError(f"radial motion: ratio = {ratio}: must be in [0, 1), or the pipe lifts off the wall")
    time, sine = _harmonic(frequency)
    return ToolMotion(time, rate_of_penetration, 0.0 * time, 0.0 * time, 1.0 + ratio * sine)


def torsional(rate_of_penetration: float, speed_amplitude: float, frequency: float, radius: float) -> ToolMotion:
    """3-D hydraulic oscillation system, torsional part: the pipe's rotation speed is a sine.

    rate_of_penetration: m/s; speed_amplitude: rad/s; frequency: Hz; radius: m.
    """
    time, sine = _harmonic(frequency)
    return ToolMotion(
        time, rate_of_penetration, 0.0 * time, _swing(speed_amplitude, frequency, radius) * sine, 1.0 + 0.0 * time
    )


def three_d(
    rate_of_penetration: float, amplitude: float, speed_amplitude: float, frequency: float, radius: float
) -> ToolMotion:
    """3-D hydraulic oscillation system: `longitudinal` and `torsional` together, a quarter period apart.

    One turbine drives both. The paper does not give the phase between them; a quarter period makes the path an
    ellipse, on which the pipe never rests.

    Args:
        rate_of_penetration: m/s.
        amplitude: Axial, m.
        speed_amplitude: Of the rotation, rad/s.
        frequency: Hz.
        radius: m.
    """
    time, sine = _harmonic(frequency)
    cosine = np.cos(2.0 * math.pi * frequency * time)
    swing = _swing(speed_amplitude, frequency, radius)
    return ToolMotion(time, rate_of_penetration, amplitude * sine, swing * cosine, 1.0 + 0.0 * time)


def rocking(rate_of_penetration: float, rocking: Rocking, radius: float) -> ToolMotion:
    """Slider drilling: the pipe turns to and fro along the rounded triangle of Fig. 22.

    rate_of_penetration: m/s; radius: m. A sample takes a thirtieth of the rounding or a 360th of the period, whichever
    is less.
    """
    samples = max(SAMPLES, math.ceil(30.0 * rocking.period / rocking.rounding))
    time = np.linspace(0.0, rocking.period, samples + 1, dtype=np.float64)
    angle = np.array([rocking.point(t)[0] for t in time])
    return ToolMotion(time, rate_of_penetration, 0.0 * time, radius * angle, 1.0 + 0.0 * time)


def _harmonic(frequency: float) -> tuple[Series, Series]:
    if not (math.isfinite(frequency) and frequency > 0.0):
        raise InputError(f"harmonic motion: frequency = {frequency} Hz: must be positive and finite")
    phase = np.linspace(0.0, 2.0 * math.pi, SAMPLES + 1, dtype=np.float64)
    return phase / (2.0 * math.pi * frequency), np.sin(phase)


def _swing(speed_amplitude: float, frequency: float, radius: float) -> float:
    """Amplitude (m) of the surface's displacement that goes with an amplitude of rotation speed."""
    return speed_amplitude * radius / (2.0 * math.pi * frequency)
