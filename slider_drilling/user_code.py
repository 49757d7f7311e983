"""Code that a user brings along: found by its name, and its errors told in one line with the user's file and line."""

from __future__ import annotations

import importlib
import sys
import sysconfig
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from slider_drilling.errors import InputError

_OURS = str(Path(__file__).parent)
_PYTHONS = tuple(filter(None, (sysconfig.get_path("stdlib"), sysconfig.get_path("platlib"), "<frozen")))
Result = TypeVar("Result")
_LONGEST = 300  # characters of an error's own words


def import_reference(reference: str, where: str, example: str) -> object:
    """What ``module:Name`` is; modules in the working directory are found too.

    where: begins the error, such as ``--effect clay:Clay``. Raises InputError for what is no such reference, or cannot
    be imported for whatever reason.
    """
    module_name, _, name = reference.partition(":")
    if not (name.isidentifier() and all(part.isidentifier() for part in module_name.split("."))):
        raise InputError(f"{where}: must be module:Class, such as {example}")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        return getattr(importlib.import_module(module_name), name)
    except (Exception, SystemExit) as error:
        raise InputError(f"{where}: cannot be imported: {one_line_error(error)}") from error


def call_user_code(function: Callable[[], Result], what: str) -> Result:
    """What a call of the user's code returns; ``what`` was called. Raises InputError for whatever it raises."""
    try:
        return function()
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise InputError(f"{what} raised {one_line_error(error)}") from error


def one_line_error(error: BaseException) -> str:
    """The error in one line: its kind, its words, and the innermost line of the user's own code."""
    try:
        words = " ".join(str(error).split())[:_LONGEST]
    except Exception as worse:
        words = f"(its text cannot be made: {type(worse).__name__})"
    kind = f"{type(error).__name__}: {words}" if words else type(error).__name__
    if isinstance(error, SyntaxError) and error.filename:
        return f"{type(error).__name__}: {error.msg} at {Path(error.filename).name}:{error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.startswith((_OURS, *_PYTHONS))]
    return f"{kind} at {Path(own[-1].filename).name}:{own[-1].lineno}" if own else kind
