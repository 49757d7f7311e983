"""The loop of an investigation. Its folder holds everything; the same command goes on where the files end.

investigation_setup.json  log1.mcap  diagnosis1/  programme1.yaml  test_plan1.html  log2.mcap  diagnosis2/  ...
investigation.html
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from slider_drilling.diagnosis.diagnose import diagnose
from slider_drilling.diagnosis.earlier_answer import read_earlier_answer
from slider_drilling.diagnosis.programme_numbers import ROUTINE, programme_of, programme_variables
from slider_drilling.diagnosis.save import write_diagnosis
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder, write_atomically
from slider_drilling.gap.experiment_design.plan import LIMIT_SHARE
from slider_drilling.gap.progress import Progress
from slider_drilling.investigation.round import Round, RoundAnswer, planned_test, read_round_answer
from slider_drilling.log import read_log
from slider_drilling.pages import write_page
from slider_drilling.programmes import dump_programme
from slider_drilling.rig import Rig
from slider_drilling.test_planning.drilling_plan import DrillingPlan, PlanTestOptions, plan_after
from slider_drilling.test_planning.plan_page import plan_page
from slider_drilling.units import Units

COMMISSIONING = "commissioning"
FIRST_PROGRAMME = "programme0.yaml"
ROUTINE_S = 120.0
"""Length of the routine programme that an investigation without a log begins with."""
# A further test is worth its time if it leaves less than this share of what is open now, and something is open.
_WORTHWHILE, _LITTLE = 0.9, 0.02

Recorder = Callable[[int, Path, Path], bool]
"""(number of the run, its programme, path of its log) -> whether the log is there."""


@dataclass(frozen=True)
class Investigation:
    """How far an investigation has come.

    Attributes:
        rounds: The rounds so far.
        ending: Why it ended, in words; where it waits for a log, what to do.
        waits_for: Path of the log that it waits for; None if it ended.
        sealed: Of a sealed rig, when it has ended: each effect that was hidden in it, and the size (noise floors) that
            it reaches alone in the first log; None where nobody knows.
    """

    rounds: tuple[Round, ...]
    ending: str
    waits_for: Path | None = None
    sealed: tuple[tuple[str, float], ...] | None = None


@dataclass(frozen=True)
class InvestigationOptions:
    """How an investigation is run.

    Attributes:
        rounds: Largest number of tests.
        fixed_first: Whether the first test is the commissioning programme, where it fits: on sealed rigs a planned one
            has not shown more.
        plan: Of each test.
        seed: Of the diagnoses.
    """

    rounds: int = 3
    fixed_first: bool = True
    plan: PlanTestOptions = PlanTestOptions(minutes=4.0)  # noqa: RUF009 it is frozen
    seed: int = 0


def investigate(
    folder: Path, rig: Rig, record: Recorder, options: InvestigationOptions, units: Units,
    progress: Progress = lambda stage, share: None,
) -> Investigation:  # fmt: skip
    """Run an investigation, or go on with it.

    Args:
        folder: Of its files; made if it does not exist.
        rig: The rig file.
        record: Runs a programme on the rig, or looks whether somebody has.
        options: How it is run.
        units: Of its pages.
        progress: Called with the stage and the share done.

    Raises:
        InputError: A log cannot be used, or a file not written.
        KeyboardInterrupt: Interrupted; what is finished is in the folder.
    """
    make_folder(folder)
    rounds: list[Round] = []
    programme = folder / FIRST_PROGRAMME
    if not programme.is_file() and not log_path(folder, 1).is_file():
        design = {each.name: float(ROUTINE.get(each.name, each.nominal)) for each in programme_variables(rig)}
        write_atomically(programme, dump_programme(programme_of(design, rig, ROUTINE_S)).encode())
    for number in range(1, options.rounds + 2):
        log = log_path(folder, number)
        if not log.is_file() and not record(number, programme, log):
            todo = f"run {programme.name} and put its log there as {log.name}, then run the same command again"
            return Investigation(tuple(rounds), todo, log)
        answer = _answer(folder, number, rig, options, units, progress)
        done = Round(number, answer)
        if number > options.rounds:
            made = "1 test was made" if options.rounds == 1 else f"{options.rounds} tests were made"
            return Investigation((*rounds, done), made)
        plan = _plan(folder, number, rig, options, progress)
        if plan is None:
            return Investigation((*rounds, done), "nothing could be fitted: no test can be planned")
        before = plan.plan.baseline.loss
        after = plan.plan.planned.prospect.loss
        asked = answer.still_open is not None
        was_run = log_path(folder, number + 1).is_file()  # maybe planned with other options: its files stay as they are
        if was_run:
            rounds.append(Round(number, answer, planned_test(plan), before, after))
            continue
        if after > _WORTHWHILE * before or (not asked and before < _LITTLE):
            why = "the answer stands" if not asked else "nothing more can be learnt within the limits"
            return Investigation((*rounds, Round(number, answer, None, before, after)), why)
        rounds.append(Round(number, answer, planned_test(plan), before, after))
        programme = folder / f"programme{number}.yaml"
        write_atomically(programme, dump_programme(plan.programme).encode())
        write_page(folder / f"test_plan{number}.html", plan_page(plan), units)
    raise AssertionError("the last round returns")


def log_path(folder: Path, number: int) -> Path:
    """Path of a run's log."""
    return folder / f"log{number}.mcap"


def _answer(
    folder: Path, number: int, rig: Rig, options: InvestigationOptions, units: Units, progress: Progress
) -> RoundAnswer:
    """The diagnosis of all logs so far: that in the folder, or a new one."""
    own = folder / f"diagnosis{number}"
    if not (own / "diagnosis.json").is_file():
        logs = [read_log(log_path(folder, index)) for index in range(1, number + 1)]
        before = read_earlier_answer(folder / f"diagnosis{number - 1}") if number > 1 else None

        def report(stage: str, share: float) -> None:
            progress(f"round {number}: {stage}", share)

        answer = diagnose(logs, rig, seed=options.seed, after=before, progress=report)
        if answer.interrupted:
            # It is not the answer to these logs: the same command diagnoses them again.
            raise KeyboardInterrupt
        write_diagnosis(answer, own, units)
    return read_round_answer(own / "diagnosis.json")


def _plan(
    folder: Path, number: int, rig: Rig, options: InvestigationOptions, progress: Progress
) -> DrillingPlan | None:
    """The test after the logs so far; None where the diagnosis fitted nothing."""
    answer = read_earlier_answer(folder / f"diagnosis{number}")
    if not answer.explanations:
        return None
    logs = [read_log(log_path(folder, index)) for index in range(1, number + 1)]

    def report(share: float) -> None:
        progress(f"round {number}: comparing programmes", share)

    try:
        plan = plan_after(answer, logs, rig, options.plan, report)
    except InputError as error:
        raise InputError(f"round {number}: {error}") from None
    return with_fixed_test(plan) if number == 1 and options.fixed_first else plan


def with_fixed_test(plan: DrillingPlan) -> DrillingPlan:
    """The plan with the commissioning programme as its test, where time and limits allow it and it is worth it."""
    run = plan.plan.fixed[COMMISSIONING]
    allowed = run.duration <= 60.0 * plan.options.minutes and run.limit_use <= LIMIT_SHARE
    fits = allowed and run.prospect.loss <= _WORTHWHILE * plan.plan.baseline.loss
    return replace(plan, plan=replace(plan.plan, planned=run)) if fits else plan
