"""Counts messages that never came, from the sequence numbers of the others."""

from __future__ import annotations


class SequenceCounter:
    """Follows the sequence numbers of one topic's messages; each publisher counts for itself, from any number on.

    rclpy does not say which publisher sent a message. A number continues the publisher whose last number is closest
    below it; if there is none, it belongs to a new publisher.

    Attributes:
        lost: Count of the messages that never came.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._latest: list[int] = []

    def count_missing(self, number: int) -> int:
        """How many messages are missing directly before the one of this sequence number."""
        before = max((latest for latest in self._latest if latest < number), default=None)
        if before is None:
            self._latest.append(number)
            return 0
        self._latest[self._latest.index(before)] = number
        self.lost += number - before - 1
        return number - before - 1
