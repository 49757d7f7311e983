"""The blind check: seal logs, diagnose them from the logs alone, open the seals, score."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from slider_drilling.blind.answer import Answer, answer_of, diagnose_job, read_answer
from slider_drilling.blind.label import Label, read_labels
from slider_drilling.blind.oracle import UNKNOWN, Truth, oracle_job
from slider_drilling.blind.plan import Case
from slider_drilling.blind.score import Scored, score
from slider_drilling.blind.seal import REPEATS, seal_job
from slider_drilling.blind.tally import plain, tally
from slider_drilling.campaign.code import code_version
from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import Result
from slider_drilling.campaign.run import Ran
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder, write_atomically

SCHEMA = "slider_drilling/blind/1"
LOGS, LABELS, TWINS, RESULTS, ANSWERS = "logs", "labels", "twins", "results", "answers"

Run = Callable[[str, Sequence[Job], Path], Ran]
"""(what is done, jobs, folder of their results) -> what became of them."""


@dataclass
class Checked:
    """Scored cases; ran: of each stage that was run, in order, so that the last one says whether it was stopped;
    answers: the diagnosis of each log, by its stem."""

    cases: list[Scored]
    ran: list[Ran]
    answers: dict[str, dict[str, Any]]

    @property
    def code(self) -> int:
        """Exit code, see `Ran.code`."""
        return max((ran.code for ran in self.ran), default=0)


def seal(cases: Sequence[Case], rig: Path, folder: Path, run: Run, repeats: int = REPEATS) -> Ran:
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
class Asked:
    """How logs are diagnosed. only: candidates, all if empty; seed: of the diagnosis; oracle: whether the truth is
    fitted to the twins."""

    only: tuple[str, ...] = ()
    seed: int = 0
    oracle: bool = True


def check(sealed: Path, output: Path, stems: Sequence[str] | None, asked: Asked, run: Run) -> Checked:
    """Diagnose the sealed logs of a folder, all of them or those named, and score what has labels."""
    logs = _logs(sealed, stems)
    closed = tuple(str((sealed / name).resolve()) for name in (LABELS, TWINS))
    folder = output / RESULTS
    jobs = [diagnose_job(log, asked.seed, asked.only, closed) for log in logs]
    ran = [run("diagnosing", jobs, folder)]
    keys = dict(zip((log.stem for log in logs), ran[0].keys, strict=True))
    answers = {stem: result for stem, key in keys.items() if (result := ran[0].result(key)) is not None}
    labels = read_labels(sealed / LABELS) if (sealed / LABELS).is_dir() else {}
    known = {stem: label for stem, label in labels.items() if stem in keys}
    truth: dict[str, Truth] = {}
    if asked.oracle and not ran[0].stopped:
        fitted, truth = _oracles(known, sealed / TWINS, asked.seed, closed[:1], folder, run)
        ran.append(fitted)
    cases = []
    for stem, label in known.items():
        failed = stem not in answers and ran[0].results.error(keys[stem]) is not None
        if stem in answers or failed:
            cases.append(_scored(label, answers.get(stem), stem, truth.get(stem, UNKNOWN)))
    return Checked(cases, ran, {stem: result.tree for stem, result in answers.items()})


def write_answers(folder: Path, answers: Mapping[str, dict[str, Any]]) -> None:
    """Write each log's diagnosis into a file of the folder. Raises InputError."""
    make_folder(folder)
    for stem, tree in answers.items():
        content = (json.dumps(tree, indent=1, allow_nan=False) + "\n").encode("utf-8")
        write_atomically(folder / f"{stem}.json", content)


def score_answers(labels: Path, answers: Path) -> list[Scored]:
    """Score diagnosis.json files, ``LOG.json`` or ``LOG/diagnosis.json``, of whatever made them."""
    cases = []
    for stem, label in read_labels(labels).items():
        for path in (answers / f"{stem}.json", answers / stem / "diagnosis.json"):
            if path.is_file():
                cases.append(score(label, read_answer(path)))
                break
    if not cases:
        raise InputError(f"{answers}: holds no answer to any of the logs labelled in {labels}")
    return cases


def as_json(cases: Sequence[Scored], options: dict[str, Any]) -> dict[str, Any]:
    """The tree of blind.json."""
    rows = [{**asdict(case), "right": case.right} for case in cases]
    date = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
    tree = {"schema": SCHEMA, "date": date, "code": code_version(), "options": options,
            "totals": asdict(tally(cases)), "cases": rows}  # fmt: skip
    found: dict[str, Any] = plain(tree)
    return found


def _logs(sealed: Path, stems: Sequence[str] | None) -> list[Path]:
    found = sorted((sealed / LOGS).glob("*.mcap"))
    if stems is not None:
        found = [path for path in found if path.stem in stems]
    if not found:
        raise InputError(f"{sealed / LOGS}: holds no sealed logs (*.mcap); make some with `blind-check --seal-only`")
    return found


def _oracles(
    labels: dict[str, Label], twins: Path, seed: int, closed: tuple[str, ...], folder: Path, run: Run
) -> tuple[Ran, dict[str, Truth]]:
    made = {stem: found for stem in labels if (found := sorted(twins.glob(f"{stem}_*.mcap")))}
    jobs = [oracle_job(stem, found, labels[stem].effects, seed, closed) for stem, found in made.items()]
    ran = run("fitting the truth", jobs, folder)
    results = {stem: ran.result(key) for stem, key in zip(made, ran.keys, strict=True)}
    return ran, {stem: Truth(**result.tree) for stem, result in results.items() if result is not None}


def _scored(label: Label, result: Result | None, stem: str, oracle: Truth) -> Scored:
    if result is None:
        return score(label, None)
    answer: Answer = answer_of(result.tree, f"answer to {stem}")
    return score(label, answer, oracle, result.cpu, result.wall)
