"""The table of log checks: one row for each check, what it found, and what was done or is needed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log_checks.issue import Check, LogIssue
from slider_drilling.log_checks.time_stamps import surface_series
from slider_drilling.units import Text, sentence

_RESULTS = {"unusable": "correct it", "uninformative": "no conclusion", "note": "noted"}
_WORST = ("unusable", "uninformative", "note")
_MAX_TEXTS = 3  # of one row; the rest is counted
_FOUND_NOTHING: dict[Check, str] = {
    "gaps": "no sample is missing",
    "clock": "stamps ascend, no step",
    "nulls": "no number that means no value",
    "signs": "speed, torque and block have the signs of the log's conventions",
    "integrated": "no angle or position was integrated",
    "units and levels": "levels fit the rig file",
    "block weight": "the hook load while rotating is the string's weight",
}  # fmt: skip
CHECKS: tuple[Check, ...] = (
    "rate", "gaps", "clock", "nulls", "samples", "signs", "integrated", "units and levels", "block weight", "motion",
)  # fmt: skip


@dataclass(frozen=True)
class CheckRow:
    """One row of the table.

    Attributes:
        check: Its name.
        result: ``ok``, ``noted``, ``no conclusion``, ``correct it`` or ``not checked``.
        text: What was found, and what was done or is needed.
    """

    check: str
    result: str
    text: Text


def check_rows(log: RigLog, issues: Sequence[LogIssue], unchecked: dict[Check, str]) -> tuple[CheckRow, ...]:
    """The rows of the table.

    Args:
        log: The log.
        issues: What the checks reported.
        unchecked: Reasons why a check could not be made.
    """
    rows = []
    for check in CHECKS:
        own = [issue for issue in issues if issue.check == check]
        if own:
            worst = next(severity for severity in _WORST if any(issue.severity == severity for issue in own))
            rows.append(CheckRow(check, _RESULTS[worst], _joined([issue.text for issue in own])))
        elif check in unchecked:
            rows.append(CheckRow(check, "not checked", unchecked[check]))
        elif check == "rate":
            rows.append(CheckRow(check, "ok", _rates(log)))
        elif check in _FOUND_NOTHING:
            rows.append(CheckRow(check, "ok", _FOUND_NOTHING[check]))
    return tuple(rows)


def _joined(texts: Sequence[Text]) -> Text:
    parts: list[Text] = []
    for text in texts[:_MAX_TEXTS]:
        parts += ["; ", text]
    more = len(texts) - _MAX_TEXTS
    return sentence(*parts[1:], f"; and {more} more" if more > 0 else "")


def _rates(log: RigLog) -> str:
    """Samples a second of the surface channels."""
    by_rate: dict[str, list[str]] = {}
    for name, series in surface_series(log).items():
        rate = 1.0 / max(float(np.median(np.diff(series.time))), 1e-9)
        by_rate.setdefault(f"{rate:.3g}", []).append(name)
    return "; ".join(f"{', '.join(names)}: {rate} samples a second" for rate, names in by_rate.items())
