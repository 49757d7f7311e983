"""`slider-drilling bench`: speed on this machine."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import json_option_with, print_json

if TYPE_CHECKING:
    from slider_drilling.benchmarks.result import BenchmarkResult

EPILOG = "Examples:\n\n  slider-drilling bench\n\n  slider-drilling bench --json > bench.json"


@click.command(epilog=EPILOG)
@json_option_with("Print results and machine as JSON on stdout.")
def command(as_json: bool) -> None:
    """Measure speed: simulation, closed loop, recorder, diagnosis, start-up. Takes some minutes.

    Each figure has a reference from the same run. Compare ratios between machines, not times.
    """
    from slider_drilling.benchmarks.machine import describe
    from slider_drilling.benchmarks.suite import STAGES, measure
    from slider_drilling.console.streams import progress_bar

    machine = describe()
    with progress_bar("measuring {task.description}", "{task.completed:.0f} of {task.total:.0f}") as bar:
        task = bar.add_task("", total=len(STAGES), completed=-1)
        results = measure(lambda stage: bar.update(task, advance=1, description=stage))
    if as_json:
        print_json({"results": [result.to_json() for result in results], "machine": machine})
    else:
        _print(results, machine)


def _print(results: list[BenchmarkResult], machine: dict[str, str]) -> None:
    from rich.table import Table

    from slider_drilling.console.streams import stdout

    table = Table("figure", "value", "reference", "ratio", "reference, and how it was measured")
    for result in results:
        value = "-" if result.value is None else f"{result.value:.3g} {result.unit.strip('-')}"
        reference = "" if result.reference is None else f"{result.reference:.3g}"
        ratio = "" if result.ratio is None else f"{result.ratio:.3g}"
        remarks = "; ".join(filter(None, (result.reference_name, result.note)))
        table.add_row(result.name, value, reference, ratio, remarks)
    stdout().print(table)
    for name, value in machine.items():
        stdout().print(f"{name}: {value}")
