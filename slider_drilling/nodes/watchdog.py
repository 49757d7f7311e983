"""When a rig has gone silent: by the wall's clock, whatever its own clock does."""

from __future__ import annotations

import time
from collections.abc import Callable

SLOW_MOTION = 3.0  # times the last pause between two samples before a slow rig counts as silent


class Watchdog:
    """Counts from the last sample; a rig in slow motion, a minute between two samples, is not silent."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._heard: float | None = None
        self._pause = 0.0

    def note_sample(self) -> None:
        """A sample has come."""
        now = self._now()
        self._pause = 0.0 if self._heard is None else now - self._heard
        self._heard = now

    def silent_for(self, stale_after: float) -> float:
        """Seconds of wall time without a sample, 0 while that is no silence yet; stale_after: s."""
        if self._heard is None:
            return 0.0
        silent = self._now() - self._heard
        return silent if silent > max(stale_after, SLOW_MOTION * self._pause) else 0.0
