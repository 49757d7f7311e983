"""`slider-drilling blind-check`: accuracy of the diagnosis on sealed logs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from slider_drilling.commands.campaign_options import jobs_option, scheduler_option
from slider_drilling.commands.options import (
    SEED,
    json_option,
    print_json,
    refuse_ignored,
    units_option,
    write_and_print,
)

if TYPE_CHECKING:
    from slider_drilling.blind.cases import Case
    from slider_drilling.blind.check import JobRunner
    from slider_drilling.blind.score import ScoredCase
    from slider_drilling.campaign.job import Job
    from slider_drilling.campaign.run import CampaignOutcome
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling blind-check --cases 20 -o blind
  slider-drilling blind-check --rig my.yaml --effects stribeck,heave,none --sizes 1,2,4 --cases 60 -o blind
  slider-drilling blind-check --cases 100 --seal-only -o sealed
  slider-drilling blind-check --logs sealed -o blind_of_this_code
  slider-drilling blind-check --rounds 2 --duration 120 --cases 20 -o rounds
"""


# Options of the logs that are made, of what diagnoses them, and of rounds.
_OF_LOGS = ("cases", "seed", "effects", "sizes", "wells", "manoeuvres", "log_defects", "plants", "duration", "rig_path",
            "seal_only", "repeats")  # fmt: skip
_OF_DIAGNOSES, _OF_ROUNDS = ("only", "oracle"), ("minutes", "evidence_only")


@click.command(epilog=EXAMPLES)
@click.option("--cases", default=20, show_default=True, type=click.IntRange(1, 100000), help="Number of logs.")
@click.option("--seed", default=1, show_default=True, type=SEED,
              help="Seed of wells, noise and the forms of the laws.")  # fmt: skip
@click.option("--effects", default="", metavar="NAME,...",
              help="Use these only: effects, laws outside the catalogue, `none`, `two`. [default: all]")  # fmt: skip
@click.option("--sizes", default="0.5,1.5,4", show_default=True, metavar="X,...",
              help="Sizes: RMS change of the most affected channel, in noise floors.")  # fmt: skip
@click.option("--wells", default="", metavar="NAME,...",
              help="horizontal, deviated, extended, own (the rig file's; the default with --rig).")  # fmt: skip
@click.option("--manoeuvres", default="varied,steady,rotary", show_default=True, metavar="NAME,...",
              help="Manoeuvres of the rig.")  # fmt: skip
@click.option("--log-defects", default="none", show_default=True, metavar="NAME,...",
              help="Defects of the logs, in turn: none, late_start, no_drawworks, no_pump, few_samples, held_samples, "
                   "coarse_values.")  # fmt: skip
@click.option("--plants", default="foreign", show_default=True, metavar="NAME,...",
              help="What drills, in turn: foreign (another structure than the model's), model (its own equations on "
                   "another mesh).")  # fmt: skip
@click.option("--duration", default=400.0, show_default=True, help="Length of each log, s.")
@click.option("--rig", "rig_path", type=click.Path(path_type=Path),
              help="Rig file with the string, noise and well to use.")  # fmt: skip
@click.option("--seal-only", is_flag=True, help="Make the logs and labels only.")
@click.option("--logs", "sealed", type=click.Path(path_type=Path, exists=True, file_okay=False),
              help="Folder of sealed logs to use instead of new ones.")  # fmt: skip
@click.option("--answers", type=click.Path(path_type=Path, exists=True, file_okay=False),
              help="With --logs: score LOG.json or LOG/diagnosis.json of this folder, without diagnosing.")  # fmt: skip
@click.option("--only", default="", metavar="NAME,...", help="Effects that the diagnosis may consider. [default: all]")
@click.option("--oracle/--no-oracle", default=True, show_default=True,
              help="Also fit the true effect alone, to repeats of each run.")  # fmt: skip
@click.option("--repeats", default=3, show_default=True, type=click.IntRange(1, 100),
              help="Repeats of each run for the oracle. More repeats make it more certain.")  # fmt: skip
@click.option("--rounds", default=0, show_default=True, type=click.IntRange(0, 5),
              help="Ask each rig so many planned programmes, and diagnose after each; beside them, after a second "
                   "routine log, a random programme and the commissioning programme.")  # fmt: skip
@click.option("--minutes", default=4.0, show_default=True, help="With --rounds: longest time of a programme.")
@click.option("--evidence-only", is_flag=True,
              help="With --rounds: measure the evidence for the true effects instead of diagnosing, which shows what "
                   "the logs hold at best.")  # fmt: skip
