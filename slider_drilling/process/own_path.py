"""Starts Python processes that import from where this process does, and never from the working directory first."""

from __future__ import annotations

import os
import sys
from pathlib import Path

_PACKAGE = str(Path(__file__).resolve().parents[1])
# The process takes the import path, and this very package wherever it lies on that path, before it imports anything.
_START = """
import sys
package_folder, module, function, count, *rest = sys.argv[1:]
sys.argv[1:], sys.path[:] = rest[: int(count)], rest[int(count) :]
from importlib.util import module_from_spec, spec_from_file_location
spec = spec_from_file_location(
    "slider_drilling", package_folder + "/__init__.py", submodule_search_locations=[package_folder])
package = sys.modules["slider_drilling"] = module_from_spec(spec)
spec.loader.exec_module(package)
from importlib import import_module
sys.exit(getattr(import_module(module), function)())
"""


def worker_command(module: str, function: str, *arguments: str) -> list[str]:
    """The command of a process that calls a function of this package.

    Args:
        module: Its module.
        function: Its name; it takes no argument, and what it returns is the exit code.
        arguments: What it finds in `sys.argv`.
    """
    return [sys.executable, "-c", _START, _PACKAGE, module, function, str(len(arguments)), *arguments, *_import_path()]


def _import_path() -> list[str]:
    """All folders that this process imports from, the working directory last.

    A user's modules may be there; before the standard library, a file `queue.py` of it would be executed.
    """
    here = os.getcwd()
    others = [entry for entry in sys.path if entry and os.path.abspath(entry) != here]
    return [*others, here]
