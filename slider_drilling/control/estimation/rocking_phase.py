"""Phase of rocking at which an MWD sample was read, and a rocking period at which samples meet different phases.

A sample reads the toolface at some phase of the rocking cycle. Over many samples, the part that depends on the phase is
the swing of the bit. This works with any MWD period, unless the samples keep meeting the same phases.
"""

from __future__ import annotations

import functools
import math
from collections import deque

_KEPT_REVERSALS = 40
_MAX_STROKES_AHEAD = 2.0   # strokes after the last reversal for which the phase is extrapolated
# Least change of the phase between samples, in cycles, and least distance of it from half a cycle. A slow change makes
# the swing look like a toolface that turns slowly; half a cycle shows both sides of the swing, and is less harmful.
_MIN_CHANGE, _MIN_FROM_HALF = 0.2, 0.05
_MAX_LONGER, _MAX_SHORTER, _TRIAL_STEP = 0.12, 0.03, 0.01   # shares of the period


class RockingPhase:
    """Phase of rocking: half a turn per stroke."""

    def __init__(self) -> None:
        self._reversals: deque[float] = deque(maxlen=_KEPT_REVERSALS)   # s
        self._first = 0            # number of the oldest reversal kept

    def add_reversal(self, time: float) -> None:
        """Record that a stroke ended at `time` (s)."""
        if len(self._reversals) == _KEPT_REVERSALS:
            self._first += 1
        self._reversals.append(time)

    def at(self, time: float) -> float:
        """Phase (rad) at `time` (s); NaN before the strokes that are kept."""
        times = self._reversals
        if len(times) < 2 or time < times[0]:
            return math.nan
        for index in range(len(times) - 1, 0, -1):
            if times[index - 1] <= time:
                start, end = times[index - 1], times[index]
                strokes = min((time - start) / max(end - start, 1e-3), _MAX_STROKES_AHEAD)
                return math.pi * (self._first + index + strokes)
        return math.nan


@functools.lru_cache(maxsize=64)
def period_with_distinct_phases(period: float, sampling: float) -> float:
    """Rocking period closest to `period` at which samples meet different phases.

    Args:
        period: Wanted rocking period, s.
        sampling: Time between MWD samples, s.

    Returns:
        s; up to 12 % longer or 3 % shorter than `period`.
    """
    best, largest_margin = period, -1.0
    # Longer periods first: faster strokes reach less deep and swing the bit more.
    longer = [step * _TRIAL_STEP for step in range(round(_MAX_LONGER / _TRIAL_STEP) + 1)]
    shorter = [-step * _TRIAL_STEP for step in range(1, round(_MAX_SHORTER / _TRIAL_STEP) + 1)]
    for change in longer + shorter:
        candidate = period * (1.0 + change)
        phase_change = abs(math.remainder(sampling / candidate, 1.0))   # cycles
        margin = min(phase_change / _MIN_CHANGE, (0.5 - phase_change) / _MIN_FROM_HALF)
        if margin >= 1.0:
            return candidate
        if margin > largest_margin:
            best, largest_margin = candidate, margin
    return best
