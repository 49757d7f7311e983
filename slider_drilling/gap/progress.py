"""A progress bar with the time left, for anything that reports a stage and the share done."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

# Called with the stage in words and the share done, 0 to 1.
Progress = Callable[[str, float], None]


@contextmanager
def progress_bar(console: Console) -> Iterator[Progress]:
    """Yield a ``progress(stage, share)`` that draws a bar; it is silent on anything but a terminal."""
    from rich import progress as bars

    columns = (bars.TextColumn("{task.description}"), bars.BarColumn(), bars.TimeElapsedColumn(),
               bars.TextColumn("left"), bars.TimeRemainingColumn())  # fmt: skip
    with bars.Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task("starting", total=1.0)

        def progress(stage: str, share: float) -> None:
            bar.update(task, description=stage, completed=share)

        yield progress
