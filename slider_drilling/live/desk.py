"""What the page asks of the graph, handed from the page's thread to the node's."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from dataclasses import dataclass

MOST_WAITING = 100


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
class Rock:
    """Start or stop rocking."""

    on: bool


@dataclass(frozen=True)
class Record:
    """Go on or pause recording."""

    on: bool


Wish = SetParameter | SetTarget | Rock | Record


class Desk:
    """Wishes in the order in which they came; more than fit are refused."""

    def __init__(self) -> None:
        self._waiting: queue.Queue[Wish] = queue.Queue(MOST_WAITING)

    def ask(self, wish: Wish) -> bool:
        """Leave a wish; False where nobody has taken the ones before."""
        try:
            self._waiting.put_nowait(wish)
        except queue.Full:
            return False
        return True

    def take(self) -> Iterator[Wish]:
        """The wishes that wait, each once."""
        while True:
            try:
                yield self._waiting.get_nowait()
            except queue.Empty:
                return
