"""When something changed in a later log that begins before it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Onset:
    """When something changed in a later log that begins before it. What lies between the two times is not compared.

    Attributes:
        unchanged_until: s from the log's start, up to which the rig is as the baseline has it.
        changed_from: s from the log's start, from which on it has changed.
    """

    unchanged_until: float
    changed_from: float

    @property
    def middle(self) -> float:
        """s from the log's start, at which it begins in a simulation."""
        return 0.5 * (self.unchanged_until + self.changed_from)
