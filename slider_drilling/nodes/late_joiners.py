"""Notices, while an answer is missing, that it may be for want of hearing the question, or of being heard."""

from __future__ import annotations

import time
from collections.abc import Callable

RESEND_PERIOD = 1.0  # s of wall time before a newcomer is asked once more: DDS connects its two directions one by one
FIRST_RESEND_AFTER = (
    5.0  # s of wall time before those who were there from the start are asked once more, for the same reason
)


class LateJoiners:
    """present: the identities of the controllers that are there now; asked only while an answer is missing."""

    def __init__(self, present: Callable[[], set[bytes]], now: Callable[[], float] = time.monotonic) -> None:
        self._present = present
        self._now = now
        self._known: set[bytes] = set()
        self._waiting_ns: int | None = None
        self._is_waiting_for_newcomer = False
        self._asked = 0.0

    def start(self, stamp_ns: int) -> None:
        """Those who are there now hear the first sample, of this stamp; whether they are heard is not known yet."""
        self._known = self._present()
        self._waiting_ns, self._is_waiting_for_newcomer = stamp_ns, True
        self._asked = self._now() + FIRST_RESEND_AFTER - RESEND_PERIOD

    def should_resend(self, stamp_ns: int) -> bool:
        """Whether the sample of this stamp, which nobody has answered yet, is to be sent again now."""
        if stamp_ns != self._waiting_ns:
            self._waiting_ns, self._is_waiting_for_newcomer = stamp_ns, False
        present = self._present()
        if present - self._known:
            self._is_waiting_for_newcomer, self._asked = True, self._now() - RESEND_PERIOD
        self._known = present
        if not self._is_waiting_for_newcomer or self._now() - self._asked < RESEND_PERIOD:
            return False
        self._asked = self._now()
        return True
