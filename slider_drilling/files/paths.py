"""Paths as a program gives them."""

from __future__ import annotations

import os
from pathlib import Path

from slider_drilling.errors import InputError


def as_path(given: object, what: str) -> Path:
    """The path that a program gives.

    Args:
        given: A text or a path.
        what: What is at the path, such as "log", for the message.

    Raises:
        InputError: It is something else, or no system takes such a name.
    """
    name = os.fspath(given) if isinstance(given, (str, os.PathLike)) else None
    if not isinstance(name, str):
        raise InputError(f"{what}: {type(given).__name__} is no path; give a text or a pathlib.Path")
    if "\0" in name:
        raise InputError(f"{what}: {name!r}: no file name holds a null character")
    return Path(name)
