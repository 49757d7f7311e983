"""Recognises a node's own messages on a topic that it both publishes and subscribes to."""

from __future__ import annotations

from collections import deque

MAX_PENDING = 100


class OwnEchoes:
    """The messages that were published and have not come back yet, in order.

    Messages are compared byte for byte: a stamp proves nothing, since another node's message may have the same. If
    another node sends an equal message, the two are mistaken for each other, which makes no difference.
    """

    def __init__(self) -> None:
        self._pending: deque[bytes] = deque(maxlen=MAX_PENDING)

    def add(self, data: bytes) -> None:
        """Note a message that is being published."""
        self._pending.append(data)

    def is_own(self, data: bytes) -> bool:
        """Whether a received message is an own one; those published before it will not come any more."""
        if data not in self._pending:
            return False
        while self._pending.popleft() != data:
            pass
        return True
