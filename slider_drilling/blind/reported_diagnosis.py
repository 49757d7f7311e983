"""What a diagnosis reports of one log: the content of its diagnosis.json. Nothing else is scored."""

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
_VERDICTS_WITH_NAMES = ("effect", "effect_and_unknown")


@dataclass(frozen=True)
class ReportedDiagnosis:
    """One diagnosis.

    Attributes:
        verdict: See docs/reference/diagnosis.md, or ``failed``.
        named_effects: Effects that the verdict rests on; empty for a verdict without a name.
        indistinguishable: For each named effect, those that the log cannot distinguish from it.
        masked_effects: Effects that calibration may stand for: it was enough, but went far from the rig file.
        site: None for a verdict without a site.
        calibrated_gap: E after calibration of the nuisance parameters alone.
        closed: Share of the gap that the named effects close; NaN where none is given.
        closed_interval: 95 % interval of that share; NaN where none is given.
        parameters: Fitted values of each effect in the ranking.
    """

    verdict: str
    named_effects: tuple[str, ...]
    indistinguishable: Mapping[str, tuple[str, ...]]
    masked_effects: tuple[str, ...]
    site: str | None
    calibrated_gap: float
    closed: float
    closed_interval: tuple[float, float]
    parameters: Mapping[str, Mapping[str, float]]

    def covers(self, name: str) -> bool:
        """Returns whether an effect is named, or cannot be distinguished from a named one."""
        return any(name == named or name in self.indistinguishable[named] for named in self.named_effects)


FAILED = ReportedDiagnosis("failed", (), {}, (), None, math.nan, math.nan, (math.nan, math.nan), {})
"""Stands for a diagnosis that ended with an error."""


def diagnose_job(log: Path, seed: int, candidates: Sequence[str], forbidden_folders: tuple[str, ...]) -> Job:
    """Returns the job that diagnoses one log.

    Args:
        log: The log.
        seed: Of the diagnosis.
        candidates: Effects that are considered; all if empty.
        forbidden_folders: Folders that the job cannot read.
    """
    function = "slider_drilling.blind.reported_diagnosis:diagnose_log"
    options = {"only": list(candidates)}
    return Job(function, log.stem, {"log": str(log)}, options, seed, forbidden_folders=forbidden_folders)


def diagnose_log(job: Job) -> dict[str, Any]:
    """Returns the tree of diagnosis.json for the job's log."""
    from slider_drilling.diagnosis.diagnose import diagnose
    from slider_drilling.diagnosis.to_json import to_json
    from slider_drilling.log import read_log

    log = read_log(job.inputs["log"])
    return to_json(diagnose([log], log.rig(), seed=job.seed, only=job.options["only"]))


def read_diagnosis(path: Path) -> ReportedDiagnosis:
    """Returns the diagnosis in a diagnosis.json.

    Raises:
        InputError: The file is not a diagnosis.json.
    """
    try:
        tree = json.loads(read_text(path, "diagnosis"))
    except ValueError:
        raise InputError(f"{path}: not JSON") from None
    return diagnosis_from_json(tree, str(path))


def diagnosis_from_json(tree: Mapping[str, Any], source: str) -> ReportedDiagnosis:
    """Returns the diagnosis in the tree of a diagnosis.json.

    Args:
        tree: Of one of the versions in `SCHEMAS`.
        source: Where the tree comes from, for messages.

    Raises:
        InputError: The tree is not a diagnosis.
    """
    try:
        if tree["schema"] not in SCHEMAS:
            raise InputError(f"{source}: schema = {tree['schema']!r}: this version reads {', '.join(SCHEMAS)}")
        named = tuple(tree["effects"]) if tree["verdict"] in _VERDICTS_WITH_NAMES else ()
        groups = {entry["effect"]: tuple(entry["group"]) for entry in tree["ranking"]}
        low, high = (_number(bound) for bound in tree["gap"]["closed_interval"] or (None, None))
        return ReportedDiagnosis(
            verdict=tree["verdict"],
            named_effects=named,
            indistinguishable={name: groups.get(name, ()) for name in named},
            masked_effects=tuple(tree.get("masked_effects", tree.get("instead", ()))),
            site=tree["site"],
            calibrated_gap=_number(tree["gap"].get("tuned")),
            closed=_number(tree["gap"]["closed"]),
            closed_interval=(low, high),
            parameters={entry["effect"]: _values(entry["parameters"]) for entry in tree["ranking"]},
        )
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{source}: not a diagnosis.json: {type(error).__name__} at {error}") from None


def _values(parameters: Mapping[str, Any]) -> dict[str, float]:
    """Version 1 has numbers; later ones have each number with its unit, nominal value and interval."""
    return {name: _number(value["value"] if isinstance(value, dict) else value) for name, value in parameters.items()}


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)
