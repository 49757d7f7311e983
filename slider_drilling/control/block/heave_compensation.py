"""Heave compensation: a wave that moves the block is found in the hook load and cancelled by block speed.

The string is a spring below the block. A line in the spectrum of the hook load, at a period of sea waves, is heave. The
block moves against it, with the amplitude and phase that make the line vanish. The stiffness of the string may be
inaccurate: what remains of the line shows what is still missing (integral action).

Strokes to the right and to the left free the same pipe from its axial drag, so rocking changes the hook load twice per
cycle. Lines close to the even harmonics of rocking are therefore ignored; a line at the rocking period itself is heave.
"""

from __future__ import annotations

import functools
import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_MIN_PERIOD, _MAX_PERIOD, _PERIODS = 4.5, 22.0, 240   # s, s, and number of the periods searched
_WINDOW, _SEARCH_INTERVAL, _SAMPLING = 90.0, 15.0, 0.5   # s: of the spectrum, between searches, between its samples
_LINE_OVER_MEDIAN = 6.0   # of the spectrum, above which a peak is a line
_MIN_AMPLITUDE = 0.02     # m of block movement; a smaller wave does no harm
_KEPT_AMPLITUDE = 0.25    # of the minimum; a larger compensation keeps its period
_ROCKING_WIDTH = 2.2      # spectral lines to either side of an even harmonic of rocking that are ignored
_LEARNING_TIME = 40.0     # s, time constant of the compensation
_ROCKING_HARMONICS = (2, 4)


class HeaveCompensator:
    """Block speed against heave.

    Args:
        stiffness: Of the whole string, N/m.
        max_speed: Of the block against a wave, m/s; 0 turns the compensation off.

    Attributes:
        moved: Displacement of the block by the compensation, m.
        period: Of the wave, s; NaN where none was found.
        line_amplitude: Of the highest line in the last spectrum, m.
        saturated: Whether the drawworks are too slow for the wave.
    """

    def __init__(self, stiffness: float, max_speed: float):
        self._stiffness = stiffness
        self.max_speed = max_speed
        self._samples: deque[float] = deque(maxlen=round(_WINDOW / _SAMPLING))   # N
        self._clock = self._since_sample = self._since_search = 0.0   # s
        self._sum, self._count = 0.0, 0
        self._mean_load = math.nan        # N
        self._cosine = self._sine = 0.0   # m, parts of the compensation
        self.moved = 0.0
        self.period = math.nan
        self.line_amplitude = 0.0
        self.saturated = False

    @property
    def amplitude(self) -> float:
        """Amplitude of the compensation, m."""
        return math.hypot(self._cosine, self._sine)

    def update(self, hook_load: float, rocking_period: float, active: bool, step: float) -> float:
        """Take one sample and return the speed to add to the block's, m/s.

        Args:
            hook_load: N; NaN where unknown.
            rocking_period: s.
            active: Whether the block may move.
            step: Time since the last sample, s.
        """
        self._clock += step
        self._collect(hook_load, rocking_period, step)
        if math.isnan(self.period) or self.max_speed <= 0.0 or not active or step <= 0.0:
            return 0.0
        frequency = 2.0 * math.pi / self.period   # rad/s
        cosine, sine = math.cos(frequency * self._clock), math.sin(frequency * self._clock)
        if math.isfinite(hook_load):
            self._learn(hook_load, cosine, sine, step)
        self._limit(self.max_speed / frequency)
        # Track the position: integrating a speed whose amplitude is still being learnt would drift away.
        position_error = self._cosine * cosine + self._sine * sine - self.moved
        speed = min(max(position_error / step, -self.max_speed), self.max_speed)
        self.moved += speed * step
        return speed

    def _learn(self, hook_load: float, cosine: float, sine: float, step: float) -> None:
        """Correct the compensation by what remains of the wave in the hook load."""
        weight = 1.0 - math.exp(-step / (3.0 * self.period))
        mean = self._mean_load
        self._mean_load = hook_load if math.isnan(mean) else mean + weight * (hook_load - mean)
        # A block that is too low lowers the load by the stiffness times its displacement: raise it there.
        displacement = (hook_load - self._mean_load) / self._stiffness
        gain = 2.0 * step / _LEARNING_TIME
        self._cosine += gain * displacement * cosine
        self._sine += gain * displacement * sine

    def _limit(self, max_amplitude: float) -> None:
        self.saturated = self.amplitude > max_amplitude
        if self.saturated:
            scale = max_amplitude / self.amplitude
            self._cosine, self._sine = scale * self._cosine, scale * self._sine

    def _collect(self, hook_load: float, rocking_period: float, step: float) -> None:
        if math.isfinite(hook_load):
            self._sum += hook_load
            self._count += 1
        self._since_sample += step
        self._since_search += step
        if self._since_sample >= _SAMPLING and self._count:
            self._samples.append(self._sum / self._count)
            self._since_sample, self._sum, self._count = 0.0, 0.0, 0
        if self._since_search >= _SEARCH_INTERVAL and len(self._samples) == self._samples.maxlen:
            self._since_search = 0.0
            self._search(rocking_period)

    def _search(self, rocking_period: float) -> None:
        """Look for a line in the spectrum, unless a wave is being compensated."""
        if self.amplitude > _KEPT_AMPLITUDE * _MIN_AMPLITUDE and not math.isnan(self.period):
            return
        values = np.array(self._samples)
        time, periods, waves = _spectrum(len(values))
        values = (values - np.polyval(np.polyfit(time, values, 3), time)) * np.hanning(len(values))
        amplitude = np.abs(waves @ values) * 2.0 / (0.5 * len(values)) / self._stiffness
        for harmonic in _ROCKING_HARMONICS:
            amplitude[np.abs(1.0 / periods - harmonic / rocking_period) < _ROCKING_WIDTH / _WINDOW] = 0.0
        highest = int(np.argmax(amplitude))
        threshold = max(_LINE_OVER_MEDIAN * float(np.median(amplitude)), _MIN_AMPLITUDE)
        is_line = amplitude[highest] > threshold and 0 < highest < len(periods) - 1
        self.line_amplitude = float(amplitude[highest])
        self.period = float(periods[highest]) if is_line else math.nan


@functools.lru_cache(maxsize=1)
def _spectrum(samples: int) -> tuple[Array, Array, NDArray[np.complex128]]:
    """Instants (samples,) s, periods (240,) s, and the waves (240, samples) of those periods at those instants."""
    time = np.asarray(np.arange(samples) * _SAMPLING, dtype=np.float64)
    periods = np.asarray(1.0 / np.linspace(1.0 / _MAX_PERIOD, 1.0 / _MIN_PERIOD, _PERIODS), dtype=np.float64)
    return time, periods, np.exp(-2.0j * math.pi * np.outer(1.0 / periods, time))
