"""Rounds of a blind check: the rig is asked, and the answer after each programme is scored beside other programmes.

Every stage is a list of jobs. A job that plans or diagnoses cannot read the labels; the jobs that record draw the rig
again from its case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.blind.cases import Case, case_from_json
from slider_drilling.blind.check import LABELS, LOGS, TWINS, JobRunner
from slider_drilling.blind.evidence_for_truth import as_answer, as_diagnosis
from slider_drilling.blind.label import read_label
from slider_drilling.blind.manoeuvres import MANOEUVRES
from slider_drilling.blind.reported_diagnosis import diagnosis_from_json
from slider_drilling.blind.score import ScoredCase, score
from slider_drilling.blind.sealed_plant import INTERVAL_S
from slider_drilling.blind.sealed_rig import draw_sealed_rig
from slider_drilling.campaign.job import Job
from slider_drilling.campaign.run import CampaignOutcome
from slider_drilling.diagnosis.earlier_answer import earlier_answer, read_result_tree
from slider_drilling.drillstring import Commands
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.files.output_files import make_folder, make_subfolder, write_atomically
from slider_drilling.gap.experiment_design.plan import LIMIT_SHARE, limit_use
from slider_drilling.log import read_log
from slider_drilling.programmes import dump_programme, load_programme, open_loop_commands
from slider_drilling.rig import load_rig
from slider_drilling.test_planning.drilling_plan import PlanTestOptions, plan_after

ROUTINE, SECOND_ROUTINE, RANDOM, COMMISSIONING = "routine", "second routine", "random", "commissioning"
ROUNDS, PROGRAMMES, RESULTS = "rounds", "programmes", "results"
_EVALUATIONS = 90  # programmes that a plan of a blind check compares
_RANDOM_TRIES = 200


def planned(number: int) -> str:
    """Name of the arm after so many planned programmes."""
    return f"planned {number}"


@dataclass(frozen=True)
class RoundsRequest:
    """How rounds are run.

    Attributes:
        rounds: Number of planned programmes.
        minutes: Longest time of each programme.
        seed: Of plans and diagnoses.
        evidence_only: Whether, in place of diagnoses, the evidence for the true effects is measured: what the logs hold
            at best. Plans do not know the effects.
    """

    rounds: int
    minutes: float = 4.0
    seed: int = 0
    evidence_only: bool = False


@dataclass(frozen=True)
class ArmResult:
    """One case after one arm.

    Attributes:
        arm: Its name.
        case: The score.
        limit_use: Largest share of a limit that the arm's last run used in truth; None for the routine log.
        gains: By true effect, the gain of ``-2 log p`` by which it is fitted better; empty where logs were diagnosed.
    """

    arm: str
    case: ScoredCase
    limit_use: float | None = None
    gains: Mapping[str, float] = field(default_factory=dict)


def check_rounds(
    cases: Sequence[Case], rig: Path, folder: Path, request: RoundsRequest, run: JobRunner
) -> tuple[list[ArmResult], list[CampaignOutcome]]:
    """Diagnose, plan, record and diagnose again, for cases whose first logs are sealed in a folder.

    Args:
        cases: The cases; for the evidence alone, only those with effects of the catalogue count.
        rig: Rig file that they were drawn from.
        folder: Folder that `seal` filled; it gets the further logs and programmes.
        request: How rounds are run.
        run: Runs the jobs.

    Returns:
        The scores of every case and arm that came to an end, and the outcome of each stage.
    """
    work = _Rounds(rig, folder, request, run)
    made = [case for case in cases if (folder / LOGS / f"{case.file_stem()}.mcap").is_file()]
    if request.evidence_only:
        made = [case for case in made if case.kind in ("single", "two")]
    return work.results(made), work.stages


class _Rounds:
    """The stages, in order; each starts from the files of those before."""

    def __init__(self, rig: Path, folder: Path, request: RoundsRequest, run: JobRunner) -> None:
        self.rig, self.folder, self.request, self.run = rig, folder, request, run
        self.stages: list[CampaignOutcome] = []
        self.forbidden = tuple(str((folder / name).resolve()) for name in (LABELS, TWINS))
        self.saved = make_subfolder(folder, RESULTS)
        for name in (ROUNDS, PROGRAMMES):
            make_folder(folder / name)

    def results(self, cases: Sequence[Case]) -> list[ArmResult]:
        first = {case.file_stem(): [self.folder / LOGS / f"{case.file_stem()}.mcap"] for case in cases}
        by_stem = {case.file_stem(): case for case in cases}
        answers = {ROUTINE: self._diagnose(ROUTINE, by_stem, first, {})}
        uses: dict[str, dict[str, float]] = {}
        logs = first
        for number in range(1, self.request.rounds + 1):
            before = answers[ROUTINE if number == 1 else planned(number - 1)]
            arms = [planned(number)] + ([SECOND_ROUTINE, RANDOM, COMMISSIONING] if number == 1 else [])
            self._plan(number, {stem: logs[stem] for stem in before}, before)
            recorded = self._record(arms, number, {stem: by_stem[stem] for stem in before}, uses)
            for arm in arms:
                own = {stem: [*logs[stem], path] for stem, path in recorded[arm].items()}
                answers[arm] = self._diagnose(arm, by_stem, own, before)
            logs = {stem: [*logs[stem], path] for stem, path in recorded[planned(number)].items()}
        return [
            self._score(arm, by_stem[stem], path, uses.get(arm, {}).get(stem))
            for arm, of_arm in answers.items() for stem, path in of_arm.items()
        ]  # fmt: skip

    def _diagnose(
        self, arm: str, cases: Mapping[str, Case], logs: Mapping[str, Sequence[Path]], after: Mapping[str, Path]
    ) -> dict[str, Path]:
        """Result files by stem."""
        jobs = {}
        for stem, paths in logs.items():
            inputs = {f"log{number}": str(path) for number, path in enumerate(paths)}
            if self.request.evidence_only:
                jobs[stem] = Job(
                    "slider_drilling.blind.evidence_for_truth:fit_truth", f"{stem} {arm}", inputs,
                    {"effects": sorted(cases[stem].effects)}, self.request.seed, forbidden_folders=self.forbidden,
                )  # fmt: skip
                continue
            if stem in after:
                inputs["after"] = str(after[stem])
            jobs[stem] = Job(
                "slider_drilling.blind.rounds:diagnose_logs", f"{stem} {arm}", inputs, {}, self.request.seed,
                forbidden_folders=self.forbidden,
            )  # fmt: skip
        return self._done(f"diagnosing after {arm}", jobs)

    def _plan(self, number: int, logs: Mapping[str, Sequence[Path]], after: Mapping[str, Path]) -> None:
        jobs = {}
        for stem, paths in logs.items():
            inputs = {f"log{index}": str(path) for index, path in enumerate(paths)} | {"after": str(after[stem])}
            outputs = [str(self._programme(stem, planned(number)))]
            outputs += [str(self._programme(stem, RANDOM))] if number == 1 else []
            jobs[stem] = Job(
                "slider_drilling.blind.rounds:plan_programmes", f"{stem} plan {number}", inputs,
                {"minutes": self.request.minutes, "evidence_only": self.request.evidence_only},
                self.request.seed, tuple(outputs), self.forbidden,
            )  # fmt: skip
        self._done(f"planning round {number}", jobs)

    def _record(
        self, arms: Sequence[str], number: int, cases: Mapping[str, Case], uses: dict[str, dict[str, float]]
    ) -> dict[str, dict[str, Path]]:
        """Logs by arm and stem; ``uses`` gets the share of the limits that each used."""
        recorded: dict[str, dict[str, Path]] = {}
        for arm in arms:
            jobs, paths = {}, {}
            for stem, case in cases.items():
                programme = self._programme(stem, arm)
                inputs = {"rig": str(self.rig)} | ({"programme": str(programme)} if programme.is_file() else {})
                if programme.is_file() or arm in (SECOND_ROUTINE, COMMISSIONING):
                    paths[stem] = self.folder / ROUNDS / f"{stem}_{arm.replace(' ', '_')}.mcap"
                    options = {"case": case.to_json(), "arm": arm, "number": number, "minutes": self.request.minutes}
                    jobs[stem] = Job("slider_drilling.blind.rounds:record_run", f"{stem} {arm}", inputs, options,
                                     case.seed, (str(paths[stem]),))  # fmt: skip
            results = self._done(f"running {arm}", jobs)
            recorded[arm] = {stem: paths[stem] for stem in results}
            uses[arm] = {stem: float(read_result_tree(path)["limit_use"]) for stem, path in results.items()}
        return recorded

    def _programme(self, stem: str, arm: str) -> Path:
        return self.folder / PROGRAMMES / f"{stem}_{arm.replace(' ', '_')}.yaml"

    def _done(self, stage: str, jobs: Mapping[str, Job]) -> dict[str, Path]:
        if any(each.stop_code for each in self.stages):
            return {}  # what has come to its end is scored; the same command goes on
        outcome = self.run(stage, list(jobs.values()), self.saved)
        self.stages.append(outcome)
        paths = {stem: outcome.results.path(key) for stem, key in zip(jobs, outcome.keys, strict=True)}
        return {stem: path for stem, path in paths.items() if path.is_file()}

    def _score(self, arm: str, case: Case, result: Path, used: float | None) -> ArmResult:
        label = read_label(self.folder / LABELS / f"{case.file_stem()}.json")
        tree = read_result_tree(result)
        if self.request.evidence_only:
            return ArmResult(arm, score(label, as_diagnosis(tree)), used, dict(tree["gains"]))
        return ArmResult(arm, score(label, diagnosis_from_json(tree, str(result))), used)


def diagnose_logs(job: Job) -> dict[str, Any]:
    """Returns the tree of diagnosis.json for the job's logs together."""
    from slider_drilling.diagnosis.diagnose import diagnose
    from slider_drilling.diagnosis.to_json import to_json

    logs = [read_log(job.inputs[name]) for name in sorted(job.inputs) if name.startswith("log")]
    after = job.inputs.get("after")
    answer = None if after is None else earlier_answer(read_result_tree(Path(after)), after)
    return to_json(diagnose(logs, logs[0].rig(), seed=job.seed, after=answer))


