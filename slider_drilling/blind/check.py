"""The blind check: seal logs, diagnose them from the logs alone, open the seals, score."""

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
from slider_drilling.blind.reported_diagnosis import (
    ReportedDiagnosis,
    diagnose_job,
    diagnosis_from_json,
    read_diagnosis,
)
from slider_drilling.blind.score import ScoredCase, score
from slider_drilling.blind.seal import REPEATS, seal_job
from slider_drilling.blind.totals import count_totals, without_nan
from slider_drilling.campaign.code_version import code_version
from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult
from slider_drilling.campaign.run import CampaignOutcome
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder, write_atomically

SCHEMA = "slider_drilling/blind/1"
LOGS, LABELS, TWINS, RESULTS, ANSWERS = "logs", "labels", "twins", "results", "answers"

JobRunner = Callable[[str, Sequence[Job], Path], CampaignOutcome]
"""(what is done, jobs, folder of their results) -> what became of them."""


@dataclass
class CheckResult:
    """Scored cases; ran: of each stage that was run, in order, so that the last one says whether it was stopped;
    answers: the diagnosis of each log, by its stem."""

    cases: list[ScoredCase]
    ran: list[CampaignOutcome]
    answers: dict[str, dict[str, Any]]

    @property
    def code(self) -> int:
        """Exit code, see `Ran.code`."""
        return max((ran.exit_code for ran in self.ran), default=0)


def seal(cases: Sequence[Case], rig: Path, folder: Path, run: JobRunner, repeats: int = REPEATS) -> CampaignOutcome:
    """Make the logs in ``folder/logs``, what is in them in ``folder/labels``, and so many twins of each in
    ``folder/twins``.
    """
    logs, labels, twins = folder / LOGS, folder / LABELS, folder / TWINS
    make_folder(logs)
    for hidden in (labels, twins):
        make_folder(hidden)
        # Only its owner may look; the diagnosing processes are kept out besides, whoever runs them.
        hidden.chmod(0o700)
    return run("sealing", [seal_job(case, rig, logs, labels, twins, repeats) for case in cases], labels / "made")


@dataclass(frozen=True)
class DiagnosisRequest:
    """How logs are diagnosed. only: candidates, all if empty; seed: of the diagnosis; oracle: whether the truth is
    fitted to the twins."""

    candidates: tuple[str, ...] = ()
    seed: int = 0
    oracle: bool = True


def check(
    sealed: Path, output: Path, stems: Sequence[str] | None, asked: DiagnosisRequest, run: JobRunner
) -> CheckResult:
    """Diagnose the sealed logs of a folder, all of them or those named, and score what has labels."""
    logs = _logs(sealed, stems)
    closed = tuple(str((sealed / name).resolve()) for name in (LABELS, TWINS))
    folder = output / RESULTS
    jobs = [diagnose_job(log, asked.seed, asked.candidates, closed) for log in logs]
    ran = [run("diagnosing", jobs, folder)]
    keys = dict(zip((log.stem for log in logs), ran[0].keys, strict=True))
    answers = {stem: result for stem, key in keys.items() if (result := ran[0].result(key)) is not None}
    labels = read_labels(sealed / LABELS) if (sealed / LABELS).is_dir() else {}
    known = {stem: label for stem, label in labels.items() if stem in keys}
    truth: dict[str, OracleResult] = {}
    if asked.oracle and not ran[0].stop_code:
        fitted, truth = _oracles(known, sealed / TWINS, asked.seed, closed[:1], folder, run)
        ran.append(fitted)
    cases = []
    for stem, label in known.items():
        failed = stem not in answers and ran[0].results.error(keys[stem]) is not None
        if stem in answers or failed:
            cases.append(_scored(label, answers.get(stem), stem, truth.get(stem, NO_ORACLE)))
    return CheckResult(cases, ran, {stem: result.tree for stem, result in answers.items()})


def write_answers(folder: Path, answers: Mapping[str, dict[str, Any]]) -> None:
    """Write each log's diagnosis into a file of the folder. Raises InputError."""
    make_folder(folder)
    for stem, tree in answers.items():
        content = (json.dumps(tree, indent=1, allow_nan=False) + "\n").encode("utf-8")
        write_atomically(folder / f"{stem}.json", content)


def score_answers(labels: Path, answers: Path) -> list[ScoredCase]:
    """Score diagnosis.json files, ``LOG.json`` or ``LOG/diagnosis.json``, of whatever made them."""
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
    """The tree of blind.json."""
    rows = [{**asdict(case), "correct": case.correct} for case in cases]
    date = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
    tree = {"schema": SCHEMA, "date": date, "code": code_version(), "options": options,
            "totals": asdict(count_totals(cases)), "cases": rows}  # fmt: skip
    found: dict[str, Any] = without_nan(tree)
    return found


def _logs(sealed: Path, stems: Sequence[str] | None) -> list[Path]:
    found = sorted((sealed / LOGS).glob("*.mcap"))
    if stems is not None:
        found = [path for path in found if path.stem in stems]
    if not found:
        raise InputError(f"{sealed / LOGS}: holds no sealed logs (*.mcap); make some with `blind-check --seal-only`")
    return found


def _oracles(
    labels: dict[str, Label], twins: Path, seed: int, closed: tuple[str, ...], folder: Path, run: JobRunner
) -> tuple[CampaignOutcome, dict[str, OracleResult]]:
    made = {stem: found for stem in labels if (found := sorted(twins.glob(f"{stem}_*.mcap")))}
    jobs = [oracle_job(stem, found, labels[stem].effects, seed, closed) for stem, found in made.items()]
    ran = run("fitting the truth", jobs, folder)
    results = {stem: ran.result(key) for stem, key in zip(made, ran.keys, strict=True)}
    return ran, {stem: OracleResult(**result.tree) for stem, result in results.items() if result is not None}


def _scored(label: Label, result: JobResult | None, stem: str, oracle: OracleResult) -> ScoredCase:
    if result is None:
        return score(label, None)
    answer: ReportedDiagnosis = diagnosis_from_json(result.tree, f"answer to {stem}")
    return score(label, answer, oracle, result.cpu_s, result.wall_s)
