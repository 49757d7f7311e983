"""Runs calls in worker processes that end with this process, however it ends."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")
_CHECK_PERIOD = 0.5  # s between two looks whether the parent lives


def map_in_processes(function: Callable[..., T], calls: Iterable[tuple[object, ...]], jobs: int) -> Iterator[T]:
    """Call a function in worker processes.

    Args:
        function: Can be pickled.
        calls: The arguments of each call.
        jobs: How many processes to use.

    Yields:
        The results, in the order in which the calls end.

    Raises:
        Exception: What a call raised.
    """
    from joblib import Parallel, delayed

    parallel = Parallel(
        n_jobs=jobs, return_as="generator_unordered", initializer=exit_with_parent, initargs=(os.getpid(),)
    )
    task = delayed(function)
    yield from parallel(task(*call) for call in calls)


def exit_with_parent(parent: int) -> None:
    """A worker whose parent was killed would wait for ever to hand over its result."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_CHECK_PERIOD)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