def plan_programmes(job: Job) -> dict[str, Any]:
    """Writes the planned programme, and a random one of equal length, if the job has a second output."""
    logs = [read_log(job.inputs[name]) for name in sorted(job.inputs) if name.startswith("log")]
    rig, after = logs[0].rig(), Path(job.inputs["after"])
    if job.options["evidence_only"]:
        answer = as_answer(after, [log.source for log in logs])
    else:
        answer = earlier_answer(read_result_tree(after), str(after))
    options = PlanTestOptions(job.options["minutes"], evaluations=_EVALUATIONS, seed=job.seed)
    plan = plan_after(answer, logs, rig, options)
    write_atomically(Path(job.outputs[0]), dump_programme(plan.programme).encode())
    if len(job.outputs) > 1:
        programmes, knowledge = plan.programmes, plan.plan.knowledge
        generator = np.random.default_rng([job.seed, *map(ord, job.name.split()[0])])
        for _ in range(_RANDOM_TRIES):
            point = {each.name: float(generator.uniform(each.lower, each.upper)) for each in programmes.variables}
            manoeuvre = programmes.programme(point)
            if limit_use(knowledge, programmes, manoeuvre) <= LIMIT_SHARE:
                break
        else:
            raise InputError(f"{job.name}: no random programme within the limits in {_RANDOM_TRIES} tries")
        write_atomically(Path(job.outputs[1]), dump_programme(manoeuvre.programme).encode())
    loss = {name: run.prospect.loss for name, run in plan.plan.fixed.items()}
    return {"loss": {"planned": plan.plan.planned.prospect.loss, **loss}}


def record_run(job: Job) -> dict[str, Any]:
    """Writes the log of a later run, and returns the largest share of a limit that it used in truth."""
    case, arm = case_from_json(job.options["case"]), job.options["arm"]
    sealed = draw_sealed_rig(case, load_rig(job.inputs["rig"]))
    number, seconds = int(job.options["number"]), 60.0 * float(job.options["minutes"])
    if arm == SECOND_ROUTINE:
        generator = np.random.default_rng([case.seed, 7])
        commands: Commands = MANOEUVRES[case.manoeuvre](generator, sealed.rig, seconds)
    else:
        path = job.inputs.get("programme", installed_file("config/programmes/commissioning.yaml"))
        commands = open_loop_commands(load_programme(path), sealed.rig, INTERVAL_S)
        commands = commands.samples(slice(0, round(seconds / INTERVAL_S) + 1))  # the fixed programme takes four minutes
    response = sealed.record_later_run(Path(job.outputs[0]), commands, number)
    return {"limit_use": max(sealed.limits.use(response).values()), "duration_s": float(commands.time[-1])}
