"""One status of a node, as in `diagnostic_msgs/DiagnosticStatus`."""

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
    """One status of a component.

    Attributes:
        level: Severity, a `Level`.
        name: The component.
        message: The reason for the level.
        values: (key, value) pairs.
        hardware_id: The hardware that the component belongs to.
    """

    level: Level
    name: str
    message: str
    values: tuple[tuple[str, str], ...] = ()
    hardware_id: str = ""
