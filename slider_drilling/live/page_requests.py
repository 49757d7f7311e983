"""What the page asks of the graph, handed from the page's thread to the node's."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from dataclasses import dataclass

MAX_REQUESTS = 100


@dataclass(frozen=True)
class SetParameter:
    """Give a parameter of a node a value."""

    node: str
    name: str
    value: float


@dataclass(frozen=True)
class SetTarget:
    """Hold another toolface, rad."""

    target: float


@dataclass(frozen=True)
class SetRocking:
    """Start or stop rocking."""

    on: bool


@dataclass(frozen=True)
class SetRecording:
    """Go on or pause recording."""

    on: bool


PageRequest = SetParameter | SetTarget | SetRocking | SetRecording


class RequestQueue:
    """Wishes in the order in which they came; more than fit are refused."""

    def __init__(self) -> None:
        self._waiting: queue.Queue[PageRequest] = queue.Queue(MAX_REQUESTS)

    def put(self, wish: PageRequest) -> bool:
        """Leave a wish; False where nobody has taken the ones before."""
        try:
            self._waiting.put_nowait(wish)
        except queue.Full:
            return False
        return True

    def take(self) -> Iterator[PageRequest]:
        """The wishes that wait, each once."""
        while True:
            try:
                yield self._waiting.get_nowait()
            except queue.Empty:
                return
