"""One line of a node's health, as `diagnostic_msgs/DiagnosticStatus` has it."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Level(enum.IntEnum):
    """Severity, numbered as in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True)
class Status:
    """One line of health. name: what it is about; message: the reason; values: (key, value) pairs."""

    level: Level
    name: str
    message: str
    values: tuple[tuple[str, str], ...] = ()
