"""`slider-drilling diagnose`: where a log and the simulator differ, and which effect explains it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.campaign_options import jobs_option, scheduler_option
from slider_drilling.commands.options import (
    SEED,
    json_option,
    namespace_option,
    print_checks,
    topics_option,
    units_option,
    write_and_print,
)

if TYPE_CHECKING:
    from slider_drilling.diagnosis.result import Diagnosis
    from slider_drilling.units import Units


EXAMPLES = """\
Examples:

\b
  slider-drilling diagnose run.mcap -o diagnosis
  slider-drilling diagnose logs/ --jobs 4 -o diagnoses
  slider-drilling diagnose monday.mcap tuesday.mcap --together -o diagnosis
  slider-drilling diagnose monday.mcap test.mcap --together --after diagnosis -o both
  slider-drilling diagnose tuesday.mcap --baseline monday.mcap -o diagnosis
  slider-drilling diagnose run.mcap --since 1200 -o diagnosis
"""


@click.command(epilog=EXAMPLES)
@click.argument("logs", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), help="Rig file instead of the logs' own.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default="diagnosis", show_default=True,
              help="Folder for diagnosis.json, report.html, rig.tuned.yaml and the next programme; a folder each for "
                   "several logs.")  # fmt: skip
@namespace_option
@topics_option
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
@click.option("--after", type=click.Path(path_type=Path), metavar="DIAGNOSIS",
              help="Start from the diagnosis of the earlier logs (diagnosis.json or its folder).")  # fmt: skip
@click.option("--baseline", "baseline", multiple=True, type=click.Path(path_type=Path), metavar="LOG",
              help="What is different from this earlier log of the same rig; repeatable.")  # fmt: skip
@click.option("--since", metavar="TIME",
              help="What is different from this time on, s from the log's start; `auto` finds the time.")  # fmt: skip
@jobs_option
@scheduler_option
@json_option
@units_option
def command(
    logs: tuple[Path, ...],
    rig_path: Path | None,
    output: Path,
    namespace: str | None,
    topics_path: Path | None,
    seed: int,
    only: tuple[str, ...],
    effects: tuple[str, ...],
    until: float,
    together: bool,
    after: Path | None,
    baseline: tuple[Path, ...],
    since: str | None,
    jobs: int,
    scheduler: str,
    as_json: bool,
    units: Units,
) -> int:
    """Find out where LOGS and the simulator differ, which effect explains it, and how much of the gap it closes.

    With --baseline or --since: what is different from an earlier log, or from a time on, and how much that explains.

    Several LOGS, or folders of logs, are diagnosed one by one, with a table over all. Ctrl-C keeps the finished ones;
    the same command resumes. With one log, or --together, Ctrl-C (or SIGTERM) writes the best answer so far:
    `interrupted` is then true, and a remark says so. The exit code is then 130 (143).
    """
    from slider_drilling.api.diagnose import diagnose
    from slider_drilling.api.what_changed import parse_since
    from slider_drilling.campaign.diagnose_logs import DiagnoseOptions, find_logs
    from slider_drilling.campaign.run import WorkerSettings
    from slider_drilling.commands.diagnose_logs import diagnose_each
    from slider_drilling.console.streams import progress_stages, stderr
    from slider_drilling.diagnosis.save import FILES, NEXT_PROGRAMME
    from slider_drilling.diagnosis.user_effects import installed_effects, load_effect
    from slider_drilling.errors import InputError
    from slider_drilling.files.output_files import check_distinct, check_outputs, make_folder
    from slider_drilling.log import read_log
    from slider_drilling.rig import load_rig

    logs, before = tuple(find_logs(logs)), tuple(find_logs(baseline))
    check_distinct((*logs, *before))
    start = parse_since(since)
    compared = bool(before) or start is not None
    if after is not None and len(logs) > 1 and not together:
        raise InputError("--after: starts one diagnosis from another; give --together to fit the logs together")
    if len(logs) > 1 and not together and not compared:
        options = DiagnoseOptions(rig_path, namespace, topics_path, seed, only, effects, until, units.name)
        return diagnose_each(logs, options, WorkerSettings(jobs, scheduler), output, as_json, units)
    make_folder(output)
    answer = after / FILES[0] if after is not None and after.is_dir() else after
    check_outputs([output / name for name in (*FILES, NEXT_PROGRAMME)], (*logs, *before, rig_path, topics_path, answer))
    own = [*([] if compared else installed_effects()), *(load_effect(reference) for reference in effects)]
    records, earlier = (
        [read_log(path, rig_path, namespace, topics_path) for path in paths] for paths in (logs, before)
    )
    rig = None if rig_path is None else load_rig(rig_path)
    with progress_stages() as progress:
        diagnosed = diagnose(
            records, rig, only=only, effects=own, until=until, seed=seed, after=after, progress=progress,
            baseline=earlier or None, since=start,
        )  # fmt: skip
    for record in (*earlier, *records):
        for note in record.notes:
            stderr().print(f"{record.source}: {note}")
    write_and_print(diagnosed.tree if as_json else None, lambda: _print(diagnosed.diagnosis, units),
            lambda: diagnosed.save(output, units))  # fmt: skip
    return 0


def _print(diagnosis: Diagnosis, units: Units) -> None:
    from rich.text import Text

    from slider_drilling.console.streams import stderr, stdout
    from slider_drilling.diagnosis.asked_run import ask_next
    from slider_drilling.diagnosis.sentences import (
        model_error_allowed,
        prediction_horizon,
        remarks_beside_checks,
        summary,
        technical_summary,
    )

    source = diagnosis.rig_source
    stdout().print(Text(units.convert_text(summary(diagnosis)), "bold"))
    if diagnosis.verdict != "inconclusive":  # the summary has said why, in the display units
        stdout().print(technical_summary(diagnosis))
    stdout().print(f"rig file: {source.name} ({source.source})")
    for checked in diagnosis.log_checks:
        print_checks(checked.rows(), units, checked.log.source if len(diagnosis.logs) > 1 else "")
    _print_ranking(diagnosis, units)
    _print_whole_runs(diagnosis, units)
    if (allowed := model_error_allowed(diagnosis)) is not None:
        stdout().print(allowed)
    for text in prediction_horizon(diagnosis):
        stdout().print(text)
    if diagnosis.next_manoeuvre is not None:
        stdout().print(units.convert_text(ask_next(diagnosis.next_manoeuvre, diagnosis.rig)))
    for remark in remarks_beside_checks(diagnosis):
        stderr().print(f"note: {units.convert_text(remark)}")


def _print_ranking(diagnosis: Diagnosis, units: Units) -> None:
    from rich.table import Table
    from rich.text import Text

    from slider_drilling.console.streams import stdout
    from slider_drilling.diagnosis.ranking_table import (
        candidate_status_by_number,
        share_cells,
        share_headers,
        split_by_fitted,
    )
    from slider_drilling.diagnosis.sentences import about_shares
    from slider_drilling.units import displayed, sentence

    fitted, others = split_by_fitted(diagnosis.ranking)
    grouped = any(ranked.group for ranked in fitted)
    closes = share_headers(fitted)
    table = Table("effect", "site", *closes, "fitted", *(["indistinguishable from"] if grouped else []), "status")
    table.title = str(about_shares(diagnosis))
    reasons = list(dict.fromkeys(why for ranked in fitted if not ranked.in_answer for why in ranked.why_not))
    for ranked in fitted:
        settings = ", ".join(
            units.convert_text(sentence(f"{name.rpartition('.')[2]} ", displayed(fit.value, fit.unit)))
            for name, fit in ranked.parameters.items()
        )
        status = Text(candidate_status_by_number(ranked, reasons), "green" if ranked.in_answer else "")
        group = [", ".join(ranked.group)] if grouped else []
        table.add_row(ranked.effect, ranked.site, *share_cells(ranked, closes), settings, *group, status)
    if fitted:
        stdout().print(table)
    for number, why in enumerate(reasons, 1):
        stdout().print(f"({number}) {why}")
    if others:
        stdout().print(others)


def _print_whole_runs(diagnosis: Diagnosis, units: Units) -> None:
    from rich.table import Table

    from slider_drilling.console.streams import stdout
    from slider_drilling.diagnosis.page import whole_run_rows
    from slider_drilling.pages import Quantity

    headers, rows = whole_run_rows(diagnosis)
    table = Table(*headers, title="RMS error of one free simulation of the whole log")
    for row in rows:
        table.add_row(
            *(units.format(cell.value, cell.unit) if isinstance(cell, Quantity) else str(cell) for cell in row)
        )
    if rows:
        stdout().print(table)
