"""Imports and calls a user's code; its errors become one line that names the user's file and line."""

from __future__ import annotations

import importlib
import importlib.util
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
    """The object that ``module:Name`` refers to; modules in the working directory are found too, after all others.

    Args:
        reference: ``module:Name``.
        where: Starts the error message, such as ``--effect clay:Clay``.
        example: A valid reference, for the error message.

    Raises:
        InputError: The reference is malformed, the working directory's module is hidden by another of its name, or the
            import fails for whatever reason.
    """
    module_name, _, name = reference.partition(":")
    if not (name.isidentifier() and all(part.isidentifier() for part in module_name.split("."))):
        raise InputError(f"{where}: must be module:Class, such as {example}")
    add_working_directory()
    _check_not_hidden(module_name.partition(".")[0], where)
    try:
        return getattr(importlib.import_module(module_name), name)
    except (Exception, SystemExit) as error:
        raise InputError(f"{where}: cannot be imported: {one_line_error(error)}") from error


def add_working_directory() -> None:
    """Let modules of the working directory be imported, after all others.

    In front, a file `queue.py` there would be executed by whatever imports the standard library's `queue`.
    """
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)


def _check_not_hidden(name: str, where: str) -> None:
    """Raises InputError if a module of the working directory has the name of another one, which is imported instead."""
    own = [path for path in (Path(f"{name}.py"), Path(name, "__init__.py")) if path.is_file()]
    if not own:
        return
    try:
        found = importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return  # the import reports why
    origin = found.origin if found is not None else None
    if origin is None or not Path(origin).is_file() or not any(Path(origin).samefile(path) for path in own):
        raise InputError(f"{where}: {own[0]} is hidden by the module {name} of {origin or 'Python'}; rename the file")


def source_files(module_name: str) -> list[Path]:
    """The files that make up a user's module, also those that it would import only while it runs.

    Args:
        module_name: Of an imported module.

    Returns:
        Every source file of its package, or in the folder of a module without a package; and every module beside it
        that has been imported.
    """
    top = sys.modules[module_name.partition(".")[0]]
    folders = [Path(folder).resolve() for folder in getattr(top, "__path__", ())]
    files = {file for folder in folders for file in folder.rglob("*.py")}
    beside = [folder.parent for folder in folders]
    if not folders and top.__file__ is not None:
        file = Path(top.__file__).resolve()
        beside = [file.parent]
        # What else is in site-packages belongs to others.
        files = {file} if _is_installed(file) else {file, *file.parent.glob("*.py")}
    for module in list(sys.modules.values()):
        loaded = getattr(module, "__file__", None)
        if isinstance(loaded, str) and not loaded.startswith((_PACKAGE_FOLDER, *_PYTHON_FOLDERS)):
            path = Path(loaded).resolve()
            if any(folder in path.parents for folder in beside) and not _is_installed(path):
                files.add(path)
    return sorted(file for file in files if file.is_file())


def _is_installed(file: Path) -> bool:
    return "site-packages" in file.parts or "dist-packages" in file.parts


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
