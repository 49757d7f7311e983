"""diagnosis.json: the outcome as a tree of plain values (schema slider_drilling/diagnosis/2)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

from slider_drilling import __version__
from slider_drilling.diagnosis.result import Gap, RankedEffect

if TYPE_CHECKING:
    from slider_drilling.diagnosis.diagnose import Diagnosis

SCHEMA = "slider_drilling/diagnosis/2"


def to_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """The tree of diagnosis.json: SI and rad, null for what is not known; docs/reference/diagnosis.md has every key."""
    outcome, logs = diagnosis.outcome, diagnosis.logs
    tree = {
        "schema": SCHEMA,
        "version": __version__,
        "log": logs[0] if len(logs) == 1 else list(logs),
        "rig": diagnosis.rig_source,
        "verdict": outcome.verdict,
        "driller": diagnosis.driller,
        "sentence": diagnosis.sentence,
        "site": outcome.site,
        "effects": outcome.effects,
        "instead": outcome.instead,
        "shape": outcome.shape,
        "partial": outcome.partial,
        "gap": outcome.gap or Gap(),
        "simulated": outcome.simulated,
        "where": outcome.where,
        "ranking": [_candidate(entry) for entry in outcome.ranking],
        "next_manoeuvre": outcome.next_manoeuvre,
        "tuned_parameters": outcome.tuned_parameters,
        "horizon": outcome.horizon,
        "foretold": outcome.foretold,
        "counts": outcome.counts,
        "remarks": diagnosis.remarks,
        "would_help": diagnosis.would_help,
        "runtime_s": outcome.runtime,
    }
    plain: dict[str, Any] = _plain(tree)
    return plain


def _candidate(entry: RankedEffect) -> dict[str, Any]:
    """With the parameters' short names: the effect's own is beside them."""
    tree = {field.name: getattr(entry, field.name) for field in fields(RankedEffect)}
    tree["parameters"] = {name.rpartition(".")[2]: fitted for name, fitted in entry.parameters.items()}
    return tree


def _plain(value: Any) -> Any:
    """Dataclasses, mappings and tuples as dicts and lists; numbers that are none as None."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    if isinstance(value, (bool, str, int)) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None
