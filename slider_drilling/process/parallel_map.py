"""Maps a function over items on all cores with threads: compiled loops run without the interpreter's lock.

Tasks may start nested maps. The calling thread and any idle threads run them, so the process never runs more threads
than there are cores. `concurrent.futures` alone would start new threads for each nested map.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from threading import Lock
from typing import Any, TypeVar

from slider_drilling.process.jit_cache import available_threads

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


class _ThreadBudget:
    """Counts the running threads of the process; the one that starts a first map is one of them."""

    def __init__(self) -> None:
        self._running, self._lock = 1, Lock()

    @property
    def idle(self) -> int:
        return max(available_threads() - self._running, 0)

    def release(self) -> None:
        """One thread has ended."""
        with self._lock:
            self._running -= 1

    def resume(self) -> None:
        """The calling thread goes on after its map."""
        with self._lock:
            self._running += 1

    def reserve(self, wanted: int, max_threads: int | None) -> int:
        """Reserve up to `wanted` more threads and return their number."""
        with self._lock:
            reserved = max(min(wanted, self.idle if max_threads is None else max_threads - 1), 0)
            self._running += reserved
            return reserved


_BUDGET = _ThreadBudget()
# Threads live on between maps: a new one starts late where other programs wait for a core. It starts as many as are
# reserved at once, and never more than this.
_POOL = ThreadPoolExecutor(256, "parallel_map")


def idle_threads() -> int:
    """How many threads a map could start now beside the calling one."""
    return _BUDGET.idle


def parallel_map(
    function: Callable[[_Item], _Result], items: Iterable[_Item], max_threads: int | None = None
) -> list[_Result]:
    """Apply a function to every item.

    Args:
        function: Called from several threads.
        items: In the order of the results.
        max_threads: How many threads to use, the calling one included; by default it and all idle ones.

    Returns:
        The results in the order of the items, whatever the number of threads.

    Raises:
        Exception: What `function` raised; of several failures that of the first item.
    """
    items = list(items)
    reserved = _BUDGET.reserve(len(items) - 1, max_threads)
    if not reserved:
        return [function(item) for item in items]
    results: list[Any] = [None] * len(items)
    errors: dict[int, BaseException] = {}
    remaining = iter(range(len(items)))

    def work() -> None:
        index = -1
        try:
            for index in remaining:
                if errors:
                    break
                results[index] = function(items[index])
        except BaseException as error:
            errors[index] = error
        finally:
            # Idle for nested maps of other tasks from here on.
            _BUDGET.release()

    helpers = [_POOL.submit(work) for _ in range(reserved)]
    try:
        work()
    finally:
        for helper in helpers:
            if helper.cancel():
                _BUDGET.release()
        wait(helpers)
        _BUDGET.resume()
    if errors:
        raise errors[min(errors)]
    return results
