"""`slider-drilling closed-loop --faults`: what the controller does about each fault of the rig."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.commands.options import write_and_print

if TYPE_CHECKING:
    from slider_drilling.slide_scenarios import Scenario
    from slider_drilling.slide_scenarios.fault_table import FaultOutcome, SlideLimits
    from slider_drilling.units import Units


def run_faults(
    scenarios: list[Scenario], name: str, sets: tuple[str, ...], seed: int, elements: int, jobs: int,
    output: Path | None, as_json_text: bool, units: Units,
) -> None:  # fmt: skip
    """Run the scenarios, then write closed_loop_faults.json and print the table.

    Args:
        scenarios: Slides with their faults.
        name: module:Class of the controller.
        sets: Settings of the controller that differ from its defaults, NAME=VALUE.
        seed: Of the sensor noise.
        elements: Of the string.
        jobs: Number of processes.
        output: Folder for the file, or None.
        as_json_text: Whether to print JSON in place of the table.
        units: Of the table.

    Raises:
        InputError: The controller or a setting cannot be used, or the file cannot be written.
    """
    from slider_drilling.commands.overrides import parse_settings
    from slider_drilling.console.streams import progress_bar
    from slider_drilling.files.output_files import check_outputs, make_folder, write_atomically
    from slider_drilling.slide_scenarios import fault_table, run_all
    from slider_drilling.slide_scenarios.contenders import UNDER_TEST

    if output is not None:
        make_folder(output)
        check_outputs((output / "closed_loop_faults.json",))
    settings = parse_settings(sets, name, scenarios[0].assumed_rig())
    outcomes = {}
    with progress_bar("{task.description}", "{task.completed}/{task.total}") as progress:
        task = progress.add_task("slides", total=len(scenarios))
        pairs = [(scenario, UNDER_TEST) for scenario in scenarios]
        for result in run_all(pairs, seed, elements, name, jobs, settings):
            outcomes[result.scenario.name] = fault_table.outcome_of(result)
            limits = fault_table.limits_for(result)
            progress.advance(task)
    rows = [outcomes[scenario.name] for scenario in scenarios]
    tree = fault_table.as_json(rows, limits, seed, elements)

    def write() -> tuple[Path, ...]:
        if output is None:
            return ()
        write_atomically(output / "closed_loop_faults.json", json.dumps(tree, indent=1).encode("utf-8"))
        return (output / "closed_loop_faults.json",)

    write_and_print(tree if as_json_text else None, lambda: print_faults(rows, limits, units), write)


def print_faults(rows: list[FaultOutcome], limits: SlideLimits, units: Units) -> None:
    """Print the table and each reason that stopped a slide."""
    from rich.table import Table

    from slider_drilling.console.streams import stdout
    from slider_drilling.slide_scenarios.fault_table import terminal_header, terminal_row
    from slider_drilling.units import quantities_in

    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False)
    for index, label in enumerate(terminal_header(units)):
        table.add_column(label, justify="left" if index in (0, 2) else "right", overflow="fold")
    for row in rows:
        table.add_row(*terminal_row(row, units))
    stdout().print(table)
    text = (f"limits: weight {limits.weight / 1e3:.0f} kN, pressure {limits.pressure / 1e5:.1f} bar, torque "
            f"{limits.make_up / 1e3:.0f} kN m right and {limits.back_off / 1e3:.0f} kN m left")  # fmt: skip
    stdout().print(units.convert_text(quantities_in(text)), markup=False)
    for row in rows:
        if row.stopped_at_s is not None:
            said = units.convert_text(quantities_in(row.message))
            stdout().print(f"{row.name}, {row.stopped_at_s:.0f} s: {row.status}: {said}", markup=False)
