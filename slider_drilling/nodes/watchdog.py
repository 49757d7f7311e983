"""Detects a silent rig by wall time, whatever the rig's own clock does."""

from __future__ import annotations

import time
from collections.abc import Callable

SLOW_RIG_FACTOR = 3.0  # a slow rig is silent after this many times its last interval between samples


class Watchdog:
    """Measures the wall time since the last sample.

    A simulation in slow motion, with a minute between two samples, does not count as silent.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._last_sample: float | None = None
        self._interval = 0.0

    def note_sample(self) -> None:
        """A sample has come."""
        now = self._now()
        self._interval = 0.0 if self._last_sample is None else now - self._last_sample
        self._last_sample = now

    def silent_for(self, stale_after: float) -> float:
        """Seconds since the last sample if they exceed `stale_after`, s, and the rig is not just slow; else 0."""
        if self._last_sample is None:
            return 0.0
        silence = self._now() - self._last_sample
        return silence if silence > max(stale_after, SLOW_RIG_FACTOR * self._interval) else 0.0
