"""`slider-drilling plot`: writes the page and the picture of a log."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import (
    json_option,
    namespace_option,
    topics_option,
    units_option,
    write_and_print,
)

if TYPE_CHECKING:
    from slider_drilling.units import Units


@click.command(epilog="Example:\n\n  slider-drilling plot run.mcap -o pages")
@click.argument("log", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Folder for both; that of the log if not given.")
@namespace_option
@topics_option
@units_option
@json_option
def command(
    log: Path, output: Path | None, namespace: str | None, topics_path: Path | None, units: Units, as_json: bool
) -> None:
    """Print a summary of LOG, and plot it as a self-contained HTML page and as PNG."""
    from slider_drilling.console.streams import stderr, stdout
    from slider_drilling.files.output_files import check_outputs, make_folder
    from slider_drilling.log import read_log
    from slider_drilling.log.run_page import write_run_page, write_run_picture
    from slider_drilling.log.run_summary import run_summary_table, summarise_run

    folder = log.resolve().parent if output is None else output
    page, picture = (folder / f"{log.stem}{suffix}" for suffix in (".html", ".png"))
    record = read_log(log, namespace=namespace, topics=topics_path)
    make_folder(folder)
    check_outputs((page, picture), (log, topics_path))
    summary = summarise_run(record)
    for note in record.notes:
        stderr().print(f"{log.name}: {note}")

    def write() -> tuple[Path, ...]:
        write_run_page(page, record, summary, units=units)
        write_run_picture(picture, record, units)
        return page, picture

    write_and_print({"log": log, "summary": asdict(summary), "notes": record.notes} if as_json else None,
            lambda: stdout().print(run_summary_table(summary, units=units)), write)  # fmt: skip
