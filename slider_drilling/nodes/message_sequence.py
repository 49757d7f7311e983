"""Counts messages that never came, from the sequence numbers of the others."""

from __future__ import annotations

from collections.abc import Callable


class SequenceCounter:
    """Follows the sequence numbers of one topic's messages; each publisher counts for itself.

    A recorder that is started late receives a publisher's messages from any number on. rclpy does not say which
    publisher sent a message, but the graph says which publishers (by their GIDs) there are. A number that continues
    none of the sequences starts the one of a publisher that has not been heard yet. It shows a loss only if all
    publishers have been heard: the one whose last number is closest below it then skipped the numbers in between.

    Args:
        publisher_ids: Returns the GIDs of the topic's present publishers; called only for such numbers.

    Attributes:
        lost: Count of the messages that never came.
    """

    def __init__(self, publisher_ids: Callable[[], set[bytes]]) -> None:
        self.lost = 0
        self._publisher_ids = publisher_ids
        self._publishers: set[bytes] = set()  # all that were ever seen
        self._latest: list[int] = []  # one for each publisher that was heard

    def count_missing(self, number: int) -> int:
        """How many messages are missing directly before the one of this sequence number."""
        if number - 1 in self._latest:
            self._latest[self._latest.index(number - 1)] = number
            return 0
        self._publishers |= self._publisher_ids()
        before = max((latest for latest in self._latest if latest < number), default=None)
        if before is None or len(self._publishers) > len(self._latest):
            self._latest.append(number)
            return 0
        self._latest[self._latest.index(before)] = number
        self.lost += number - before - 1
        return number - before - 1
