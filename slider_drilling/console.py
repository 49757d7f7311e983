"""The two consoles that commands write to: results on stdout, progress and remarks on stderr."""

from __future__ import annotations

import sys
from functools import cache

from rich.console import Console
from rich.progress import Progress, ProgressColumn

# Columns of a table in a pipe or a file, where no terminal says how wide it is.
WIDTH = 120


@cache
def stdout() -> Console:
    """Where results go."""
    return Console(soft_wrap=True, width=None if sys.stdout.isatty() else WIDTH)


@cache
def stderr() -> Console:
    """Where progress and remarks go, so that results can be piped on."""
    return Console(stderr=True, soft_wrap=True)


def progress_bar(*columns: ProgressColumn | str) -> Progress:
    """A bar on stderr that leaves nothing behind, and says nothing where stderr is no terminal."""
    return Progress(*columns, console=stderr(), transient=True, disable=not stderr().is_terminal)