@jobs_option
@scheduler_option
@click.option("-o", "--output", type=click.Path(path_type=Path), default="blind", show_default=True,
              help="Folder for logs, labels, answers, blind.json and blind.html.")  # fmt: skip
@json_option
@units_option
def command(
    cases: int,
    seed: int,
    effects: str,
    sizes: str,
    wells: str,
    manoeuvres: str,
    log_defects: str,
    plants: str,
    duration: float,
    rig_path: Path | None,
    seal_only: bool,
    sealed: Path | None,
    answers: Path | None,
    only: str,
    oracle: bool,
    repeats: int,
    rounds: int,
    minutes: float,
    evidence_only: bool,
    jobs: int,
    scheduler: str,
    output: Path,
    as_json: bool,
    units: Units,
) -> int:
    """Measure how often the diagnosis is right, on logs whose cause it cannot see.

    The logs come from a rig with another mesh, step, noise and form of the effects than the model that diagnoses.
    Some effects are in no catalogue. Ctrl-C keeps what is finished; the same command resumes.
    """  # fmt: skip
    from slider_drilling.blind import check
    from slider_drilling.blind.cases import CasePlan, draw_cases
    from slider_drilling.blind.wells import DEFAULT_WELLS
    from slider_drilling.campaign.progress import run_with_progress
    from slider_drilling.campaign.run import WorkerSettings
    from slider_drilling.errors import InputError
    from slider_drilling.files.installed_files import installed_file
    from slider_drilling.files.output_files import check_outputs, make_folder

    if answers is not None and sealed is None:
        raise InputError("--answers: give the folder of the sealed logs with --logs")
    if rounds and sealed is not None:
        raise InputError("--rounds: the rigs must be drawn anew: leave out --logs")
    _refuse_ignored(sealed is not None, answers is not None, seal_only, rounds > 0)
    if not 1.0 <= minutes <= 30.0:
        raise InputError(f"--minutes {minutes:g}: must be 1 to 30 min")
    make_folder(output)
    check_outputs((output / "blind.json", output / "blind.html"), (rig_path,))
    _check_effect_names(_names(only))
    workers = WorkerSettings(jobs, scheduler)

    def run(what: str, work: Sequence[Job], folder: Path) -> CampaignOutcome:
        return run_with_progress(what, work, folder, workers)

    stems = None
    options: dict[str, Any] = {"logs": str(sealed)}
    if sealed is None:
        chosen = _names(wells) or (("own",) if rig_path is not None else DEFAULT_WELLS)
        plan = CasePlan(_names(effects), _numbers("--sizes", sizes), chosen, _names(manoeuvres), seed, duration,
                    _names(log_defects), _names(plants))  # fmt: skip
        drawn = draw_cases(plan, cases)
        rig = rig_path if rig_path is not None else installed_file("config/rig.example.yaml")
        outcome = check.seal(drawn, rig, output, run, 0 if rounds else repeats)
        count = outcome.completed + outcome.already_done
        click.echo(f"sealed {count} of {cases} logs in {output / check.LOGS}", err=as_json)
        if as_json and (seal_only or outcome.stop_code or not count):
            print_json({"sealed": count, "of": cases, "logs": output / check.LOGS})
        if outcome.failed and not count:
            raise InputError(f"{output}: no log could be made: {next(iter(outcome.failed.values()))}")
        if seal_only or outcome.stop_code:
            return outcome.exit_code
        options = {"cases": cases, "seed": seed, "effects": effects, "sizes": sizes, "wells": ",".join(chosen),
                   "manoeuvres": manoeuvres, "log_defects": log_defects, "plants": plants, "duration": duration,
                   "rig": str(rig_path or "")}  # fmt: skip
        if rounds:
            options |= {"rounds": rounds, "minutes": minutes, "evidence_only": evidence_only}
            return _rounds(drawn, Path(str(rig)), output, options, run, as_json, units)
        sealed, stems = output, [case.file_stem() for case in drawn]
        options |= {"repeats": repeats, "oracle": oracle, "only": only}
    if answers is not None:
        _report(check.score_answers(sealed / check.LABELS, answers), {}, options, output, as_json, units)
        return 0
    checked = check.check(sealed, output, stems, check.DiagnosisRequest(_names(only), oracle=oracle), run)
    _report(checked.cases, checked.answers, options, output, as_json, units)
    return checked.exit_code


