"""Run times: the median of several runs."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

REPEATS = 5


def processor_seconds(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median processor time of this thread, s; other programs do not count."""
    return _median(work, repeats, time.thread_time)


def wall_seconds(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median wall time, s."""
    return _median(work, repeats, time.perf_counter)


def _median(work: Callable[[], object], repeats: int, clock: Callable[[], float]) -> float:
    taken = []
    for _ in range(repeats):
        start = clock()
        work()
        taken.append(clock() - start)
    return statistics.median(taken)
