"""`slider-drilling recover`: writes what a damaged log still holds to whole logs of one run each."""

from __future__ import annotations

from pathlib import Path

import click

from slider_drilling.commands.options import json_option, print_json

EXAMPLES = """\
Examples:

\b
  slider-drilling recover broken.mcap -o fixed.mcap
  slider-drilling recover out/slide_20260101_120000 -o slide.mcap
"""


@click.command(epilog=EXAMPLES)
@click.argument("log", type=click.Path(path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="The MCAP log to write.")
@json_option
def command(log: Path, output: Path, as_json: bool) -> None:
    """Write what a damaged LOG, or a folder of its parts, still holds to a whole log.

    Two runs in one log become two logs. Messages of all topics are copied as they are. Prints what was lost.
    """
    from slider_drilling.console.streams import stderr, stdout
    from slider_drilling.files.output_files import check_outputs
    from slider_drilling.log.log_files import find_log_files
    from slider_drilling.log.recover import recover

    check_outputs([output], find_log_files(log).files)
    written, notes = recover(log, output)
    if as_json:
        rows = [{"path": log.path, "messages": log.messages, "seconds": log.seconds} for log in written]
        print_json({"written": rows, "notes": notes})
        return
    for note in notes:
        stderr().print(f"note: {note}")
    for recovered in written:
        stdout().print(f"wrote {recovered.path}: {recovered.messages} messages over {recovered.seconds:.1f} s")
