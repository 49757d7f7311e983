"""The folder of the compiled code: one for each version of the sources that it was compiled from.

Numba compares a cached function with the text of its own file only. Code compiled from another version of the package
would therefore be used after an import of it has changed, and could not even be read after a module has moved.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import re
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from slider_drilling.errors import InputError

MAX_AGE = 30 * 86400.0  # s since its last use, after which the folder of another version is removed
PACKAGE = Path(__file__).parents[1]
_IMPORT = re.compile(rb"^\s*(?:from|import) ([\w.]+)(?: import (\([^)]*\)|[^#\n]*))?", re.MULTILINE)


@functools.cache
def versioned_cache_folder(given: str, module: Path, libraries: tuple[str, ...]) -> str:
    """Make the folder for the code of these sources, and remove those of versions that are no longer used.

    Args:
        given: NUMBA_CACHE_DIR; empty if it is not set.
        module: File of the module whose functions are compiled.
        libraries: Names and versions of the libraries that compile it.

    Raises:
        InputError: The given folder cannot be written, or the user's folder is somebody else's.
    """
    base = Path(cache_folder(given))
    folder = base / f"sources-{source_hash(module, libraries)}"
    folder.mkdir(mode=0o700, exist_ok=True)
    os.utime(folder)
    for other in base.glob("sources-*"):
        with contextlib.suppress(FileNotFoundError):  # another process removes it too
            if time.time() - other.stat().st_mtime > MAX_AGE:
                shutil.rmtree(other)
    return str(folder)


def source_hash(module: Path, libraries: tuple[str, ...], package: Path = PACKAGE) -> str:
    """A hash of a module, of all that it imports from the package, directly or not, and of the libraries."""
    digest = hashlib.sha256("\n".join(libraries).encode())
    for path, text in sorted(_sources(module, package).items()):
        digest.update(f"{path.name}\0{len(text)}\0".encode() + text)
    return digest.hexdigest()[:16]


def _sources(module: Path, package: Path) -> dict[Path, bytes]:
    found: dict[Path, bytes] = {}
    pending = [module]
    while pending:
        path = pending.pop()
        if path not in found and path.is_file():
            found[path] = path.read_bytes()
            pending += _imported_files(found[path], package)
    return found


def _imported_files(text: bytes, package: Path) -> Iterator[Path]:
    """The package's files that a module imports."""
    for match in _IMPORT.finditer(text):
        module = match[1].decode()
        names = [f"{module}.{name}" for name in re.findall(r"\w+", (match[2] or b"").decode())]
        for name in (module, *names):
            if name.partition(".")[0] == package.name:
                base = package.parent.joinpath(*name.split("."))
                yield from (path for path in (base.with_suffix(".py"), base / "__init__.py") if path.is_file())


def cache_folder(given: str) -> str:
    """The folder that holds a folder for each version.

    Args:
        given: NUMBA_CACHE_DIR; empty if it is not set.

    Returns:
        The given folder; else one in the user's cache directory; or, if that cannot be written, one of this user's in
        the folder for temporary files. Never beside the source: an uninstalled package would leave it behind.

    Raises:
        InputError: The given folder cannot be written, or the user's folder is somebody else's.
    """
    if given:
        try:
            _check_writable(Path(given))
        except OSError as error:
            raise InputError(
                f"NUMBA_CACHE_DIR = {given}: cannot be written: {error.strerror}; name a folder of yours, or unset it"
            ) from None
        return given
    caches = os.environ.get("XDG_CACHE_HOME", "")
    own = (Path(caches) if os.path.isabs(caches) else Path(os.path.expanduser("~")) / ".cache") / "slider_drilling"
    try:
        _check_writable(own)
    except OSError:
        return _temporary_folder()
    return str(own)


def _check_writable(folder: Path) -> None:
    """Make the folder if it is missing. Raises OSError if it cannot be written."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder):
        pass


def _temporary_folder() -> str:
    """One folder per user, so that the next run finds it. Code from a folder that others can write to must not run."""
    own = Path(tempfile.gettempdir()) / f"slider_drilling_{os.getuid()}"
    with contextlib.suppress(FileExistsError):
        own.mkdir(mode=0o700)
    status = own.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid() or stat.S_IMODE(status.st_mode) & 0o077:
        raise InputError(f"{own}: not this user's own folder for compiled code; remove it, or set NUMBA_CACHE_DIR")
    return str(own)
