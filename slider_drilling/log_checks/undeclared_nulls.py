"""Check for numbers that mean "no value" (-999.25, -9999, ...) in a recorded log; mask them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log.series import Array
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.messages.topics import TOPICS
from slider_drilling.null_values import null_in_some_unit, stands_apart

_CHANNELS = ("top_drive", "draw_works", "standpipe_pressure", "mud_pump", "mwd_tool_face")
_POSITIVE = ("hook_load", "standpipe_pressure", "pump_speed")
_MAX_SHARE = 0.5


def mask_undeclared_nulls(log: RigLog) -> tuple[RigLog, list[LogIssue]]:
    """The log with nulls as NaN, whatever unit they were converted from; a note for each quantity that had some."""
    issues: list[LogIssue] = []
    changed: dict[str, Any] = {}
    for key in _CHANNELS:
        series: Any = log.series().get(key)
        for quantity in TOPICS[key].quantities if series is not None else ():
            values = getattr(series, quantity.array)
            where, null = _nulls(values, quantity.unit, quantity.column in _POSITIVE)
            if not where.any():
                continue
            count, first = int(np.count_nonzero(where)), float(series.time[where][0])
            text = (
                f"{quantity.label}: {count} of {values.size} samples are {null}, the first at {first:.1f} s: taken as "
                "no value"
            )
            issues.append(LogIssue("note", key, text, "nulls"))
            series = replace(series, **{quantity.array: np.where(where, math.nan, values)})
            changed[key] = series
    return (replace(log, **changed) if changed else log), issues


def _nulls(values: Array, unit: str, positive: bool) -> tuple[Any, str]:
    """Where a quantity is a null in some unit, and how that is written."""
    none = np.zeros(values.shape, dtype=np.bool_)
    known = values[np.isfinite(values)]
    if known.size < 3:
        return none, ""
    for end in (float(known.min()), float(known.max())):
        others = known[known != end]
        if others.size < 2 or known.size - others.size > _MAX_SHARE * known.size:
            continue
        if not stands_apart(end, others, positive):
            continue
        written = null_in_some_unit(end, unit)
        if written:
            return values == end, written
    return none, ""
