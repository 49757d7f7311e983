"""What a diagnosis said of one log, as its diagnosis.json holds it: nothing else is scored."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider_drilling.campaign.job import Job
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text

SCHEMAS = tuple(f"slider_drilling/diagnosis/{version}" for version in (1, 2, 3))
_NAMING = ("effect", "effect_and_unknown")


@dataclass(frozen=True)
class ReportedDiagnosis:
    """named: what the verdict rests on, empty where it names nothing; groups: what each named effect could not be told
    from; instead: what a re-tuning that was enough, but went far, may stand for; site: None where the verdict has none;
    tuned: E with nothing but the nuisance re-tuned; closed, interval: share of the gap, NaN where none is given;
    parameters: of each effect in the ranking.
    """

    verdict: str
    named_effects: tuple[str, ...]
    indistinguishable: Mapping[str, tuple[str, ...]]
    suspected: tuple[str, ...]
    site: str | None
    calibrated_gap: float
    closed: float
    closed_interval: tuple[float, float]
    parameters: Mapping[str, Mapping[str, float]]

    def covers(self, name: str) -> bool:
        """Whether an effect is named, or is one that a named one could not be told from."""
        return any(name == other or name in self.indistinguishable[other] for other in self.named_effects)


def diagnose_job(log: Path, seed: int, only: Sequence[str], closed: tuple[str, ...]) -> Job:
    """The job that diagnoses one log and can open nothing in the closed folders; only: as `diagnose` has it."""
    call = "slider_drilling.blind.reported_diagnosis:diagnose_log"
    return Job(call, log.stem, {"log": str(log)}, {"only": list(only)}, seed, forbidden_folders=closed)


def diagnose_log(job: Job) -> dict[str, Any]:
    """The tree of diagnosis.json for the job's one log."""
    from slider_drilling.diagnosis.diagnose import diagnose
    from slider_drilling.diagnosis.to_json import to_json
    from slider_drilling.log import read_log

    log = read_log(job.inputs["log"])
    return to_json(diagnose([log], log.rig(), seed=job.seed, only=job.options["only"]))


def read_diagnosis(path: Path) -> ReportedDiagnosis:
    """Raises InputError where it is no diagnosis.json."""
    try:
        tree = json.loads(read_text(path, "diagnosis"))
    except ValueError:
        raise InputError(f"{path}: not JSON") from None
    return diagnosis_from_json(tree, str(path))


def diagnosis_from_json(tree: dict[str, Any], source: str) -> ReportedDiagnosis:
    """From the tree of a diagnosis.json of schema 1 or 2. Raises InputError naming the source."""
    try:
        if tree["schema"] not in SCHEMAS:
            raise InputError(f"{source}: schema = {tree['schema']!r}: this version reads {' and '.join(SCHEMAS)}")
        named = tuple(tree["effects"]) if tree["verdict"] in _NAMING else ()
        groups = {entry["effect"]: tuple(entry["group"]) for entry in tree["ranking"]}
        low, high = (_number(bound) for bound in tree["gap"]["closed_interval"] or (None, None))
        return ReportedDiagnosis(
            verdict=tree["verdict"],
            named_effects=named,
            indistinguishable={name: groups.get(name, ()) for name in named},
            suspected=tuple(tree.get("masked_effects", ())),
            site=tree["site"],
            calibrated_gap=_number(tree["gap"].get("tuned")),
            closed=_number(tree["gap"]["closed"]),
            closed_interval=(low, high),
            parameters={entry["effect"]: _values(entry["parameters"]) for entry in tree["ranking"]},
        )
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{source}: not a diagnosis.json: {type(error).__name__} at {error}") from None


def _values(parameters: Mapping[str, Any]) -> dict[str, float]:
    """Schema 1 has numbers, later ones each with its unit, nominal value and interval."""
    return {name: _number(value["value"] if isinstance(value, dict) else value) for name, value in parameters.items()}


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)
