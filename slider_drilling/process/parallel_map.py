"""Independent pieces of work on all cores: compiled loops run without the interpreter's lock.

Work may ask for more work to be done at once: who asks is at it, and as many others as have nothing to do, so that no
more are at work than there are cores for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import Any, TypeVar

from slider_drilling.process.jit_cache import available_threads

_Given = TypeVar("_Given")
_Made = TypeVar("_Made")


class _AtWork:
    """How many threads of the process are at work, the one that asks first being one of them."""

    def __init__(self) -> None:
        self._count, self._lock = 1, Lock()

    @property
    def idle(self) -> int:
        return max(available_threads() - self._count, 0)

    def add(self, change: int) -> None:
        with self._lock:
            self._count += change

    def call(self, wanted: int, most: int | None) -> int:
        """How many more are at work from now on: of those wanted the idle ones, or up to `most` in all."""
        with self._lock:
            called = max(min(wanted, self.idle if most is None else most - 1), 0)
            self._count += called
            return called


_AT_WORK = _AtWork()


def idle_threads() -> int:
    """How many threads have nothing to do."""
    return _AT_WORK.idle


def parallel_map(
    function: Callable[[_Given], _Made], given: Iterable[_Given], max_threads: int | None = None
) -> list[_Made]:
    """What the work makes of everything that is given, in its order; of what fails, the first in that order is raised.

    most: threads that are to be at it, whatever else is done; by default those that have nothing to do.
    """
    items = list(given)
    called = _AT_WORK.call(len(items) - 1, max_threads)
    if not called:
        return [function(item) for item in items]
    made: list[Any] = [None] * len(items)
    failed: dict[int, BaseException] = {}
    left = iter(range(len(items)))

    def go_on() -> None:
        index = -1
        try:
            for index in left:
                if failed:
                    break
                made[index] = function(items[index])
        except BaseException as error:
            failed[index] = error
        finally:
            _AT_WORK.add(-1)

    try:
        with ThreadPoolExecutor(called) as pool:
            for _ in range(called):
                pool.submit(go_on)
            go_on()
    finally:
        _AT_WORK.add(1)
    if failed:
        raise failed[min(failed)]
    return made
