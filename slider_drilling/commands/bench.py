"""`slider-drilling bench`: how fast this machine does what takes time."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from slider_drilling.benchmarks.result import BenchmarkResult

EPILOG = "Examples:\n\n  slider-drilling bench\n\n  slider-drilling bench --json > bench.json"


@click.command(epilog=EPILOG)
@click.option("--json", "as_json", is_flag=True, help="Print JSON: results and the machine.")
def command(as_json: bool) -> None:
    """Measure speed: the string's step, closed loop, recorder, diagnosis, start-up. Takes some minutes.

    Each figure stands beside a reference measured in the same run: compare ratios where machines differ or are busy.
    """
    from slider_drilling.benchmarks.machine import describe
    from slider_drilling.benchmarks.suite import STAGES, measure
    from slider_drilling.console.streams import progress_bar

    machine = describe()
    with progress_bar("measuring {task.description}", "{task.completed:.0f} of {task.total:.0f}") as bar:
        task = bar.add_task("", total=len(STAGES), completed=-1)
        results = measure(lambda stage: bar.update(task, advance=1, description=stage))
    if as_json:
        print(json.dumps({"results": [result.to_json() for result in results], "machine": machine}, indent=1))
    else:
        _print(results, machine)


def _print(results: list[BenchmarkResult], machine: dict[str, str]) -> None:
    from rich.table import Table

    from slider_drilling.console.streams import stdout

    table = Table("figure", "value", "reference", "ratio", "what the reference is, and how it was measured")
    for one in results:
        value = "-" if one.value is None else f"{one.value:.3g} {one.unit.strip('-')}"
        reference = "" if one.reference is None else f"{one.reference:.3g}"
        ratio = "" if one.ratio is None else f"{one.ratio:.3g}"
        table.add_row(one.name, value, reference, ratio, "; ".join(filter(None, (one.reference_name, one.note))))
    stdout().print(table)
    for name, value in machine.items():
        stdout().print(f"{name}: {value}")
