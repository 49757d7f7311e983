"""What a check reports about a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from slider_drilling.units import Text

Severity = Literal["unusable", "uninformative", "note"]
Check = Literal[
    "rate", "gaps", "clock", "nulls", "samples", "signs", "integrated", "units and levels", "block weight", "motion"
]


@dataclass(frozen=True)
class LogIssue:
    """One problem of a log.

    Attributes:
        severity: ``unusable``: the log, or the log with this rig file, must be corrected first. ``uninformative``: the
            log is valid, but no fit could conclude anything from it. ``note``: the diagnosis goes on.
        channel: Name in the log, such as ``standpipe_pressure``, or ``clock``.
        text: One sentence without its full stop.
        check: The row of the table of checks that it belongs to.
    """

    severity: Severity
    channel: str
    text: Text
    check: Check = "samples"
