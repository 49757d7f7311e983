"""The two consoles that commands write to: results on stdout, progress and remarks on stderr.

Text is shown as it is: paths, names and messages come from files of others, and neither brackets in them are markup
nor may escapes in them reach the terminal. What is to be bold is given as `rich.text.Text`.
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
    """A rich console without markup, emoji codes or colours of its own choice, and with control characters escaped."""

    def __init__(self, **where: Any) -> None:
        super().__init__(**where, soft_wrap=True, markup=False, emoji=False, highlight=False)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """As rich does, every piece of text made printable: it is here that all of them pass."""
        for segment in super().render(renderable, options):
            text, style, control = segment
            yield segment if control else Segment(printable(text), style)

    def print(self, *objects: Any, **how: Any) -> None:
        """As rich does, tables made to fit."""
        super().print(*(fit_table(one, self) if isinstance(one, Table) else one for one in objects), **how)


@cache
def stdout() -> Console:
    """Where results go; in a pipe or a file 80 columns wide, unless COLUMNS says otherwise."""
    return LiteralConsole()


@cache
def stderr() -> Console:
    """Where progress and remarks go, so that results can be piped on."""
    return LiteralConsole(stderr=True)


def progress_bar(*columns: ProgressColumn | str) -> Progress | ProgressLines:
    """A bar on stderr that leaves nothing behind; where stderr is no terminal, a line now and then."""
    if not stderr().is_terminal:
        return ProgressLines(stderr().print)
    return Progress(*columns, console=stderr(), transient=True)


@contextmanager
def progress_stages() -> Iterator[Callable[[str, float], None]]:
    """A ``progress(stage, share)`` that draws a bar on stderr, or prints lines where stderr is no terminal."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TextColumn("left"),
               TimeRemainingColumn())  # fmt: skip
    with progress_bar(*columns) as bar:
        task = bar.add_task("starting", total=1.0)
        yield lambda stage, share: bar.update(task, description=stage, completed=share)
