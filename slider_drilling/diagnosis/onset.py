"""When something changed in a later log that begins before it."""

from __future__ import annotations

from dataclasses import dataclass

LEAD_S = 120.0
"""Time before a change from which on later samples are simulated, s."""
_LONGEST_UNKNOWN_S = 240.0  # between samples from before a change and from after it, which are simulated together


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

    @property
    def known(self) -> bool:
        """Whether it is known well enough for a simulation through it."""
        return self.changed_from - self.unchanged_until <= _LONGEST_UNKNOWN_S

    @property
    def simulated_from(self) -> float:
        """s from the log's start, from which on it is simulated: the string comes to the change in the state it had.

        Where nobody knows for long whether it has changed yet, that is when it has.
        """
        return max(self.unchanged_until - LEAD_S, 0.0) if self.known else self.changed_from

    def relative_to(self, begin: float) -> Onset:
        """The same in a log that begins at a time of this one, s."""
        return Onset(self.unchanged_until - begin, self.changed_from - begin)


@dataclass(frozen=True)
class Since:
    """When a change began, as somebody says.

    Attributes:
        time: s of the log that the user gave; None where that is unknown, or two whole logs are compared.
        interval: 95 % interval, None if unknown.
        found: Whether change detection found it.
        log_start: s of that log, at which the later log begins.
        channel: In which it was seen, None if unknown.
    """

    time: float | None
    interval: tuple[float, float] | None = None
    found: bool = False
    log_start: float = 0.0
    channel: str | None = None
