"""How long something takes: the median of several runs."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

REPEATS = 5


def processor_seconds(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median time (s) that this thread spends on the processor: what other programs take does not count."""
    return _median(work, repeats, time.thread_time)


def wall_seconds(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median time (s) on the wall."""
    return _median(work, repeats, time.perf_counter)


def _median(work: Callable[[], object], repeats: int, clock: Callable[[], float]) -> float:
    taken = []
    for _ in range(repeats):
        begun = clock()
        work()
        taken.append(clock() - begun)
    return statistics.median(taken)
