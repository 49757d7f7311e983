"""Check for numbers that mean "no value" (-999.25, -9999, ...) in a recorded log; mask them."""

from __future__ import annotations

from slider_drilling.log import RigLog
from slider_drilling.log.find_nulls import find_nulls, without_nulls
from slider_drilling.log_checks.issue import LogIssue


def mask_undeclared_nulls(log: RigLog) -> tuple[RigLog, list[LogIssue]]:
    """The log with nulls as NaN, whatever unit they were converted from; a note for each quantity that had some."""
    nulls = find_nulls(log)
    issues = [LogIssue("note", null.key, f"{null}: taken as no value", "nulls") for null in nulls]
    return without_nulls(log, nulls), issues
