"""What a diagnosis could have said at best: the true effects, and no others, fitted to another run of the same rig."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slider_drilling.campaign.job import Job


def oracle_job(twin: Path, effects: Sequence[str], seed: int, closed: tuple[str, ...]) -> Job:
    """The job that fits the true effects of one log to its twin."""
    options = {"effects": sorted(effects)}
    call = "slider_drilling.blind.oracle:fit_truth"
    return Job(call, f"oracle of {twin.stem}", {"log": str(twin)}, options, seed, closed=closed)


def fit_truth(job: Job) -> dict[str, Any]:
    """``closed``: see `oracle`."""
    return {"closed": oracle(Path(job.inputs["log"]), job.options["effects"], job.seed)}


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
