"""The two consoles that commands write to: results on stdout, progress and remarks on stderr.

Text is shown as it is: paths, names and messages come from files of others, and neither brackets in them are markup
nor may escapes in them reach the terminal. What is to be bold is given as `rich.text.Text`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import cache
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.progress import Progress, ProgressColumn
from rich.segment import Segment

from slider_drilling.printable import printable

# Columns of a table in a pipe or a file, where no terminal says how wide it is.
WIDTH = 120


class LiteralConsole(Console):
    """A rich console without markup, emoji codes or colours of its own choice, and with control characters escaped."""

    def __init__(self, **where: Any) -> None:
        super().__init__(**where, soft_wrap=True, markup=False, emoji=False, highlight=False)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """As rich does, every piece of text made printable: it is here that all of them pass."""
        for segment in super().render(renderable, options):
            text, style, control = segment
            yield segment if control else Segment(printable(text), style)


@cache
def stdout() -> Console:
    """Where results go."""
    return LiteralConsole(width=None if sys.stdout.isatty() else WIDTH)


@cache
def stderr() -> Console:
    """Where progress and remarks go, so that results can be piped on."""
    return LiteralConsole(stderr=True)


def progress_bar(*columns: ProgressColumn | str) -> Progress:
    """A bar on stderr that leaves nothing behind, and says nothing where stderr is no terminal."""
    return Progress(*columns, console=stderr(), transient=True, disable=not stderr().is_terminal)
