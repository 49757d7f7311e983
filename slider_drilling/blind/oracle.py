"""What a diagnosis could have said at best: the true effects, and no others, fitted to the same run made again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slider_drilling.campaign.job import Job


def oracle_job(stem: str, twins: Sequence[Path], effects: Sequence[str], seed: int, closed: tuple[str, ...]) -> Job:
    """The job that fits the true effects of one log to its twins."""
    options = {"effects": sorted(effects)}
    call = "slider_drilling.blind.oracle:fit_truth"
    inputs = {twin.stem: str(twin) for twin in twins}
    return Job(call, f"oracle of {stem}", inputs, options, seed, closed=closed)


def fit_truth(job: Job) -> dict[str, Any]:
    """``closed``: the mean over the twins of what `oracle` says, None where it says nothing of any of them."""
    found = [oracle(Path(twin), job.options["effects"], job.seed) for twin in job.inputs.values()]
    known = [share for share in found if share is not None]
    return {"closed": sum(known) / len(known) if known else None}


def oracle(log: Path, effects: Sequence[str], seed: int) -> float | None:
    """Share of the tuned model's gap that the true effects close together on a log.

    None where there is nothing to close, and where
    the log cannot show one of the effects. Raises InputError where the log cannot be read.
    """
    from slider_drilling.diagnosis.diagnose import diagnose
    from slider_drilling.diagnosis.tree import as_json
    from slider_drilling.errors import InputError
    from slider_drilling.log import read_log

    record = read_log(log)
    try:
        tree = as_json(diagnose([record], record.rig(), seed=seed, only=effects))
    except InputError:
        return None
    closed: float | None = tree["gap"]["closed"]
    if closed is None and tree["ranking"] and len(effects) == 1:
        # Fitted, and not accepted.
        closed = tree["ranking"][0]["closed"]
    return closed
