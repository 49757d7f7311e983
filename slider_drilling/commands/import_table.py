"""`slider-drilling import`: turns a CSV table into an MCAP log."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import json_option, print_json, print_written, units_option
from slider_drilling.errors import InputError

if TYPE_CHECKING:
    from slider_drilling.units import Units

EXAMPLES = """\
The mapping file names columns and units; config/import.example.yaml explains every key.

Examples:

\b
  slider-drilling import export.csv --mapping mapping.yaml -o log.mcap
  slider-drilling import export.csv --mapping mapping.yaml --rig rig.yaml --rows 14245:15583 -o slide.mcap
"""


class RowRange(click.ParamType):
    """FIRST:LAST as a pair of whole numbers."""

    name = "first:last"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int] | object:
        first, separator, last = str(value).partition(":")
        if not separator or not first.isdigit() or not last.isdigit():
            self.fail(f"{value!r} is not FIRST:LAST, two row numbers", param, ctx)
        return int(first), int(last)


@click.command("import", epilog=EXAMPLES)
@click.argument("data", type=click.Path(path_type=Path))
@click.option(
    "--mapping", required=True, type=click.Path(path_type=Path), help="The mapping file: which column is which channel."
)
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="The MCAP log to write.")
@click.option("--rig", type=click.Path(path_type=Path), help="A rig file to put into the log.")
@click.option("--rows", type=RowRange(), help="Data rows to keep, counted from 0; both ends are included.")
@click.option("--notes", default="", help="A note for the log's metadata.")
@json_option
@units_option
def command(
    data: Path, mapping: Path, output: Path, rig: Path | None, rows: tuple[int, int] | None, notes: str, as_json: bool,
    units: Units,
) -> None:
    """Turn the CSV table DATA into an MCAP log in SI units, and list its contents."""
    from slider_drilling.console.printable import is_valid_utf8
    from slider_drilling.console.streams import progress_bar, stderr, stdout
    from slider_drilling.files.output_files import check_outputs
    from slider_drilling.log import read_table, save_log
    from slider_drilling.log.contents import contents_table, logged_quantities
    from slider_drilling.rig import load_rig

    check_outputs((output,), (data, mapping, rig))
    if not is_valid_utf8(notes):
        raise InputError("--notes: not UTF-8 text; write it in UTF-8")
    if rig is not None:
        load_rig(rig)
    with progress_bar() as progress:
        task = progress.add_task(f"reading {data.name}", total=None)
        log = read_table(data, mapping, rig, rows)
        progress.update(task, description=f"writing {output.name}")
        save_log(
            log,
            output,
            recorded_by=f"slider-drilling import {data.name}",
            notes=notes,
            progress=lambda done, total: progress.update(task, completed=done, total=total),
        )
    for note in log.notes:
        stderr().print(f"{data.name}: {note}")
    if as_json:
        print_json({"contents": [asdict(row) for row in logged_quantities(log)], "notes": log.notes, "wrote": [output]})
        return
    stdout().print(contents_table(log, units))
    print_written((output,))
