"""Detects a silent rig by wall time, whatever the rig's own clock does."""

from __future__ import annotations

import time
from collections.abc import Callable

SLOW_RIG_FACTOR = 3.0  # a slow rig is silent after this many times its last interval between samples
MAX_TICK_INTERVAL = 0.3  # s between two checks, beyond which this process itself was stopped or starved
SILENCE_PERIOD = 1.0  # s of wall time between statuses, and commands to stop, while the rig is silent
CATCH_UP = 0.5  # s after such a stop within which samples that came meanwhile are received


class Watchdog:
    """Measures the wall time since the last sample.

    A simulation in slow motion, with a minute between two samples, does not count as silent. Nor does a rig whose
    samples wait because this process was stopped: silence counts only while the process itself runs.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._last_sample: float | None = None
        self._interval = 0.0
        self._last_tick: float | None = None
        self._catch_up_until = 0.0

    def restart(self) -> None:
        """Count silence from now on: what was before was not listened to."""
        if self._last_sample is not None:
            self._last_sample = self._now()
        self._last_tick = None

    def note_sample(self) -> None:
        """A sample has come."""
        now = self._now()
        self._interval = 0.0 if self._last_sample is None else now - self._last_sample
        self._last_sample = now

    def tick(self) -> bool:
        """Note a check, called every few hundredths of a second; whether samples may still wait after a stop."""
        now = self._now()
        if self._last_tick is not None and now - self._last_tick > MAX_TICK_INTERVAL:
            self._catch_up_until = now + CATCH_UP
            if self._last_sample is not None:
                self._last_sample += now - self._last_tick
        self._last_tick = now
        return now < self._catch_up_until

    def silent_for(self, stale_after: float) -> float:
        """Seconds since the last sample if they exceed `stale_after`, s, and the rig is not just slow; else 0."""
        if self._last_sample is None:
            return 0.0
        silence = self._now() - self._last_sample
        return silence if silence > max(stale_after, SLOW_RIG_FACTOR * self._interval) else 0.0
