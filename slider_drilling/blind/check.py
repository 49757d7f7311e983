"""The blind check: seal logs, diagnose them from the logs alone, open the labels, score."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from slider_drilling.blind.cases import Case
from slider_drilling.blind.label import Label, read_labels
from slider_drilling.blind.oracle import NO_ORACLE, OracleResult, oracle_job
from slider_drilling.blind.reported_diagnosis import diagnose_job, diagnosis_from_json, read_diagnosis
from slider_drilling.blind.score import ScoredCase, score
from slider_drilling.blind.seal import REPEATS, seal_job
from slider_drilling.blind.totals import count_totals, without_nan
from slider_drilling.campaign.code_version import code_version
from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult
from slider_drilling.campaign.run import CampaignOutcome
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder, make_subfolder, write_atomically

SCHEMA = "slider_drilling/blind/2"
LOGS, LABELS, TWINS, RESULTS, ANSWERS = "logs", "labels", "twins", "results", "answers"

JobRunner = Callable[[str, Sequence[Job], Path], CampaignOutcome]
"""(stage, jobs, folder of their results) -> outcome."""


@dataclass
class CheckResult:
    """What a blind check found.

    Attributes:
        cases: The scored cases.
        stages: Outcome of each stage that was run, in order; the last one shows whether the check was stopped.
        answers: Tree of diagnosis.json by the stem of its log.
    """

    cases: list[ScoredCase]
    stages: list[CampaignOutcome]
    answers: dict[str, dict[str, Any]]

    @property
    def exit_code(self) -> int:
        """See `CampaignOutcome.exit_code`."""
        return max((outcome.exit_code for outcome in self.stages), default=0)


def seal(cases: Sequence[Case], rig: Path, folder: Path, run: JobRunner, repeats: int = REPEATS) -> CampaignOutcome:
    """Makes logs, labels and twins in subfolders.

    Args:
        cases: What to seal.
        rig: Rig file that wells, string and fluids are drawn from.
        folder: Folder of the subfolders `LOGS`, `LABELS` and `TWINS`.
        run: Runs the jobs.
        repeats: Twins of each log.
    """
    logs, labels, twins = folder / LOGS, folder / LABELS, folder / TWINS
    make_folder(logs)
    for hidden in (labels, twins):
        make_folder(hidden)
        # No other user may read them; `Job.forbidden_folders` keeps the diagnosing processes out.
        hidden.chmod(0o700)
    return run("sealing", [seal_job(case, rig, logs, labels, twins, repeats) for case in cases], labels / "made")


@dataclass(frozen=True)
class DiagnosisRequest:
    """How logs are diagnosed.

    Attributes:
        candidates: Effects that are considered; all if empty.
        seed: Of the diagnosis.
        oracle: Whether the true effects are fitted to the twins.
    """

    candidates: tuple[str, ...] = ()
    seed: int = 0
    oracle: bool = True


def check(
    sealed: Path, output: Path, stems: Sequence[str] | None, request: DiagnosisRequest, run: JobRunner
) -> CheckResult:
    """Diagnoses sealed logs and scores those that have a label.

    Args:
        sealed: Folder that `seal` filled.
        output: Folder of the results.
        stems: Logs to diagnose; None for all.
        request: How logs are diagnosed.
        run: Runs the jobs.

    Raises:
        InputError: There are no logs.
    """
    logs = _find_logs(sealed, stems)
    forbidden = tuple(str((sealed / name).resolve()) for name in (LABELS, TWINS))
    folder = make_subfolder(output, RESULTS)
    jobs = [diagnose_job(log, request.seed, request.candidates, forbidden) for log in logs]
    diagnosed = run("diagnosing", jobs, folder)
    keys = dict(zip((log.stem for log in logs), diagnosed.keys, strict=True))
    answers = {stem: result for stem, key in keys.items() if (result := diagnosed.result(key)) is not None}
    labels = read_labels(sealed / LABELS) if (sealed / LABELS).is_dir() else {}
    labels = {stem: label for stem, label in labels.items() if stem in keys}
    stages = [diagnosed]
    oracles: dict[str, OracleResult] = {}
    if request.oracle and not diagnosed.stop_code:
        fitted, oracles = _fit_oracles(labels, sealed / TWINS, request.seed, forbidden[:1], folder, run)
        stages.append(fitted)
    cases = []
    for stem, label in labels.items():
        if stem in answers:
            cases.append(_scored(label, answers[stem], stem, oracles.get(stem, NO_ORACLE)))
        elif diagnosed.results.error(keys[stem]) is not None:
            cases.append(score(label, None))
    return CheckResult(cases, stages, {stem: result.tree for stem, result in answers.items()})


def write_answers(folder: Path, answers: Mapping[str, dict[str, Any]]) -> None:
    """Writes each log's diagnosis into a file of the folder.

    Raises:
        InputError: A file cannot be written.
    """
    make_folder(folder)
    for stem, tree in answers.items():
        content = (json.dumps(tree, indent=1, allow_nan=False) + "\n").encode("utf-8")
        write_atomically(folder / f"{stem}.json", content)


def score_answers(labels: Path, answers: Path) -> list[ScoredCase]:
    """Scores diagnosis.json files of any origin.

    Args:
        labels: Folder of the labels.
        answers: Folder of ``LOG.json`` or ``LOG/diagnosis.json``.

    Raises:
        InputError: No log that has a label has an answer.
    """
    cases = []
    for stem, label in read_labels(labels).items():
        for path in (answers / f"{stem}.json", answers / stem / "diagnosis.json"):
            if path.is_file():
                cases.append(score(label, read_diagnosis(path)))
                break
    if not cases:
        raise InputError(f"{answers}: holds no answer to any of the logs labelled in {labels}")
    return cases


def as_json(cases: Sequence[ScoredCase], options: dict[str, Any]) -> dict[str, Any]:
    """Returns the tree of blind.json."""
    rows = [{**asdict(case), "correct": case.correct} for case in cases]
    date = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
    tree: dict[str, Any] = without_nan(
        {"schema": SCHEMA, "date": date, "code": code_version(), "options": options,
         "totals": asdict(count_totals(cases)), "cases": rows}
    )  # fmt: skip
    return tree


def _find_logs(sealed: Path, stems: Sequence[str] | None) -> list[Path]:
    logs = [path for path in sorted((sealed / LOGS).glob("*.mcap")) if stems is None or path.stem in stems]
    if not logs:
        raise InputError(f"{sealed / LOGS}: holds no sealed logs (*.mcap); make some with `blind-check --seal-only`")
    return logs


def _fit_oracles(
    labels: dict[str, Label], twins: Path, seed: int, forbidden: tuple[str, ...], folder: Path, run: JobRunner
) -> tuple[CampaignOutcome, dict[str, OracleResult]]:
    repeats = {stem: paths for stem in labels if (paths := sorted(twins.glob(f"{stem}_*.mcap")))}
    jobs = [oracle_job(stem, paths, labels[stem].effects, seed, forbidden) for stem, paths in repeats.items()]
    outcome = run("fitting the true effects", jobs, folder)
    results = {
        stem: outcome.parse(key, lambda result: OracleResult(**result.tree))
        for stem, key in zip(repeats, outcome.keys, strict=True)
    }
    return outcome, {stem: result for stem, result in results.items() if result is not None}


def _scored(label: Label, result: JobResult, stem: str, oracle: OracleResult) -> ScoredCase:
    answer = diagnosis_from_json(result.tree, f"answer to {stem}")
    return score(label, answer, oracle, result.cpu_s, result.wall_s)
