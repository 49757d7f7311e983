"""Messages that never came, found by the numbers that their publisher gave the others."""

from __future__ import annotations


class SequenceCounter:
    """Follows the numbers of one topic's messages; each of its publishers counts for itself, from any number on.

    lost: how many were skipped so far. A publisher is known by its numbers alone, as rclpy tells no more of it: a
    number continues the publisher that is closest below it, and begins a new one where none is.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._latest: list[int] = []

    def count_missing(self, number: int) -> int:
        """How many messages are missing right before the one of this number."""
        before = max((latest for latest in self._latest if latest < number), default=None)
        if before is None:
            self._latest.append(number)
            return 0
        self._latest[self._latest.index(before)] = number
        self.lost += number - before - 1
        return number - before - 1
