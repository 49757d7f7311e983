"""Heave: a wave that moves the block, found in the hook load and taken out of it by block speed.

The string is a spring below the block. A line in the spectrum of the hook load, at a period of waves, is the wave; the
block is then moved against it, by as much as makes the line vanish. The string's stiffness need not be known well: what
is left of the line tells what is still missing.

Rocking hides no wave. A stroke to the right frees as much pipe from its drag as one to the left, so what rocking
leaves in the hook load comes twice a cycle: a line once a cycle is a wave, even one of rocking's own period. Only what
lies next to its even harmonics may be rocking's.
"""

from __future__ import annotations

import functools
import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_SHORTEST, _LONGEST = 4.5, 22.0    # s, of waves
_WINDOW, _EVERY, _SAMPLING = 90.0, 15.0, 0.5   # s: of the spectrum, between two looks, between its samples
_CLEAR = 6.0            # of the median of the spectrum, from which a peak is a line
_LEAST = 0.02           # m, of block movement, below which a wave does no harm
_OF_ROCKING = 2.2       # lines of the spectrum to either side of an even harmonic of rocking that may be rocking's
_LEARNING = 40.0        # s, in which the compensation takes up what is left
_HARMONICS = (2, 4)


class HeaveCompensator:
    """stiffness: N/m, of the whole string; fastest: m/s, of the block against a wave, 0 for none."""

    def __init__(self, stiffness: float, fastest: float):
        self._stiffness = stiffness
        self.fastest = fastest
        self._seen: deque[float] = deque(maxlen=round(_WINDOW / _SAMPLING))   # N
        self._clock = self._since_sample = self._since_look = 0.0
        self._sum, self._count = 0.0, 0
        self._slow = math.nan           # N, mean of the hook load
        self._cosine = self._sine = 0.0   # m, of the block's compensation
        self.moved = 0.0               # m, of the block by this
        self.period = math.nan          # s, of the wave, NaN where none was found
        self.left = 0.0                 # m, amplitude that the spectrum shows
        self.short = False              # the drawworks cannot follow

    @property
    def amplitude(self) -> float:
        """m, of the compensation."""
        return math.hypot(self._cosine, self._sine)

    def update(self, hook_load: float, rocking_period: float, active: bool, step: float) -> float:
        """Take a sample (N, NaN where there is none) and give the speed (m/s) to add to the block's. active: whether
        the block may move."""
        self._clock += step
        self._collect(hook_load, rocking_period, step)
        if math.isnan(self.period) or self.fastest <= 0.0 or not active or step <= 0.0:
            return 0.0
        turn = 2.0 * math.pi / self.period
        cosine, sine = math.cos(turn * self._clock), math.sin(turn * self._clock)
        if math.isfinite(hook_load):
            kept = 1.0 - math.exp(-step / (3.0 * self.period))
            self._slow = hook_load if math.isnan(self._slow) else self._slow + kept * (hook_load - self._slow)
            # The load falls by the stiffness where the block is too low: raise it there.
            off = (hook_load - self._slow) / self._stiffness
            share = 2.0 * step / _LEARNING
            self._cosine += share * off * cosine
            self._sine += share * off * sine
        most = self.fastest / turn
        self.short = self.amplitude > most
        if self.short:
            scale = most / self.amplitude
            self._cosine, self._sine = scale * self._cosine, scale * self._sine
        # By differences of position: a sum of speeds whose amplitude is being learnt would walk away.
        behind = self._cosine * cosine + self._sine * sine - self.moved
        speed = min(max(behind / step, -self.fastest), self.fastest)
        self.moved += speed * step
        return speed

    def _collect(self, hook_load: float, rocking_period: float, step: float) -> None:
        if math.isfinite(hook_load):
            self._sum += hook_load
            self._count += 1
        self._since_sample += step
        self._since_look += step
        if self._since_sample >= _SAMPLING and self._count:
            self._seen.append(self._sum / self._count)
            self._since_sample, self._sum, self._count = 0.0, 0.0, 0
        if self._since_look >= _EVERY and len(self._seen) == self._seen.maxlen:
            self._since_look = 0.0
            self._look(rocking_period)

    def _look(self, rocking_period: float) -> None:
        """Look for a line, unless a wave is being compensated."""
        if self.amplitude > 0.25 * _LEAST and not math.isnan(self.period):
            return
        values = np.array(self._seen)
        time, periods, waves = _spectrum(len(values))
        values = (values - np.polyval(np.polyfit(time, values, 3), time)) * np.hanning(len(values))
        amplitude = np.abs(waves @ values) * 2.0 / (0.5 * len(values)) / self._stiffness
        for harmonic in _HARMONICS:
            amplitude[np.abs(1.0 / periods - harmonic / rocking_period) < _OF_ROCKING / _WINDOW] = 0.0
        best = int(np.argmax(amplitude))
        line = amplitude[best] > max(_CLEAR * float(np.median(amplitude)), _LEAST) and 0 < best < len(periods) - 1
        self.left = float(amplitude[best])
        self.period = float(periods[best]) if line else math.nan


@functools.lru_cache(maxsize=1)
def _spectrum(samples: int) -> tuple[Array, Array, NDArray[np.complex128]]:
    """Instants (samples,) s, periods (240,) s, and the waves (240, samples) of those periods at those instants."""
    time = np.asarray(np.arange(samples) * _SAMPLING, dtype=np.float64)
    periods = np.asarray(1.0 / np.linspace(1.0 / _LONGEST, 1.0 / _SHORTEST, 240), dtype=np.float64)
    return time, periods, np.exp(-2.0j * math.pi * np.outer(1.0 / periods, time))
