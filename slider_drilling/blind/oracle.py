"""The oracle: the true effects, and no other candidates, fitted to repeats of the same run.

It shows what the best possible diagnosis could report of such a run.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from slider_drilling.campaign.job import Job


@dataclass(frozen=True)
class OracleResult:
    """What the true effects alone achieve.

    Attributes:
        closed_share: Share of the calibrated model's gap that they close together, the mean over the repeats; None
            where there is no gap to close.
        named_share: Share of the repeats in which all of them are named; None where no log can show one of them.
    """

    closed_share: float | None
    named_share: float | None


NO_ORACLE = OracleResult(None, None)


def oracle_job(
    stem: str, twins: Sequence[Path], effects: Sequence[str], seed: int, forbidden_folders: tuple[str, ...]
) -> Job:
    """Returns the job that fits the true effects of one log to its twins.

    Args:
        stem: Of the log.
        twins: Logs of repeats of the run.
        effects: The true effects.
        seed: Of the diagnosis.
        forbidden_folders: Folders that the job cannot read.
    """
    inputs = {twin.stem: str(twin) for twin in twins}
    options = {"effects": sorted(effects)}
    return Job("slider_drilling.blind.oracle:fit_twins", f"oracle of {stem}", inputs, options, seed,
               forbidden_folders=forbidden_folders)  # fmt: skip


def fit_twins(job: Job) -> dict[str, Any]:
    """Returns the `OracleResult` over the job's twins, as JSON holds it."""
    results = [fit_true_effects(Path(twin), job.options["effects"], job.seed) for twin in job.inputs.values()]
    closed = _mean(result.closed_share for result in results)
    return asdict(OracleResult(closed, _mean(result.named_share for result in results)))


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def fit_true_effects(log: Path, effects: Sequence[str], seed: int) -> OracleResult:
    """Returns what the true effects achieve on one log.

    Raises:
        InputError: The log cannot be read.
    """
    from slider_drilling.diagnosis.diagnose import diagnose
    from slider_drilling.diagnosis.to_json import to_json
    from slider_drilling.errors import InputError
    from slider_drilling.log import read_log

    rig_log = read_log(log)
    try:
        tree = to_json(diagnose([rig_log], rig_log.rig(), seed=seed, only=effects))
    except InputError:
        # The log lacks the channels that can show the effect.
        return NO_ORACLE
    closed: float | None = tree["gap"]["closed"]
    if closed is None and tree["ranking"] and len(effects) == 1:
        # The effect was fitted and not accepted.
        closed = tree["ranking"][0]["closed"]
    return OracleResult(closed, float(set(effects) <= set(tree["effects"])))
