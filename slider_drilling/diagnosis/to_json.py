"""diagnosis.json: the result, field by field. docs/reference/diagnosis.md explains every key."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from slider_drilling import __version__
from slider_drilling.diagnosis.describe_curve import axis_labels, describe_curve
from slider_drilling.diagnosis.result import Diagnosis, Gap, RankedEffect, ResidualShape
from slider_drilling.diagnosis.sentences import summary, technical_summary
from slider_drilling.gap.experiment_design.knowledge import Explanation
from slider_drilling.gap.results.next_manoeuvre import RecommendedManoeuvre
from slider_drilling.gap.results.whole_runs import WholeRunErrors
from slider_drilling.rig import dump_rig

SCHEMA = "slider_drilling/diagnosis/3"


def to_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """The tree of diagnosis.json: SI units and rad, null for what is unknown."""
    logs, errors, shape = diagnosis.logs, diagnosis.whole_run_errors, diagnosis.residual_shape
    return {
        "schema": SCHEMA,
        "version": __version__,
        "log": logs[0] if len(logs) == 1 else list(logs),
        "rig": _plain(diagnosis.rig_source),
        "rig_file": dump_rig(diagnosis.rig),
        "verdict": diagnosis.verdict,
        "summary": str(summary(diagnosis)),
        "technical_summary": technical_summary(diagnosis),
        "site": diagnosis.site,
        "effects": list(diagnosis.effects),
        "suspected": list(diagnosis.suspected),
        "masked_effects": list(diagnosis.masked_effects),
        "small_cause": diagnosis.small_cause,
        "residual_shape": None if shape is None else _residual_shape(shape),
        "interrupted": diagnosis.interrupted,
        "gap": _plain(diagnosis.gap or Gap()),
        "fed_back": diagnosis.fed_back,
        "whole_run_errors": None if errors is None else _whole_run_errors(errors),
        "where": _plain(diagnosis.breakdown),
        "ranking": [_ranked_effect(ranked) for ranked in diagnosis.ranking],
        "next_manoeuvre": None if diagnosis.next_manoeuvre is None else _next_manoeuvre(diagnosis.next_manoeuvre),
        "explanations": [explanation_json(each) for each in diagnosis.explanations],
        "tuned_parameters": _plain(diagnosis.tuned_parameters),
        "prediction_horizon": None if errors is None else _plain(errors.horizon),
        "predictable_to_end": [] if errors is None else list(errors.predictable_to_end),
        "counts": {"simulations": diagnosis.simulations, "not_refitted": diagnosis.not_refitted},
        "remarks": [str(remark) for remark in diagnosis.remarks],
        "missing_channels": list(diagnosis.missing_channels),
        "runtime_s": diagnosis.runtime,
        "change": _plain(diagnosis.change),
    }


def _whole_run_errors(errors: WholeRunErrors) -> dict[str, Any]:
    return {
        "fitted_share": _plain(errors.share),
        "fitted_part": _plain(errors.fitted),
        "rest": _plain(errors.rest),
        "whole_run": _plain(errors.whole),
        "fitted_parameters": _plain(errors.freed),
    }


def _ranked_effect(ranked: RankedEffect) -> dict[str, Any]:
    """Parameters have their short names: the effect's own is beside them."""
    short = {name.rpartition(".")[2]: fitted for name, fitted in ranked.parameters.items()}
    return {field.name: _plain(getattr(ranked, field.name)) for field in fields(ranked)} | {"parameters": _plain(short)}


def _next_manoeuvre(asked: RecommendedManoeuvre) -> dict[str, Any]:
    return {
        "reason": asked.reason,
        "description": asked.manoeuvre.description,
        "settings": _plain(asked.manoeuvre.settings),
        "separates": list(asked.separates),
        "log_likelihood_ratio": _plain(asked.log_likelihood_ratio),
        "detectable": _plain(asked.detectable),
    }


def explanation_json(each: Explanation) -> dict[str, Any]:
    """One explanation; its parameters have the names of the fit."""
    return {"effects": list(each.effects), "weight": each.weight, "fidelity": each.fidelity,
            "parameters": _plain(each.fitted)}  # fmt: skip


def _residual_shape(shape: ResidualShape) -> dict[str, Any]:
    x_label, y_label = axis_labels(shape.disturbance, shape.x_unit, shape.y_unit)
    return {
        "of": shape.of,
        "description": str(describe_curve(shape.disturbance, shape.x, shape.x_unit, shape.y, shape.y_unit)),
        "x_label": x_label,
        "y_label": y_label,
        "x": _plain(shape.x),
        "y": _plain(shape.y),
    }


def _plain(value: Any) -> Any:
    """Dataclasses and mappings as dicts, arrays and tuples as lists, numbers that are not finite as None."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, (bool, str, int)) or value is None:
        return value
    return float(value) if math.isfinite(float(value)) else None
