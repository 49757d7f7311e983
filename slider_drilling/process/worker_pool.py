"""Work in processes of this machine that end when this one does, however it ends."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")
_PERIOD = 0.5  # s between two looks at who the parent is


def map_in_processes(function: Callable[..., T], calls: Iterable[tuple[object, ...]], jobs: int) -> Iterator[T]:
    """What ``function`` returns for each tuple of arguments, as they end, in up to ``jobs`` processes. Raises what it
    raises."""
    from joblib import Parallel, delayed

    parallel = Parallel(
        n_jobs=jobs, return_as="generator_unordered", initializer=_end_with_parent, initargs=(os.getpid(),)
    )
    one = delayed(function)
    yield from parallel(one(*call) for call in calls)


def _end_with_parent(parent: int) -> None:
    """A process that wants to hand over a result waits for ever where its parent was killed and nobody takes it."""

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(_PERIOD)
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()
