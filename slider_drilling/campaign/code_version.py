"""Which code a result was made by."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from slider_drilling import __version__

# Folders of the package that no job's result can depend on.
_APART = ("bench", "commands", "nodes")


@cache
def code_version() -> str:
    """The package's version and a hash of its sources, such as ``0.1.0+5be1c0ffee12``: an edit makes another one."""
    package = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        place = path.relative_to(package)
        if place.parts[0] not in _APART:
            digest.update(place.as_posix().encode())
            digest.update(path.read_bytes())
    return f"{__version__}+{digest.hexdigest()[:12]}"
