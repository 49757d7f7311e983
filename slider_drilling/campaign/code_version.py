"""The version of the code that made a result."""

from __future__ import annotations

import hashlib
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path

from slider_drilling import __version__

# Folders of the package that no job's result depends on.
_IRRELEVANT_FOLDERS = ("benchmarks", "commands", "nodes", "live", "opcua")
# Packages whose arithmetic results depend on.
LIBRARIES = ("numba", "numpy", "scipy")


def library_versions() -> str:
    """Returns the versions of Python and of LIBRARIES in one line."""
    libraries = [f"{name} {version(name)}" for name in LIBRARIES]
    return f"python {sys.version_info.major}.{sys.version_info.minor}, {', '.join(libraries)}"


@cache
def code_version() -> str:
    """Returns the package's version and a hash of its sources and its libraries, such as ``0.1.0+5be1c0ffee12``."""
    package = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256(library_versions().encode())
    for path in sorted(package.rglob("*.py")):
        relative = path.relative_to(package)
        if relative.parts[0] not in _IRRELEVANT_FOLDERS:
            digest.update(relative.as_posix().encode())
            digest.update(path.read_bytes())
    return f"{__version__}+{digest.hexdigest()[:12]}"
