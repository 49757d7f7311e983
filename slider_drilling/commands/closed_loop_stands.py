"""`slider-drilling closed-loop --stands`: programmes that drill a stand, scored by the true state."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.commands.options import write_and_print

if TYPE_CHECKING:
    from slider_drilling.slide_scenarios.stand_run import StandScore
    from slider_drilling.slide_scenarios.stand_scenarios import StandScenario
    from slider_drilling.units import Units


def list_stands() -> list[tuple[str, str]]:
    """Name and one line of every stand."""
    from slider_drilling.slide_scenarios.stand_scenarios import STANDS

    return [(stand.name, stand.about) for stand in STANDS]


def run_stands(
    only: tuple[str, ...], seed: int, elements: int, jobs: int, output: Path | None, as_json_text: bool, units: Units
) -> None:
    """Run the stands, then write closed_loop_stands.json and print the table.

    Args:
        only: Beginnings of names; all stands if empty.
        seed: Of the sensor noise.
        elements: Of the string.
        jobs: Number of processes.
        output: Folder for the file, or None.
        as_json_text: Whether to print JSON in place of the table.
        units: Of the table.

    Raises:
        InputError: No stand has such a name, or the file cannot be written.
    """
    from slider_drilling.console.streams import progress_bar
    from slider_drilling.files.output_files import check_outputs, make_folder, write_atomically
    from slider_drilling.slide_scenarios import stand_run, stand_table

    stands = _chosen(only)
    if output is not None:
        make_folder(output)
        check_outputs((output / "closed_loop_stands.json",))
    scores: dict[str, StandScore] = {}
    with progress_bar("{task.description}", "{task.completed}/{task.total}") as progress:
        task = progress.add_task("stands", total=len(stands))
        try:
            for score in stand_run.run_stands(stands, seed, elements, jobs):
                scores[score.name] = score
                progress.advance(task)
        except KeyboardInterrupt:
            if not scores:
                raise
    rows = [scores[stand.name] for stand in stands if stand.name in scores]
    tree = stand_table.as_json(rows, seed, elements, len(rows) < len(stands))

    def write() -> tuple[Path, ...]:
        if output is None:
            return ()
        write_atomically(output / "closed_loop_stands.json", json.dumps(tree, indent=1).encode("utf-8"))
        return (output / "closed_loop_stands.json",)

    write_and_print(tree if as_json_text else None, lambda: print_stands(rows, units), write)


def _chosen(only: tuple[str, ...]) -> list[StandScenario]:
    from slider_drilling.errors import InputError
    from slider_drilling.slide_scenarios.stand_scenarios import STANDS

    for start in only:
        if not any(stand.name.startswith(start) for stand in STANDS):
            raise InputError(f"--only = {start!r}: no stand starts with this; see --stands --list")
    return [stand for stand in STANDS if not only or stand.name.startswith(only)]


def print_stands(rows: list[StandScore], units: Units) -> None:
    """Print the table, and why a stand was not done."""
    from rich.table import Table

    from slider_drilling.console.streams import stdout
    from slider_drilling.slide_scenarios.stand_table import terminal_header, terminal_row
    from slider_drilling.units import quantities_in

    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False)
    for index, label in enumerate(terminal_header(units)):
        table.add_column(label, justify="right" if index else "left", overflow="fold")
    for row in rows:
        table.add_row(*terminal_row(row, units))
    stdout().print(table)
    for row in rows:
        if row.outcome != "done":
            said = units.convert_text(quantities_in(row.outcome))
            stdout().print(f"{row.name}, {row.duration_s:.0f} s: {said}", markup=False)
