"""`slider-drilling replay`: simulate a log's commands and compare with what it measured."""

from __future__ import annotations

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
    from slider_drilling.diagnosis.replay import Replay
    from slider_drilling.units import Units


@click.command(epilog="Example:\n\n  slider-drilling replay run.mcap --rig rig.yaml -o simulated.mcap")
@click.argument("log", type=click.Path(path_type=Path))
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), help="Rig file instead of the log's own.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write the simulated channels to this MCAP file.")
@click.option("--page", type=click.Path(path_type=Path),
              help="Write a page with measured and simulated channels to this file.")  # fmt: skip
@click.option("--elements", default=200, show_default=True, help="Elements of the string, 10 to 5000.")
@namespace_option
@topics_option
@json_option
@units_option
def command(
    log: Path, rig_path: Path | None, output: Path | None, page: Path | None, elements: int, namespace: str | None,
    topics_path: Path | None, as_json: bool, units: Units,
) -> None:
    """Simulate LOG's commands from its first sample and print the difference of each channel."""
    from slider_drilling.api.replay import replay
    from slider_drilling.console.streams import stderr
    from slider_drilling.diagnosis.replay_page import replay_page
    from slider_drilling.errors import InputError
    from slider_drilling.files.output_files import check_outputs
    from slider_drilling.log import read_log
    from slider_drilling.pages import write_page

    if not 10 <= elements <= 5000:
        raise InputError(f"--elements = {elements}: must be within 10 to 5000")
    written = [path for path in (output, page) if path is not None]
    check_outputs(written, (log, rig_path, topics_path))
    record = read_log(log, rig_path, namespace, topics_path)
    replayed = replay(record, elements=elements)
    run = replayed.replay

    def show() -> None:
        _print(run, units)
        for text in (*record.notes, *run.assumptions):
            stderr().print(f"note: {units.convert_text(text)}")

    def write() -> list[Path]:
        if output is not None:
            replayed.save(output)
        if page is not None:
            write_page(page, replay_page(record, run, units, (*record.notes, *run.assumptions)), units)
        return written

    channels = {name: {"rms": rms, "rms_over_noise": replayed.rms_over_noise[name]}
                for name, rms in replayed.rms.items()}
    tree = {"channels": channels, "assumed": [str(text) for text in run.assumptions], "notes": record.notes}
    write_and_print(tree if as_json else None, show, write)


def _print(run: Replay, units: Units) -> None:
    from rich.table import Table

    from slider_drilling.console.streams import stdout
    from slider_drilling.diagnosis.replay_page import HEADER, table_rows

    table = Table(*HEADER)
    for row in table_rows(run, units):
        table.add_row(*row)
    stdout().print(table)
