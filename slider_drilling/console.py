"""The two consoles that commands write to: results on stdout, progress and remarks on stderr."""

from __future__ import annotations

import sys
from functools import cache

from rich.console import Console

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
