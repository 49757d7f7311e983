"""How old a thing is that should come again and again, in units of its own period."""

from __future__ import annotations

import enum
import statistics
from collections import deque

LATE_PERIODS, LOST_PERIODS = 2.0, 5.0
_MIN_PERIOD = 1.0  # s; what comes more often may be late by as much on a busy machine
_REMEMBERED = 5  # intervals whose median is the period: one long silence does not change it


class Freshness(enum.Enum):
    """Whether a thing still comes."""

    FRESH = "fresh"
    LATE = "late"
    LOST = "lost"


class Arrivals:
    """When a thing came. Times are s of a monotonic clock."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._intervals: deque[float] = deque(maxlen=_REMEMBERED)

    def note(self, now: float) -> None:
        """It has come."""
        if self._last is not None:
            self._intervals.append(now - self._last)
        self._last = now

    def age(self, now: float) -> float:
        """Time since it came, s; 0 if it never did."""
        return 0.0 if self._last is None else now - self._last

    def freshness(self, now: float) -> Freshness:
        """Late after two periods, lost after five."""
        period = max(statistics.median(self._intervals) if self._intervals else 0.0, _MIN_PERIOD)
        if self.age(now) > LOST_PERIODS * period:
            return Freshness.LOST
        return Freshness.LATE if self.age(now) > LATE_PERIODS * period else Freshness.FRESH
