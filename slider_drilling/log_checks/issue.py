"""One thing noticed of a log before any fit, and how much hangs on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

# refuse: the log, or the log with this rig file, cannot be used before somebody mends it.
# stop: nothing is wrong, but no fit could say anything. note: the diagnosis goes on, the reader should know.
Severity = Literal["unusable", "uninformative", "note"]


@dataclass(frozen=True)
class LogIssue:
    """channel: of the log (`standpipe_pressure`, ...), or `clock`; text: one sentence without its full stop."""

    severity: Severity
    channel: str
    text: str
