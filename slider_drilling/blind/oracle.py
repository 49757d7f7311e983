"""What a diagnosis could have said at best: the true effects, and no others, fitted to the same run made again."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from slider_drilling.campaign.job import Job


def oracle_job(stem: str, twins: Sequence[Path], effects: Sequence[str], seed: int, closed: tuple[str, ...]) -> Job:
    """The job that fits the true effects of one log to its twins."""
    options = {"effects": sorted(effects)}
    call = "slider_drilling.blind.oracle:fit_truth"
    inputs = {twin.stem: str(twin) for twin in twins}
    return Job(call, f"oracle of {stem}", inputs, options, seed, forbidden_folders=closed)


@dataclass(frozen=True)
class OracleResult:
    """closed: share of the tuned model's gap that the true effects close together, the mean over repeats of the run,
    None where there is nothing to close; named: share of the repeats in which they are all named, with no other
    candidate, None where no log can show one of them.
    """

    closed_share: float | None
    named_share: float | None


NO_ORACLE = OracleResult(None, None)


def fit_twins(job: Job) -> dict[str, Any]:
    """A `Truth` as JSON, of all twins that say something."""
    found = [fit_true_effects(Path(twin), job.options["effects"], job.seed) for twin in job.inputs.values()]
    return asdict(OracleResult(_mean(one.closed_share for one in found), _mean(one.named_share for one in found)))


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def fit_true_effects(log: Path, effects: Sequence[str], seed: int) -> OracleResult:
    """What the true effects make of one log. Raises InputError where the log cannot be read."""
    from slider_drilling.diagnosis.diagnose import diagnose
    from slider_drilling.diagnosis.to_json import to_json
    from slider_drilling.errors import InputError
    from slider_drilling.log import read_log

    record = read_log(log)
    try:
        tree = to_json(diagnose([record], record.rig(), seed=seed, only=effects))
    except InputError:
        return NO_ORACLE
    closed: float | None = tree["gap"]["closed"]
    if closed is None and tree["ranking"] and len(effects) == 1:
        # Fitted, and not accepted.
        closed = tree["ranking"][0]["closed"]
    return OracleResult(closed, float(set(effects) <= set(tree["effects"])))