def _refuse_ignored(from_logs: bool, with_answers: bool, seal_only: bool, with_rounds: bool) -> None:
    """Raise InputError for an option that this kind of check would ignore."""
    if from_logs:
        refuse_ignored("with --logs, which are made already", _OF_LOGS)
    if with_answers:
        refuse_ignored("with --answers, where nothing is diagnosed", (*_OF_DIAGNOSES, "jobs", "scheduler"))
    if seal_only:
        refuse_ignored("with --seal-only", (*_OF_DIAGNOSES, "rounds"))
    if with_rounds:
        refuse_ignored("with --rounds", (*_OF_DIAGNOSES, "repeats"))
    else:
        refuse_ignored("without --rounds", _OF_ROUNDS)


def _rounds(
    drawn: Sequence[Case], rig: Path, output: Path, options: dict[str, Any], run: JobRunner, as_json: bool,
    units: Units,
) -> int:  # fmt: skip
    from rich.table import Table

    from slider_drilling.blind.round_totals import arm_totals, rounds_json
    from slider_drilling.blind.rounds import RoundsRequest, check_rounds
    from slider_drilling.blind.rounds_page import HEADS, arm_cells, rounds_page
    from slider_drilling.campaign.code_version import code_version
    from slider_drilling.console.streams import stdout
    from slider_drilling.files.output_files import write_atomically
    from slider_drilling.pages import write_page

    evidence_only = bool(options["evidence_only"])
    request = RoundsRequest(options["rounds"], options["minutes"], evidence_only=evidence_only)
    results, stages = check_rounds(drawn, rig, output, request, run)
    tree = rounds_json(results, {**options, "code": code_version()})
    paths = (output / "rounds.json", output / "rounds.html")

    def show() -> None:
        table = Table(*HEADS)
        for arm in arm_totals(results):
            table.add_row(*arm_cells(arm))
        stdout().print(table)

    def write() -> tuple[Path, ...]:
        write_atomically(paths[0], (json.dumps(tree, indent=1) + "\n").encode("utf-8"))
        write_page(paths[1], rounds_page(results, evidence_only), units)
        return paths

    write_and_print(tree if as_json else None, show, write)
    return max(outcome.exit_code for outcome in stages)


def _check_effect_names(names: Sequence[str]) -> None:
    from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
    from slider_drilling.errors import InputError

    for name in names:
        if name not in CATALOGUE_LAWS:
            raise InputError(f"--only {name}: not one of {', '.join(CATALOGUE_LAWS)}")


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _numbers(option: str, text: str) -> tuple[float, ...]:
    from slider_drilling.errors import InputError

    try:
        return tuple(float(number) for number in _names(text))
    except ValueError:
        raise InputError(f"{option} {text}: give numbers separated by commas, such as 0.5,1.5,4") from None


def _report(
    cases: Sequence[ScoredCase],
    answers: dict[str, dict[str, Any]],
    options: dict[str, Any],
    output: Path,
    to_json: bool,
    units: Units,
) -> None:
    from slider_drilling.blind.check import ANSWERS, as_json, write_answers
    from slider_drilling.blind.page import write_blind_page
    from slider_drilling.console.streams import stdout
    from slider_drilling.files.output_files import write_atomically

    if not cases:
        write_answers(output / ANSWERS, answers)
        click.echo(f"{output}: nothing to score: no answer has a label", err=to_json)
        return
    tree = as_json(cases, options)
    paths = (output / "blind.json", output / "blind.html")

    def show() -> None:
        for case in cases:
            stdout().print(_line(case))
        _print_totals(cases, units)

    def write() -> tuple[Path, ...]:
        write_answers(output / ANSWERS, answers)
        write_atomically(paths[0], (json.dumps(tree, indent=1) + "\n").encode("utf-8"))
        write_blind_page(paths[1], cases, tree, units)
        return paths

    write_and_print(tree if to_json else None, show, write)


def _line(case: ScoredCase) -> str:
    truth = " + ".join(case.true_effects) or "none"
    size = ", ".join(f"{size:.1f}" for size in case.sizes) if case.true_effects else "-"
    answer = " + ".join(case.named_effects) + (
        f" (or {', '.join(case.indistinguishable)})" if case.indistinguishable else ""
    )
    answer = f"masked: {', '.join(case.masked_effects)}" if case.masked_effects else answer
    return f"{case.outcome}: {truth} at {size} noise floors, {case.manoeuvre} -> {case.verdict}: {answer or 'no name'}"


def _print_totals(cases: Sequence[ScoredCase], units: Units) -> None:
    from rich.table import Table

    from slider_drilling.blind.page import total_rows
    from slider_drilling.blind.totals import count_totals
    from slider_drilling.console.streams import stdout

    table = Table("", "count, share, 95 % interval")
    for name, value in total_rows(count_totals(cases)):
        table.add_row(name, units.convert_text(value))
    stdout().print(table)
