"""`slider-drilling diagnose`: where a log and the simulator differ, and which effect explains it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.campaign_options import jobs_option, scheduler_option
from slider_drilling.commands.options import SEED, json_option, namespace_option, units_option, write_and_print

if TYPE_CHECKING:
    from slider_drilling.diagnosis.diagnose import Diagnosis
    from slider_drilling.diagnosis.result import Outcome
    from slider_drilling.units import Units


EXAMPLES = """\
Examples:

\b
  slider-drilling diagnose run.mcap -o diagnosis
  slider-drilling diagnose logs/ --jobs 4 -o diagnoses
  slider-drilling diagnose monday.mcap tuesday.mcap --together -o diagnosis
"""


@click.command(epilog=EXAMPLES)
@click.argument("logs", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), help="Rig file instead of the logs' own.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default="diagnosis", show_default=True,
              help="Folder for diagnosis.json, report.html and rig.tuned.yaml; a folder each for several "
                   "logs.")  # fmt: skip
@namespace_option
@click.option("--seed", default=0, show_default=True, type=SEED,
              help="Seed of the bootstrap; the same seed gives the same answer.")  # fmt: skip
@click.option("--only", multiple=True, metavar="NAME", help="Consider only this effect; repeatable. [default: all]")
@click.option("--effect", "effects", multiple=True, metavar="MODULE:CLASS",
              help="Also consider an effect of your own; repeatable.")  # fmt: skip
@click.option(
    "--until",
    default=1.0,
    show_default=True,
    metavar="SHARE",
    help="Fit only the first part of every log (0.67: two thirds) and predict the rest.",
)
@click.option("--together", is_flag=True, help="Fit several logs of one rig together.")
@jobs_option
@scheduler_option
@json_option
@units_option
def command(
    logs: tuple[Path, ...],
    rig_path: Path | None,
    output: Path,
    namespace: str | None,
    seed: int,
    only: tuple[str, ...],
    effects: tuple[str, ...],
    until: float,
    together: bool,
    jobs: int,
    scheduler: str,
    as_json: bool,
    units: Units,
) -> int:
    """Find out where LOGS and the simulator differ, which effect explains it, and how much of the gap it closes.

    Several LOGS, or folders of logs, are diagnosed one by one, with a table over all. Ctrl-C keeps the finished ones;
    the same command resumes. With one log, or --together, Ctrl-C (or SIGTERM) writes the best answer so far, marked
    partial. The exit code is then 130 (143).
    """
    from slider_drilling.api.diagnose import diagnose
    from slider_drilling.campaign.diagnose_logs import DiagnoseOptions, find_logs, user_effect_file
    from slider_drilling.campaign.run import WorkerSettings
    from slider_drilling.commands.diagnose_logs import diagnose_each
    from slider_drilling.console.streams import progress_stages, stderr
    from slider_drilling.diagnosis.save import FILES
    from slider_drilling.diagnosis.user_effects import installed_effects, load_effect
    from slider_drilling.files.output_files import check_distinct, check_outputs, make_folder
    from slider_drilling.log import read_log
    from slider_drilling.rig import load_rig

    logs = tuple(find_logs(logs))
    check_distinct(logs)
    if len(logs) > 1 and not together:
        sources = tuple((reference, user_effect_file(reference)) for reference in effects)
        options = DiagnoseOptions(rig_path, namespace, seed, only, sources, until, units.name)
        return diagnose_each(logs, options, WorkerSettings(jobs, scheduler), output, as_json, units)
    make_folder(output)
    check_outputs([output / name for name in FILES], (*logs, rig_path))
    own = [*installed_effects(), *(load_effect(reference) for reference in effects)]
    records = [read_log(path, rig_path, namespace) for path in logs]
    rig = None if rig_path is None else load_rig(rig_path)
    with progress_stages() as progress:
        diagnosed = diagnose(records, rig, only=only, effects=own, until=until, seed=seed, progress=progress)
    for record in records:
        for note in record.notes:
            stderr().print(f"{record.source}: {note}")
    write_and_print(diagnosed.tree if as_json else None, lambda: _print(diagnosed.diagnosis, units),
            lambda: diagnosed.save(output, units))  # fmt: skip
    return 0


def _print(diagnosis: Diagnosis, units: Units) -> None:
    from rich.text import Text

    from slider_drilling.console.streams import stderr, stdout
    from slider_drilling.diagnosis import sentences

    origin = diagnosis.rig_source
    stdout().print(Text(units.convert_text(diagnosis.driller), "bold"))
    stdout().print(units.convert_text(diagnosis.sentence))
    stdout().print(f"rig file: {origin.name} ({origin.source})")
    _print_ranking(diagnosis.outcome, units)
    _print_simulated(diagnosis.outcome, units)
    for sentence in sentences.prediction_horizon(diagnosis.outcome):
        stdout().print(units.convert_text(sentence))
    for sentence in diagnosis.remarks:
        stderr().print(f"note: {units.convert_text(sentence)}")


def _print_ranking(outcome: Outcome, units: Units) -> None:
    from rich.table import Table
    from rich.text import Text

    from slider_drilling.console.streams import stdout
    from slider_drilling.diagnosis import sentences
    from slider_drilling.diagnosis.effect_phrases import format_quantity

    fitted, others = sentences.fitted_and_others(outcome)
    grouped = any(one.group for one in fitted)
    rivals = ["not told apart from"] if grouped else []
    closes = sentences.share_headers(fitted)
    table = Table("effect", "site", *closes, "fitted", *rivals, "standing")
    reasons = list(dict.fromkeys(why for one in fitted if not one.in_answer for why in one.why_not))
    for one in fitted:
        settings = ", ".join(
            f"{name.rpartition('.')[2]} {format_quantity(found.value, found.unit)}"
            for name, found in one.parameters.items()
        )
        standing = Text(sentences.candidate_status_by_number(one, reasons), "green" if one.in_answer else "")
        group = [", ".join(one.group)] if grouped else []
        shares = sentences.share_cells(one, closes)
        table.add_row(one.effect, one.site, *shares, units.convert_text(settings), *group, standing)
    if fitted:
        stdout().print(table)
    for number, why in enumerate(reasons, 1):
        stdout().print(f"({number}) {why}")
    if others:
        stdout().print(others)


def _print_simulated(outcome: Outcome, units: Units) -> None:
    from rich.table import Table

    from slider_drilling.console.streams import stdout
    from slider_drilling.diagnosis.page import simulated_rows
    from slider_drilling.pages import Quantity

    heads, rows = simulated_rows(outcome)
    table = Table(*heads, title="RMS error of one simulation of the log, nothing fed back or held out")
    for row in rows:
        table.add_row(
            *(units.format(cell.value, cell.unit) if isinstance(cell, Quantity) else str(cell) for cell in row)
        )
    if rows:
        stdout().print(table)
