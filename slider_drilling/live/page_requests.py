"""Requests of the page to the nodes, passed from the page's thread to the dashboard node's."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from dataclasses import dataclass

MAX_REQUESTS = 100


@dataclass(frozen=True)
class SetParameter:
    """Set a parameter of a node."""

    node: str
    name: str
    value: float


@dataclass(frozen=True)
class SetTarget:
    """Hold another toolface; target: rad."""

    target: float


@dataclass(frozen=True)
class SetRocking:
    """Start or stop rocking."""

    on: bool


@dataclass(frozen=True)
class SetRecording:
    """Resume or pause recording."""

    on: bool


@dataclass(frozen=True)
class DiagnoseNow:
    """Ask the twin for a diagnosis."""


PageRequest = SetParameter | SetTarget | SetRocking | SetRecording | DiagnoseNow


class RequestQueue:
    """A queue of at most MAX_REQUESTS requests."""

    def __init__(self) -> None:
        self._waiting: queue.Queue[PageRequest] = queue.Queue(MAX_REQUESTS)

    def put(self, request: PageRequest) -> bool:
        """Add a request; False if the queue is full, because no node takes requests."""
        try:
            self._waiting.put_nowait(request)
        except queue.Full:
            return False
        return True

    def take(self) -> Iterator[PageRequest]:
        """Remove and yield the waiting requests."""
        while True:
            try:
                yield self._waiting.get_nowait()
            except queue.Empty:
                return
