"""The two consoles that commands write to: results on stdout, progress and remarks on stderr.

They print strings literally, since paths, names and messages may come from files of others: brackets are not markup,
and escape sequences do not reach the terminal. Styled text is passed as `rich.text.Text`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.progress import BarColumn, Progress, ProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.segment import Segment
from rich.table import Table

from slider_drilling.console.printable import printable
from slider_drilling.console.progress_lines import ProgressLines
from slider_drilling.console.table_fit import fit_table


class LiteralConsole(Console):
    """A rich console without markup, emoji codes and highlighting, with control characters escaped."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options, soft_wrap=True, markup=False, emoji=False, highlight=False)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Render with every text made printable."""
        for segment in super().render(renderable, options):
            text, style, control = segment
            yield segment if control else Segment(printable(text), style)

    def print(self, *objects: Any, **options: Any) -> None:
        """Print with tables made to fit."""
        super().print(*(fit_table(item, self) if isinstance(item, Table) else item for item in objects), **options)


@cache
def stdout() -> Console:
    """The console for results; in a pipe or a file 80 columns wide, unless COLUMNS is set."""
    return LiteralConsole()


@cache
def stderr() -> Console:
    """The console for progress and remarks, so that results can be piped."""
    return LiteralConsole(stderr=True)


def progress_bar(*columns: ProgressColumn | str) -> Progress | ProgressLines:
    """A progress bar on stderr that disappears at the end; if stderr is not a terminal, occasional lines."""
    if not stderr().is_terminal:
        return ProgressLines(stderr().print)
    return Progress(*columns, console=stderr(), transient=True)


@contextmanager
def progress_stages() -> Iterator[Callable[[str, float], None]]:
    """Yields ``progress(stage, share)``, which draws a bar on stderr, or prints lines if stderr is not a terminal."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TextColumn("left"),
               TimeRemainingColumn())  # fmt: skip
    with progress_bar(*columns) as bar:
        task = bar.add_task("starting", total=1.0)
        yield lambda stage, share: bar.update(task, description=stage, completed=share)
