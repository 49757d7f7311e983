"""`slider-drilling import`: turns a table of a rig's recorder into an MCAP log."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import json_option, print_checks, print_json, print_written, units_option
from slider_drilling.errors import InputError

if TYPE_CHECKING:
    from slider_drilling.table_import import ImportedTable
    from slider_drilling.units import Units

EXAMPLES = """\
DATA is CSV or other text, LAS, XLSX, Parquet, WITSML or WITS; wits://HOST:PORT and serial:///dev/ttyS0 are live WITS.
Columns are recognised by their heads. Where they are not, a mapping file names columns and units;
config/import.example.yaml explains every key.

Examples:

\b
  slider-drilling import edr.csv --rig rig.yaml
  slider-drilling import edr.csv --unit HKLD=klbf --unit TQ='ft lbf' --save-mapping mapping.yaml
  slider-drilling import export.csv --mapping mapping.yaml --rows 14245:15583 -o slide.mcap
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


class ColumnUnit(click.ParamType):
    """COLUMN=UNIT as a pair of texts."""

    name = "column=unit"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, str]:
        column, separator, unit = str(value).rpartition("=")
        if not separator or not column or not unit:
            self.fail(f"{value!r} is not COLUMN=UNIT", param, ctx)
        return column, unit


@click.command("import", epilog=EXAMPLES)
@click.argument("data", type=str)
@click.option(
    "--mapping", type=click.Path(path_type=Path),
    help="A mapping file: which column is which channel. [default: the heads tell]",
)  # fmt: skip
@click.option(
    "-o", "--output", type=click.Path(path_type=Path),
    help="The MCAP log to write. [default: named as the table, in this folder]",
)  # fmt: skip
@click.option("--rig", type=click.Path(path_type=Path), help="A rig file to put into the log.")
@click.option("--rows", type=RowRange(), help="Data rows to keep, counted from 0; both ends are included.")
@click.option(
    "--unit", "column_units", type=ColumnUnit(), multiple=True, help="Unit of a column that the table does not give."
)
@click.option("--time-zone", default="", metavar="ZONE", help="Zone of the table's clock, such as Europe/Oslo.")
@click.option("--wits-units", type=click.Choice(["field", "metric"]), help="Units of WITS, which does not tell them.")
@click.option("--duration", type=float, metavar="S", help="End a live import after so many seconds. [default: Ctrl-C]")
@click.option("--save-mapping", type=click.Path(path_type=Path), help="Write the mapping that was used to this file.")
@click.option("--notes", default="", help="A note for the log's metadata.")
@json_option
@units_option
def command(
    data: str,
    mapping: Path | None,
    output: Path | None,
    rig: Path | None,
    rows: tuple[int, int] | None,
    column_units: tuple[tuple[str, str], ...],
    time_zone: str,
    wits_units: str | None,
    duration: float | None,
    save_mapping: Path | None,
    notes: str,
    as_json: bool,
    units: Units,
) -> None:
    """Turn the table DATA of a rig's recorder into an MCAP log in SI units; list its contents and what was checked."""
    from slider_drilling.console.printable import is_valid_utf8
    from slider_drilling.console.streams import progress_bar
    from slider_drilling.files.output_files import check_outputs, write_atomically
    from slider_drilling.log import save_log
    from slider_drilling.rig import load_rig
    from slider_drilling.table_import import import_table
    from slider_drilling.table_import.live_wits import is_live, record_wits

    if mapping is not None and column_units:
        raise InputError("--unit: the mapping file names the units; correct it there")
    output = output or Path("wits.mcap" if is_live(data) else f"{Path(data).stem}.mcap")
    outputs = (output,) if save_mapping is None else (output, save_mapping)
    check_outputs(outputs, (output.with_suffix(".wits") if is_live(data) else Path(data), mapping, rig))
    if not is_valid_utf8(notes):
        raise InputError("--notes: not UTF-8 text; write it in UTF-8")
    if rig is not None:
        load_rig(rig)
    if is_live(data):
        data = str(record_wits(data, output.with_suffix(".wits"), duration))
    with progress_bar() as progress:
        task = progress.add_task(f"reading {Path(data).name}", total=None)
        imported = import_table(
            data, mapping, rig, rows, units=dict(column_units), time_zone=time_zone, wits_units=wits_units or ""
        )
        progress.update(task, description=f"writing {output.name}")
        save_log(
            imported.log,
            output,
            recorded_by=f"slider-drilling import {Path(data).name}",
            notes=notes,
            progress=lambda done, total: progress.update(task, completed=done, total=total),
        )
    if save_mapping is not None:
        write_atomically(save_mapping, imported.mapping.encode())
    _print(imported, outputs, as_json, mapping is None and save_mapping is None, units)


def _print(imported: ImportedTable, outputs: tuple[Path, ...], as_json: bool, show_mapping: bool, units: Units) -> None:
    """Contents, checks and, where it was found and not saved, the mapping."""
    from rich.text import Text

    from slider_drilling.console.streams import stderr, stdout
    from slider_drilling.log.contents import contents_table, logged_quantities
    from slider_drilling.log_checks import check_without_rig

    log = imported.log
    record = log.imported
    checks = record.checks if record is not None else ()
    checked = check_without_rig(log)
    if as_json:
        print_json({
            "contents": [asdict(row) for row in logged_quantities(log)], "notes": log.notes,
            "log_checks": [{"check": row.check, "result": row.result, "text": str(row.text)} for row in checked.rows()],
            "mapping": imported.mapping,
            "wrote": list(outputs),
        })  # fmt: skip
        return
    shown = {text for _, text in checks}
    for note in log.notes:
        if note not in shown:
            stderr().print(Text(f"note: {units.convert_message(note)}"))
    stdout().print(contents_table(log, units))
    print_checks(checked.rows(), units)
    if show_mapping:
        stdout().print(Text(imported.mapping.rstrip()))
    print_written(outputs)
