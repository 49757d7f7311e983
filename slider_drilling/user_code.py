"""Imports and calls a user's code; its errors become one line that names the user's file and line."""

from __future__ import annotations

import importlib
import sys
import sysconfig
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from slider_drilling.errors import InputError

_PACKAGE_FOLDER = str(Path(__file__).parent)
_PYTHON_FOLDERS = tuple(filter(None, (sysconfig.get_path("stdlib"), sysconfig.get_path("platlib"), "<frozen")))
Result = TypeVar("Result")
_MAX_MESSAGE_LENGTH = 300  # characters of the error's own message


def import_reference(reference: str, where: str, example: str) -> object:
    """The object that ``module:Name`` refers to; modules in the working directory are found too.

    Args:
        reference: ``module:Name``.
        where: Starts the error message, such as ``--effect clay:Clay``.
        example: A valid reference, for the error message.

    Raises:
        InputError: The reference is malformed, or the import fails for whatever reason.
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
    """Call a user's code and return its result.

    Args:
        function: Calls the code.
        what: Names the call in the error message.

    Raises:
        InputError: The code raised something.
    """
    try:
        return function()
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise InputError(f"{what} raised {one_line_error(error)}") from error


def one_line_error(error: BaseException) -> str:
    """An error as one line: its type, its message, and the innermost line of the user's own code."""
    try:
        message = " ".join(str(error).split())[:_MAX_MESSAGE_LENGTH]
    except Exception as worse:
        message = f"(its text cannot be made: {type(worse).__name__})"
    kind = f"{type(error).__name__}: {message}" if message else type(error).__name__
    if isinstance(error, SyntaxError) and error.filename:
        return f"{type(error).__name__}: {error.msg} at {Path(error.filename).name}:{error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.startswith((_PACKAGE_FOLDER, *_PYTHON_FOLDERS))]
    return f"{kind} at {Path(own[-1].filename).name}:{own[-1].lineno}" if own else kind
