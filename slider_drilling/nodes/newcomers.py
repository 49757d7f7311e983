"""Notices, while an answer is missing, that a controller has come that was not there when the question was asked."""

from __future__ import annotations

import time
from collections.abc import Callable

AGAIN = 1.0  # s of wall time before a newcomer is asked once more: DDS connects its two directions one by one


class Newcomers:
    """present: the identities of the controllers that are there now; asked only while an answer is missing."""

    def __init__(self, present: Callable[[], set[bytes]], now: Callable[[], float] = time.monotonic) -> None:
        self._present = present
        self._now = now
        self._known: set[bytes] = set()
        self._waiting_ns: int | None = None
        self._is_waiting_for_newcomer = False
        self._asked = 0.0

    def begin(self) -> None:
        """Those who are there now are no newcomers."""
        self._known = self._present()

    def wait_for(self, stamp_ns: int) -> bool:
        """Whether the sample of this stamp, which nobody has answered yet, is to be sent again now."""
        if stamp_ns != self._waiting_ns:
            self._waiting_ns, self._is_waiting_for_newcomer = stamp_ns, False
        present = self._present()
        if present - self._known:
            self._is_waiting_for_newcomer, self._asked = True, self._now() - AGAIN
        self._known = present
        if not self._is_waiting_for_newcomer or self._now() - self._asked < AGAIN:
            return False
        self._asked = self._now()
        return True
