"""`slider-drilling rig`: a rig file from a rig's papers, and the tables inside the package."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import json_option, print_json, print_written, units_option, write_and_print

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slider_drilling.rig_papers.build import NewRig
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling rig new --survey survey.csv --tally tally.csv --mud '9.6ppg OBM' \\
      --motor '0.28rev/gal, 6600ft-lbf @ 1100psi, stall 9900ft-lbf' --pump 4.2gal/stk \\
      --top-drive '45000ft-lbf, 180rpm' --circulating-pressure 3000psi@500gpm --casing-shoe 6200ft
  slider-drilling rig new --template papers --units field
  slider-drilling rig new --survey rig_papers.xlsx --tally rig_papers.xlsx --sheet rig_papers.xlsx
  slider-drilling rig new --ask
  slider-drilling rig tables motors
"""


@click.group(epilog=EXAMPLES)
def command() -> None:
    """Make a rig file from a rig's papers, or list the tables that it uses."""


@command.command("new", epilog=EXAMPLES)
@click.option("--survey", type=click.Path(path_type=Path), help="Directional survey: CSV or XLSX.")
@click.option("--tally", type=click.Path(path_type=Path), help="String tally as run: CSV or XLSX.")
@click.option("--sheet", type=click.Path(path_type=Path),
              help="CSV or XLSX with the columns key and value, for what is not given as options.")  # fmt: skip
@click.option("--mud", help="Density, and OBM, WBM or SBM: '9.6ppg OBM'.")
@click.option("--motor", help="A name of the table, a file with its sheet, or its numbers: "
              "'0.28rev/gal, 6600ft-lbf @ 1100psi, stall 9900ft-lbf'.")  # fmt: skip
@click.option("--pump", help="Volume per stroke (4.2gal/stk), liner and stroke (6in x 12in), or a name and the liner.")
@click.option("--top-drive", help="A name of the table, or '45000ft-lbf, 180rpm'.")
@click.option("--circulating-pressure", help="Off bottom, with its flow: 3000psi@500gpm.")
@click.option("--bit", help="Where the tally has none: '8.5in PDC'.")
@click.option("--hole-diameter", help="Where it is not the bit's.")
@click.option("--casing-shoe", help="Measured depth: 6200ft; 0ft for none.")
@click.option("--make-up-torque", help="Of the drill pipe's connection. [default: the tally's, or API RP 7G]")
@click.option("--sample-rate", help="Of the surface channels: 10Hz.")
@click.option("--well", help="Name of the well.")
@click.option("--ask", is_flag=True, help="Ask step by step. [default in a terminal where something is missing]")
@click.option("--template", type=click.Path(path_type=Path), help="Write empty tables into this folder, and stop.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("rig.yaml"), show_default=True,
              help="Rig file to write.")  # fmt: skip
@units_option
@json_option
def new(
    survey: Path | None, tally: Path | None, sheet: Path | None, ask: bool, template: Path | None, output: Path,
    units: Units, as_json: bool, **given: str | None,
) -> None:  # fmt: skip
    """Make a rig file from survey, tally and what sheets say.

    Values carry their units. What no paper tells gets a usual value with a spread, marked in the file and listed.
    """
    from slider_drilling.errors import InputError
    from slider_drilling.files.output_files import check_outputs, make_folder, write_atomically
    from slider_drilling.rig_papers.build import build_rig
    from slider_drilling.rig_papers.sheet import read_sheet
    from slider_drilling.rig_papers.template import write_templates

    if template is not None:
        print_written(write_templates(make_folder(template), units.name))
        return
    values = {} if sheet is None else read_sheet(sheet)
    values |= {name: text for name, text in given.items() if text is not None}
    if ask or (sys.stdin.isatty() and _is_incomplete(survey, tally, values)):
        survey, tally, values = _ask(survey, tally, values, units.name)
    if survey is None or tally is None:
        raise InputError("rig new: give --survey and --tally, or --ask; --template FOLDER writes tables to fill in")
    check_outputs((output,), (survey, tally, sheet))
    made = build_rig(survey, tally, values)

    def write() -> list[Path]:
        write_atomically(output, made.text().encode())
        return [output]

    write_and_print(_tree(made) if as_json else None, lambda: _print(made, units), write)


def _is_incomplete(survey: Path | None, tally: Path | None, values: dict[str, str]) -> bool:
    from slider_drilling.rig_papers.sheet import SHEET_KEYS

    return survey is None or tally is None or any(key.required and key.name not in values for key in SHEET_KEYS)


def _ask(
    survey: Path | None, tally: Path | None, values: dict[str, str], units: str
) -> tuple[Path, Path, dict[str, str]]:
    """Ask for what is missing; each answer is checked, and asked for again where it cannot be used."""
    from slider_drilling.rig_papers.ask import ask_for_sheet, ask_for_table
    from slider_drilling.rig_papers.tally import read_tally
    from slider_drilling.wellbore.survey_table import read_survey

    survey = survey or ask_for_table("survey (CSV or XLSX)", read_survey)
    tally = tally or ask_for_table("string tally (CSV or XLSX)", read_tally)
    return survey, tally, ask_for_sheet(values, units)


def _tree(made: NewRig) -> dict[str, object]:
    from slider_drilling.rig import rig_tree

    assumed = [{"key": item.key, "spread": item.spread, "why": item.why} for item in made.rig.assumed]
    return {"rig": rig_tree(made.rig), "assumed": assumed, "notes": made.notes}


def _print(made: NewRig, units: Units) -> None:
    from slider_drilling.console.streams import stderr, stdout
    from slider_drilling.rig_papers.assumed_table import assumed_rows
    from slider_drilling.units import quantities_in

    for note in made.notes:
        stderr().print(f"note: {units.convert_text(quantities_in(note))}", markup=False)
    rows = assumed_rows(made.rig, units)
    stdout().print(f"{len(rows)} numbers are on no paper: usual values, +/- how far rigs lie from them, and why")
    for why in dict.fromkeys(row[-1] for row in rows):
        stdout().print(f"{units.convert_text(quantities_in(why))}:", markup=False)
        for line in _aligned([row[:-1] for row in rows if row[-1] == why]):
            stdout().print(f"  {line}")


@command.command("tables")
@click.argument(
    "name", required=False, type=click.Choice(["drill-pipe", "heavy-weight", "motors", "top-drives", "pumps"])
)
@json_option
def tables(name: str | None, as_json: bool) -> None:
    """Print the tables inside the package, with their sources."""
    from slider_drilling.console.streams import stdout
    from slider_drilling.rig_papers.equipment_tables import EQUIPMENT_TABLES

    chosen = {title: table for title, table in EQUIPMENT_TABLES.items() if name in (None, title)}
    if as_json:
        print_json({title: {"source": table.source, "compared": table.compared, "head": table.head,
                            "rows": list(table.rows())} for title, table in chosen.items()})  # fmt: skip
        return
    for title, table in chosen.items():
        stdout().print(f"{title}: {table.source}", markup=False)
        stdout().print(f"compared with published text: {table.compared}", markup=False)
        for line in _aligned([table.head, *table.rows()]):
            stdout().print(line)
        stdout().print()


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows as lines whose columns are aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
