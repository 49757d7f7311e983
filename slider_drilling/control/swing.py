"""What rocking leaves at the bit: its swing at the period of rocking, from MWD samples at known phases.

A sample reads the tool-face somewhere within a cycle. Over many samples the part that goes with the phase is the swing,
whatever period MWD has, unless that keeps meeting the same phases: `apart` finds a period of rocking that does not.
"""

from __future__ import annotations

import functools
import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_MEMORY = 120.0                     # s, over which samples are forgotten
_FADED_EVERY = 1.0                  # s
_PRIOR = math.radians(3.0)          # rad, of each part of the swing before any sample
_SCATTER_SHARE = 0.15               # of one sample
_MOST_SCATTER = math.radians(10.0)  # rad, that one sample may show
_LEAST_APART = math.radians(60.0)   # of phase, between them
_APART = 60.0                       # s, between samples that are held against each other
_KEPT = 40                          # reversals
_NEAR = 0.1                         # of a cycle: what phases of consecutive samples differ by, half from half a cycle
_LONGER, _SHORTER, _TRIED = 0.12, 0.06, 0.01   # shares by which the period may be changed, and of one trial


class Swing:
    """noise: rad, one standard deviation of a sample about the mean tool-face and its swing."""

    def __init__(self, noise: float):
        self._noise = noise
        self._reversals: deque[float] = deque(maxlen=_KEPT)   # s
        self._first = 0            # number of the oldest one kept
        self._information: Array = np.zeros((2, 2))   # of cosine and sine, 1/rad2
        self._told: Array = np.zeros(2)
        self._scatter = noise**2   # rad2, of a sample
        self._last: tuple[float, float, float] | None = None   # s, rad of phase, rad
        self._parts: Array = np.zeros(2)
        self._covariance: Array = np.eye(2) * _PRIOR**2
        self._unfaded = 0.0        # s

    def reversal(self, time: float) -> None:
        """A stroke has ended at `time` (s)."""
        if len(self._reversals) == _KEPT:
            self._first += 1
        self._reversals.append(time)

    def phase(self, time: float) -> float:
        """rad, half a turn a stroke; NaN before the strokes that are kept."""
        times = self._reversals
        if len(times) < 2 or time < times[0]:
            return math.nan
        for index in range(len(times) - 1, 0, -1):
            if times[index - 1] <= time:
                start, end = times[index - 1], times[index]
                return math.pi * (self._first + index + min((time - start) / max(end - start, 1e-3), 2.0))
        return math.nan

    def update(self, time: float, residual: float) -> None:
        """Take a sample read at `time` (s), `residual` (rad) beyond what was held for the mean tool-face."""
        phase = self.phase(time)
        if math.isnan(phase):
            return
        if self._last is not None and 0.0 <= phase - self._last[1] < _LEAST_APART:
            return   # as good as the same phase: the two say nothing of the swing
        before, self._last = self._last, (time, phase, residual)
        if before is None or not 0.0 < time - before[0] <= _APART:
            return
        # Differences: what is held for the mean tool-face errs slowly.
        row = np.array([math.cos(phase) - math.cos(before[1]), math.sin(phase) - math.sin(before[1])])
        change = math.remainder(residual - before[2], 2.0 * math.pi)
        left = change - float(row @ self._parts)
        # What the samples leave, where that is more than their own noise.
        self._scatter += _SCATTER_SHARE * (min(0.5 * left * left, _MOST_SCATTER**2) - self._scatter)
        variance = 2.0 * max(self._scatter, self._noise**2)
        self._information += np.outer(row, row) / variance
        self._told += row * change / variance
        self._solve()

    def _solve(self) -> None:
        self._covariance = np.asarray(np.linalg.inv(self._information + np.eye(2) / _PRIOR**2), dtype=np.float64)
        self._parts = self._covariance @ self._told

    def fade(self, step: float) -> None:
        """`step` s have passed: what is not renewed is forgotten, a second's worth at a time."""
        self._unfaded += step
        if self._unfaded < _FADED_EVERY:
            return
        kept = math.exp(-self._unfaded / _MEMORY)
        self._unfaded = 0.0
        self._information *= kept
        self._told *= kept
        self._solve()

    @property
    def amplitude(self) -> float:
        """rad, less what noise adds to it."""
        cosine, sine = self._parts
        return math.sqrt(max(cosine**2 + sine**2 - self._covariance[0, 0] - self._covariance[1, 1], 0.0))

    @property
    def spread(self) -> float:
        """rad, one standard deviation."""
        return math.sqrt(0.5 * (self._covariance[0, 0] + self._covariance[1, 1]))

    def at(self, time: float) -> float:
        """rad, of the swing at `time` (s) as far as it is known."""
        phase = self.phase(time)
        if math.isnan(phase):
            return 0.0
        return float(self._parts[0] * math.cos(phase) + self._parts[1] * math.sin(phase))


@functools.lru_cache(maxsize=64)
def apart(period: float, sampling: float) -> float:
    """The period of rocking (s) next to `period` at which samples every `sampling` (s) meet unlike phases."""
    best, widest = period, -1.0
    # Longer first: faster strokes reach less deep, and swing the bit more.
    longer = [step * _TRIED for step in range(round(_LONGER / _TRIED) + 1)]
    shorter = [-step * _TRIED for step in range(1, round(_SHORTER / _TRIED) + 1)]
    for change in longer + shorter:
        tried = period * (1.0 + change)
        apart_by = abs(math.remainder(sampling / tried, 1.0))   # cycles
        distance = min(apart_by, 2.0 * (0.5 - apart_by))
        if distance >= _NEAR:
            return tried
        if distance > widest:
            best, widest = tried, distance
    return best
