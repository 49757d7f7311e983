"""The stages of `slider-drilling bench`."""

from __future__ import annotations

from collections.abc import Callable

from slider_drilling.benchmarks.diagnosis import diagnose_time
from slider_drilling.benchmarks.many_rigs import environment_rates
from slider_drilling.benchmarks.real_machines import machine_results
from slider_drilling.benchmarks.result import BenchmarkResult
from slider_drilling.benchmarks.sessions import node_start, session_rates
from slider_drilling.benchmarks.start_up import start_up
from slider_drilling.benchmarks.string_rates import machine_rates, string_rates

STAGES: tuple[tuple[str, Callable[[], list[BenchmarkResult]]], ...] = (
    ("the step of the string", string_rates),
    ("roots and exponentials", machine_rates),
    ("closed loop and recorder", session_rates),
    ("many rigs at once", environment_rates),
    ("diagnosis", lambda: [diagnose_time()]),
    ("diagnosis of real machines", machine_results),
    ("start-up", lambda: [*start_up(), node_start()]),
)


def measure(progress: Callable[[str], None] = lambda stage: None) -> list[BenchmarkResult]:
    """Measure everything; takes minutes. ``progress`` is called with the name of the next stage."""
    results = []
    for name, stage in STAGES:
        progress(name)
        results.extend(stage())
    return results
