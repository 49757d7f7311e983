"""How far a programme is, and how its steps ended."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class ProgrammeState(enum.Enum):
    """What a programme does now."""

    TARING = "taring"
    RUNNING = "running"
    DONE = "done"
    ABORTED = "aborted"

    @property
    def ended(self) -> bool:
        """Whether no step will follow."""
        return self in (ProgrammeState.DONE, ProgrammeState.ABORTED)


@dataclass(frozen=True)
class StepRecord:
    """One step that was started.

    Attributes:
        number: From 1.
        key: In the file, such as ``rock``.
        begin: s of the controller's clock.
        end: s; None while it goes on.
        outcome: "done", "running", or why it was aborted.
        tool_face_set: s of the clock at which a slide had its toolface; None for other steps, or if it never had.
        tool_face_left: s at which it began to lift the bit after that; None before.
    """

    number: int
    key: str
    begin: float
    end: float | None = None
    outcome: str = "running"
    tool_face_set: float | None = None
    tool_face_left: float | None = None


@dataclass(frozen=True)
class ProgrammeProgress:
    """How far a programme is.

    Attributes:
        state: What it does now.
        step: Number of the present step, from 1; 0 before the first.
        steps: Number of all.
        action: Key of the present step, or "".
        stage: Of a slide: orient, drill or leave; else "".
        time_left: s until the end, by the nominal times of the steps.
        reason: Why it was aborted, or "".
        records: Of the steps that were begun.
    """

    state: ProgrammeState
    step: int
    steps: int
    action: str
    stage: str
    time_left: float
    reason: str
    records: tuple[StepRecord, ...]

    def __str__(self) -> str:
        if self.state is ProgrammeState.ABORTED:
            where = f"in step {self.step} of {self.steps} ({self.action})" if self.step else "before the first step"
            return f"aborted {where}: {self.reason}"
        if self.state is ProgrammeState.DONE:
            return "the one step is done" if self.steps == 1 else f"all {self.steps} steps done"
        if self.state is ProgrammeState.TARING:
            return f"taring hook load and pressure before step 1 of {self.steps}"
        stage = f", {self.stage}" if self.stage else ""
        return f"step {self.step} of {self.steps}: {self.action}{stage}; {self.time_left:.0f} s left"
