"""`slider-drilling watch --campaign N`: how well the twin does on sealed slides."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from slider_drilling.blind.slides.campaign import TwinCampaign
    from slider_drilling.blind.slides.score import ScoredSlide
    from slider_drilling.campaign.job import Job
    from slider_drilling.campaign.run import CampaignOutcome, WorkerSettings

FILE = "twin_campaign.json"


def watch_campaign(
    count: int, seed: int, begins: Sequence[str], duration: float, driven_by: str, rig_path: Path | None,
    output: Path, workers: WorkerSettings, as_json: bool, diagnose: bool,
) -> int:  # fmt: skip
    """Run the campaign, print and save its table.

    Args:
        count: Slides.
        seed: Of everything that is drawn.
        begins: What may begin; the usual mixture if empty.
        duration: s, of each slide.
        driven_by: ``controller`` or ``crew``.
        rig_path: Rig file that wells, strings and fluids are drawn from; the example's if None.
        output: Folder of logs, labels, results and the table.
        workers: Where the slides are made and watched.
        as_json: Print the tree of the file.
        diagnose: Whether the twin asks what has changed.

    Returns:
        The exit code.

    Raises:
        InputError: A name is unknown, a number out of range, or the folder cannot be written.
    """
    from slider_drilling.blind.slides.campaign import campaign_json, dump_campaign, run_campaign
    from slider_drilling.blind.slides.case import draw_slides
    from slider_drilling.campaign.progress import run_with_progress
    from slider_drilling.commands.options import write_and_print
    from slider_drilling.files.installed_files import installed_file
    from slider_drilling.files.output_files import check_outputs, make_folder, write_atomically

    check_beginnings(begins, duration)
    make_folder(output)
    path = output / FILE
    check_outputs((path,), (rig_path,))

    def run(what: str, jobs: Sequence[Job], folder: Path) -> CampaignOutcome:
        return run_with_progress(what, jobs, folder, workers)

    rig = Path(installed_file("config/rig.example.yaml")) if rig_path is None else rig_path
    campaign = run_campaign(draw_slides(count, seed, duration, begins, driven_by), rig, output, run, diagnose)
    options = {
        "campaign": count,
        "seed": seed,
        "begins": list(begins),
        "duration": duration,
        "driven_by": driven_by,
        "rig": str(rig_path or ""),
        "diagnose": diagnose,
    }

    def write() -> tuple[Path, ...]:
        write_atomically(path, dump_campaign(campaign, options))
        return (path,)

    write_and_print(campaign_json(campaign, options) if as_json else None, lambda: _print(campaign), write)
    return campaign.exit_code


def check_beginnings(begins: Sequence[str], duration: float) -> None:
    """Raise InputError for a name that cannot begin, or a duration out of range."""
    from slider_drilling.blind.slides.beginnings import BEGINNINGS, NOTHING
    from slider_drilling.errors import InputError

    for name in begins:
        if name not in (*BEGINNINGS, NOTHING):
            raise InputError(f"--begins {name}: unknown; use {', '.join((*BEGINNINGS, NOTHING))}")
    if not 900.0 <= duration <= 14400.0:
        raise InputError(f"--duration {duration:g}: must be 900 to 14400 s")


def _print(campaign: TwinCampaign) -> None:
    from rich.table import Table

    from slider_drilling.console.streams import stdout

    for each in campaign.scored:
        stdout().print(_line(each))
    for log, why in campaign.failed.items():
        click.echo(f"{log}: failed: {why}", err=True)
    table = Table("", "measured, 95 % interval", "to reach")
    for row in campaign.table():
        table.add_row(row.what, row.value, row.to_reach)
    stdout().print(table)


def _line(each: ScoredSlide) -> str:
    alarms = f"{each.false_alarms} false alarms; " if each.false_alarms else ""
    if each.truth == "none":
        return f"{each.log}: nothing begins; {alarms or 'quiet'}".rstrip("; ")
    if not each.detected:
        return f"{each.log}: {each.case}, size {each.size:.1f}: {alarms}not detected"
    delay = "-" if each.delay is None else f"{each.delay:.0f} s"
    named = ", ".join(each.named) or f"no name ({each.verdict or 'no answer'})"
    result = "right" if each.right else "wrong" if each.wrong else "open"
    return f"{each.log}: {each.case}, size {each.size:.1f}: {alarms}delay {delay}; {named}: {result}"
