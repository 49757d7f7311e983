"""Where within rocking an MWD sample was read, and a period of rocking at which samples do not keep meeting one phase.

A sample reads the toolface somewhere within a cycle. Over many samples the part that goes with the phase is the swing
that rocking leaves at the bit, whatever period MWD has, unless that keeps meeting the same phases.
"""

from __future__ import annotations

import functools
import math
from collections import deque

_KEPT = 40                          # reversals
# Of a cycle, least step of the phase from sample to sample, and least from half a cycle: a swing that samples meet a
# little later each time looks like a toolface that turns slowly, one that they meet from either side does not.
_NEAR, _NEAR_HALF = 0.2, 0.05
_LONGER, _SHORTER, _TRIED = 0.12, 0.03, 0.01   # shares by which the period may be changed, and of one trial


class RockingPhase:
    """The phase of rocking: half a turn a stroke."""

    def __init__(self) -> None:
        self._reversals: deque[float] = deque(maxlen=_KEPT)   # s
        self._first = 0            # number of the oldest one kept

    def add_reversal(self, time: float) -> None:
        """A stroke has ended at `time` (s)."""
        if len(self._reversals) == _KEPT:
            self._first += 1
        self._reversals.append(time)

    def at(self, time: float) -> float:
        """rad at `time` (s); NaN before the strokes that are kept."""
        times = self._reversals
        if len(times) < 2 or time < times[0]:
            return math.nan
        for index in range(len(times) - 1, 0, -1):
            if times[index - 1] <= time:
                start, end = times[index - 1], times[index]
                return math.pi * (self._first + index + min((time - start) / max(end - start, 1e-3), 2.0))
        return math.nan


@functools.lru_cache(maxsize=64)
def period_with_distinct_phases(period: float, sampling: float) -> float:
    """The period of rocking (s) next to `period` at which samples every `sampling` (s) meet unlike phases."""
    best, widest = period, -1.0
    # Longer first: faster strokes reach less deep, and swing the bit more.
    longer = [step * _TRIED for step in range(round(_LONGER / _TRIED) + 1)]
    shorter = [-step * _TRIED for step in range(1, round(_SHORTER / _TRIED) + 1)]
    for change in longer + shorter:
        tried = period * (1.0 + change)
        apart_by = abs(math.remainder(sampling / tried, 1.0))   # cycles
        distance = min(apart_by / _NEAR, (0.5 - apart_by) / _NEAR_HALF)
        if distance >= 1.0:
            return tried
        if distance > widest:
            best, widest = tried, distance
    return best
