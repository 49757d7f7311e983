"""Progress as occasional lines, for a log file or a pipe, in which rich would draw nothing until the end."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from types import TracebackType

from rich.progress import TaskID

FIRST_LINE_AFTER = 5.0    # s of work before the first line: what is done by then needs none
LINE_INTERVAL = 15.0   # s between lines


@dataclass
class _Task:
    description: str
    total: float | None
    completed: float = 0.0


@dataclass
class ProgressLines:
    """A replacement for `rich.progress.Progress`.

    Attributes:
        show: Prints a line.
        clock: Time, s.
    """

    show: Callable[[str], None]
    clock: Callable[[], float] = time.monotonic
    _tasks: list[_Task] = field(default_factory=list)
    _due: float = 0.0

    def __enter__(self) -> ProgressLines:
        self._due = self.clock() + FIRST_LINE_AFTER
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None

    def add_task(
        self, description: str, *, total: float | None = 100.0, completed: float = 0.0, **more: object
    ) -> TaskID:
        """Add a task and return its number; `total` is None if the amount of work is not known."""
        self._tasks.append(_Task(description, total, completed))
        return TaskID(len(self._tasks) - 1)

    def advance(self, task: TaskID, advance: float = 1.0) -> None:
        """Add to the work dstate."""
        self.update(task, advance=advance)

    def update(
        self,
        task: TaskID,
        *,
        description: str | None = None,
        completed: float | None = None,
        advance: float = 0.0,
        total: float | None = None,
        **more: object,
    ) -> None:
        """Set how far a task is; print a line if one is due."""
        state = self._tasks[task]
        state.description = state.description if description is None else description
        state.total = state.total if total is None else total
        state.completed = (state.completed if completed is None else completed) + advance
        now = self.clock()
        if now >= self._due:
            self._due = now + LINE_INTERVAL
            self.show(_line(state))


def _line(task: _Task) -> str:
    if not task.total:
        return task.description
    share = f"{100.0 * min(task.completed / task.total, 1.0):.0f} %"
    return f"{task.description}: {share}" + (f", {task.completed:g} of {task.total:g}" if task.total > 1.0 else "")
