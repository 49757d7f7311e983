"""`slider-drilling analyse`: the friction in a log."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import json_option, units_option, write_and_print

if TYPE_CHECKING:
    from slider_drilling.pages import Table
    from slider_drilling.units import Units


@click.command(epilog="Example:\n\n  slider-drilling analyse run.mcap -o analysis")
@click.argument("log", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("analysis"), show_default=True,
              help="Folder for analysis.json, .html, .png and .csv.")  # fmt: skip
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), help="Rig file instead of the log's own.")
@click.option(
    "--elements", default=100, show_default=True, type=click.IntRange(10, 5000), help="Elements of the string."
)
@units_option
@json_option
def command(log: Path, output: Path, rig_path: Path | None, elements: int, units: Units, as_json: bool) -> None:
    """Find the friction in LOG: by hole interval, at breakover, along the hole, and what it does to the weight."""
    from slider_drilling.analysis.analyse import analyse
    from slider_drilling.analysis.report import analysis_study, to_json
    from slider_drilling.console.streams import progress_stages, stderr
    from slider_drilling.files.output_files import check_outputs
    from slider_drilling.log import read_log
    from slider_drilling.paper_studies.render import study_files, write_study

    check_outputs(study_files("analysis", output), (log, rig_path))
    record = read_log(log, rig_path)
    rig = None if record.rig_text is None else record.rig()
    with progress_stages() as report:
        analysis = analyse(record, rig, elements, report)
    study, tree = analysis_study(analysis, units), to_json(analysis)
    for text in analysis.undetermined:
        stderr().print(f"not found: {units.convert_text(text)}")
    write_and_print(tree if as_json else None, lambda: _print(study.tables),
                    lambda: write_study(study, output, tree, units))  # fmt: skip


def _print(tables: Sequence[Table]) -> None:
    import rich.table

    from slider_drilling.console.streams import stdout

    for table in tables:
        printed = rich.table.Table(*table.header, title=str(table.caption))
        for row in table.rows:
            printed.add_row(*map(str, row))
        stdout().print(printed)
