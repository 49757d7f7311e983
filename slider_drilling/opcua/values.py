"""What a server's values are worth: numbers, and the heartbeat that shows that the rig behind the server lives."""

from __future__ import annotations

import math
from typing import Any


def usable_number(value: Any) -> float | None:
    """The number of a data value; None for one of bad quality, and for text, null, NaN, an array or a truth value."""
    raw = _good_value(value)
    if isinstance(raw, bool) or not isinstance(raw, (int, float)) or not math.isfinite(raw):
        return None
    return float(raw)


def _good_value(value: Any) -> Any:
    return value.Value.Value if value.StatusCode.is_good() and value.Value is not None else None


class Heartbeat:
    """Whether a value has changed of late: a server goes on giving the last values of a dead rig.

    Args:
        timeout: Time without a change after which the rig is dead, s.
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._last: Any = None
        self._changed_at: float | None = None

    def update(self, value: Any, now: float) -> bool:
        """Take a data value; True while the rig lives.

        A first value proves nothing, nor does one of bad quality, null or NaN: NaN differs from itself.

        Args:
            value: As read from the server.
            now: Monotonic time, s.
        """
        beat = _good_value(value)
        is_usable = beat is not None and not (isinstance(beat, float) and not math.isfinite(beat))
        if is_usable and beat != self._last:
            self._changed_at = None if self._last is None else now
            self._last = beat
        return self._changed_at is not None and now - self._changed_at < self._timeout
