"""Tells what a node hears of itself on a topic that it both publishes and listens to."""

from __future__ import annotations

from collections import deque


class OwnEchoes:
    """Messages sent that have not come back yet, byte for byte and in order.

    A stamp proves nothing: somebody else's message may have the same. An equal message that comes from somebody else
    while ours is on its way is taken for ours, and ours then for theirs: the same message either way.
    """

    def __init__(self) -> None:
        self._on_their_way: deque[bytes] = deque(maxlen=100)

    def add(self, data: bytes) -> None:
        """Note a message that is being published."""
        self._on_their_way.append(data)

    def is_own(self, data: bytes) -> bool:
        """Whether a message that was heard is one sent; those sent before it will not come any more."""
        if data not in self._on_their_way:
            return False
        while self._on_their_way.popleft() != data:
            pass
        return True
