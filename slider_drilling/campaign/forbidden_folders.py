"""Folders that a job cannot read. The interpreter's audit hook enforces this for Python's ways of opening a file."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

_EVENTS = ("open", "os.listdir", "os.scandir", "os.rename", "os.link", "os.symlink", "os.chdir", "shutil.copyfile")


class _Forbidden:
    """What the audit hook checks. A hook cannot be removed, so this is emptied instead."""

    folders: tuple[str, ...] = ()
    allowed_files: frozenset[str] = frozenset()
    hook_installed = False


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    if not _Forbidden.folders or event not in _EVENTS:
        return
    # The first two arguments are the paths of every event above.
    for argument in arguments[:2]:
        if isinstance(argument, (str, bytes, os.PathLike)):
            path = os.path.realpath(os.fsdecode(argument))
            if path in _Forbidden.allowed_files:
                continue
            for folder in _Forbidden.folders:
                if path == folder or path.startswith(folder + os.sep):
                    raise PermissionError(f"{path}: sealed for this job")


@contextmanager
def forbid_folders(folders: Iterable[str], allowed_files: Iterable[str]) -> Iterator[None]:
    """Makes this process unable to open or list anything in the folders, apart from the allowed files.

    Raises:
        PermissionError: Inside, at each attempt.
    """
    if not _Forbidden.hook_installed:
        sys.addaudithook(_audit)
        _Forbidden.hook_installed = True
    _Forbidden.allowed_files = frozenset(os.path.realpath(path) for path in allowed_files)
    _Forbidden.folders = tuple(os.path.realpath(folder) for folder in folders)
    try:
        yield
    finally:
        _Forbidden.folders = ()
