"""Times of a rig's clock in words: of day where it has a date, in s where it counts from a start."""

from __future__ import annotations

import datetime

_FIRST_DATE_S = 946684800.0  # 2000-01-01: earlier stamps count from the start of a simulation or a recording


def has_date(seconds: float) -> bool:
    """Whether so many s since the epoch are a date, and not a time since some start."""
    return seconds >= _FIRST_DATE_S


def time_of_day(seconds: float) -> str:
    """A time of a rig's clock (s): "14:05:10 UTC", or "1203 s" where the clock has no date."""
    if not has_date(seconds):
        return f"{seconds:.0f} s"
    return f"{datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc):%H:%M:%S} UTC"
