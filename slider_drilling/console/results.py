"""Keeps standard output for a command's JSON: whatever else prints, plug-in or C library, goes to standard error."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import TextIO


class _Reserved:
    """Where results go while standard output is reserved; None while it is not."""

    stream: TextIO | None = None
    until_exit = False


def reserve_until_exit() -> None:
    """Make `reserve_stdout` last until the process ends: plug-ins print while Python exits, too."""
    _Reserved.until_exit = True


def reserve_stdout() -> Callable[[], None]:
    """Send everything but results to standard error. Returns a function that ends this."""
    if _Reserved.stream is not None:
        return lambda: None
    real, copy = sys.stdout, -1
    real.flush()
    if _descriptor(real) == 1:
        copy = os.dup(1)
        os.dup2(2, 1)
        _Reserved.stream = os.fdopen(copy, "w", encoding=real.encoding, errors="backslashreplace", closefd=False)
    else:
        _Reserved.stream = real
    sys.stdout = sys.stderr

    def restore() -> None:
        if _Reserved.until_exit:
            return
        sys.stdout, _Reserved.stream = real, None
        if copy >= 0:
            os.dup2(copy, 1)
            os.close(copy)

    return restore


def results_stream() -> TextIO:
    """Where results are written."""
    return _Reserved.stream or sys.stdout


def _descriptor(stream: TextIO) -> int:
    try:
        return stream.fileno()
    except (OSError, AttributeError, ValueError):
        return -1  # as of a test's stream in memory
