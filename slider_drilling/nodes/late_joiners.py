"""Decides when to resend a sample: an answer may be missing because the request or the reply was lost."""

from __future__ import annotations

import time
from collections.abc import Callable

RESEND_PERIOD = 1.0  # s of wall time between resends: DDS connects the two directions one after the other
FIRST_RESEND_AFTER = 5.0  # s of wall time before the first sample is resent to the controllers of the start


class LateJoiners:
    """Tracks which controllers are there, to resend a sample to one that joined after it was sent.

    Args:
        controller_ids: Returns the identities of the present controllers; called only while an answer is missing.
        now: Wall time, s.
    """

    def __init__(self, controller_ids: Callable[[], set[bytes]], now: Callable[[], float] = time.monotonic) -> None:
        self._controller_ids = controller_ids
        self._now = now
        self._known: set[bytes] = set()
        self._stamp_ns: int | None = None
        self._is_resending = False
        self._last_sent = 0.0

    def start(self, stamp_ns: int) -> None:
        """Note the controllers that receive the first sample; whether their replies arrive is not known yet."""
        self._known = self._controller_ids()
        self._stamp_ns, self._is_resending = stamp_ns, True
        self._last_sent = self._now() + FIRST_RESEND_AFTER - RESEND_PERIOD

    def should_resend(self, stamp_ns: int) -> bool:
        """Whether to resend the sample of this stamp, which nobody has answered yet."""
        if stamp_ns != self._stamp_ns:
            self._stamp_ns, self._is_resending = stamp_ns, False
        present = self._controller_ids()
        if present - self._known:
            self._is_resending, self._last_sent = True, self._now() - RESEND_PERIOD
        self._known = present
        if not self._is_resending or self._now() - self._last_sent < RESEND_PERIOD:
            return False
        self._last_sent = self._now()
        return True
