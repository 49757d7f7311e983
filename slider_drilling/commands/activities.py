"""`slider-drilling activities`: splits a log into what the rig did."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from slider_drilling.commands.options import json_option, namespace_option, units_option, write_and_print
from slider_drilling.errors import InputError

if TYPE_CHECKING:
    from slider_drilling.rig_activities.split import DaySplit
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling activities day.mcap -o day
  slider-drilling activities day.mcap --units field --depth 13500ft
  slider-drilling activities day.mcap --extract slide -o day
"""


class DepthWithUnit(click.ParamType):
    """A depth with its unit, such as 4120m or "13500 ft", as m."""

    name = "depth"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        from slider_drilling.schema.quantity_text import read_quantity

        try:
            return read_quantity(str(value), "m", "depth")
        except InputError as error:
            self.fail(f"{value!r}: {error}", param, ctx)


class Extracted(click.ParamType):
    """`slide`, or an activity."""

    name = "activity"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> str:
        from slider_drilling.rig_activities.extract import EXTRACTED

        name = str(value).replace(" ", "_")
        if name not in EXTRACTED:
            self.fail(f"{value!r} is none of {', '.join(EXTRACTED)}", param, ctx)
        return name


@click.command(epilog=EXAMPLES)
@click.argument("log", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("activities"), show_default=True,
              help="Folder for activities.html, .json and .csv, slides.csv and extracted logs.")  # fmt: skip
@click.option("--depth", type=DepthWithUnit(), help="Depth of the bit at the start, such as 4120m or 13500ft. "
              "[default: the log's own, or 0]")  # fmt: skip
@click.option("--extract", "extracted", multiple=True, type=Extracted(), help="Write a log for each slide, or for each "
              "stretch of an activity (rotating ...); repeatable.")  # fmt: skip
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), help="Rig file for the extracted logs.")
@namespace_option
@units_option
@json_option
def command(
    log: Path, output: Path, depth: float | None, extracted: tuple[str, ...], rig_path: Path | None,
    namespace: str | None, units: Units, as_json: bool,
) -> None:  # fmt: skip
    """Split LOG, such as a day, into rotating, sliding, rocking, connections, tripping, circulating and off bottom."""
    from slider_drilling.console.streams import stderr
    from slider_drilling.files.output_files import check_outputs, make_folder, write_atomically
    from slider_drilling.log import read_log
    from slider_drilling.pages import write_page
    from slider_drilling.rig_activities.extract import extracted_files, write_extracted
    from slider_drilling.rig_activities.report import (
        activities_page,
        activity_columns,
        slide_columns,
        to_json,
    )
    from slider_drilling.rig_activities.split import split_day

    record = read_log(log, rig_path, namespace)
    day = split_day(record, depth)
    logs = extracted_files(day, log, extracted, output)
    page, tree_file, table, slides = (output / name for name in ("activities.html", "activities.json",
                                                                 "activities.csv", "slides.csv"))  # fmt: skip
    make_folder(output)
    check_outputs((page, tree_file, table, slides, *logs), (log, rig_path))
    tree = to_json(day)
    for note in (*record.notes, *day.notes):
        stderr().print(f"{log.name}: {note}")

    def write() -> Sequence[Path]:
        write_page(page, activities_page(day), units)
        write_atomically(tree_file, json.dumps(_finite(tree), indent=1, allow_nan=False).encode())
        activity_columns(day).to_csv(table)
        slide_columns(day).to_csv(slides)
        write_extracted(record, logs)
        return page, tree_file, table, slides, *logs

    write_and_print(tree if as_json else None, lambda: _print(day, units), write)


def _finite(value: Any) -> Any:
    """The tree with None for NaN."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and value != value else value


def _print(day: DaySplit, units: Units) -> None:
    from slider_drilling.commands.options import print_tables
    from slider_drilling.console.streams import stdout
    from slider_drilling.rig_activities.report import slide_table, summary, total_table

    stdout().print(units.convert_text(summary(day)))
    print_tables((total_table(day), *((slide_table(day),) if day.slides else ())), units)
