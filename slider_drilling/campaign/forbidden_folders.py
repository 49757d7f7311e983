"""Folders that a job cannot look into: enforced by the interpreter, for every way of opening a file from Python."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

_EVENTS = ("open", "os.listdir", "os.scandir", "os.rename", "os.link", "os.symlink", "os.chdir", "shutil.copyfile")


class _Closed:
    """What the hook looks at; an audit hook can never be taken out again, so this is emptied instead."""

    folders: tuple[str, ...] = ()
    allowed: frozenset[str] = frozenset()
    hooked = False


def _look(event: str, arguments: tuple[Any, ...]) -> None:
    if not _Closed.folders or event not in _EVENTS:
        return
    for argument in arguments[:2]:
        if isinstance(argument, (str, bytes, os.PathLike)):
            path = os.path.realpath(os.fsdecode(argument))
            if path in _Closed.allowed:
                continue
            for folder in _Closed.folders:
                if path == folder or path.startswith(folder + os.sep):
                    raise PermissionError(f"{path}: sealed for this job")


@contextmanager
def forbid_folders(folders: Iterable[str], allowed: Iterable[str]) -> Iterator[None]:
    """Within, opening or listing anything in these folders but the allowed files raises PermissionError."""
    if not _Closed.hooked:
        sys.addaudithook(_look)
        _Closed.hooked = True
    _Closed.allowed = frozenset(os.path.realpath(path) for path in allowed)
    _Closed.folders = tuple(os.path.realpath(folder) for folder in folders)
    try:
        yield
    finally:
        _Closed.folders = ()
