"""Independent pieces of work on all cores: compiled loops run without the interpreter's lock."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from slider_drilling.compiler import threads

_Given = TypeVar("_Given")
_Made = TypeVar("_Made")


def at_once(work: Callable[[_Given], _Made], given: Iterable[_Given]) -> list[_Made]:
    """What the work makes of everything that is given, in its order; the first exception is raised."""
    items = list(given)
    if threads() == 1 or len(items) < 2:
        return [work(item) for item in items]
    with ThreadPoolExecutor(threads()) as pool:
        return list(pool.map(work, items))
