"""Reads text files and writes files atomically; every failure is an InputError that names the file."""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.paths import as_path

_MAX_LINE_LENGTH = 1_000_000
_MAX_TEXT_BYTES = 100_000_000  # of a file that is read as a whole
_made: list[Path] = []  # folders, in this process
_SPECIAL_FOLDERS = ("/dev/", "/proc/")  # a link there may lead to a file that another process writes


def read_text(path: str | os.PathLike[str], what: str, max_bytes: int = _MAX_TEXT_BYTES) -> str:
    """The text of a UTF-8 file.

    Args:
        path: Of the file.
        what: What it should be, such as "rig file", for error messages.
        max_bytes: Length of the longest plausible file.

    Raises:
        InputError: The file cannot be read, is not UTF-8 or is too long.
    """
    as_path(path, what)
    with _readable(path, what):
        with open(path, "rb") as file:
            content = file.read(max_bytes + 1)
        if len(content) > max_bytes:
            raise InputError(f"{path}: longer than {max_bytes / 1e6:g} MB, which no {what} is; check the path")
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")


def read_lines(path: str | os.PathLike[str], what: str, encoding: str = "utf-8-sig") -> Iterator[str]:
    """The lines of a text file, with their ends, read one at a time; raises as `read_text` does."""
    with _readable(path, what, encoding), open(path, encoding=encoding) as file:
        number = 0
        while line := file.readline(_MAX_LINE_LENGTH):
            number += 1
            if len(line) == _MAX_LINE_LENGTH:
                raise InputError(f"{path}: line {number}: longer than a million characters; is this a {what}?")
            yield line


@contextmanager
def _readable(path: str | os.PathLike[str], what: str, encoding: str = "utf-8-sig") -> Iterator[None]:
    """Turn failures to open, read and decode a file into InputErrors that name it."""
    try:
        if stat.S_ISFIFO(os.stat(path).st_mode) and not os.path.abspath(path).startswith(_SPECIAL_FOLDERS):
            raise InputError(f"{path}: is a pipe, which may never end, and no {what}; give a file")
        yield
    except FileNotFoundError:
        raise InputError(f"{path}: no such {what}; check the path") from None
    except OSError as error:
        raise InputError(f"{path}: cannot read this {what}: {error.strerror}") from None
    except UnicodeDecodeError:
        name = encoding.upper().removesuffix("-SIG")
        raise InputError(f"{path}: cannot read this {what}: not {name} text") from None
    except ValueError as error:
        raise InputError(f"{path}: cannot read this {what}: {error}") from None


def make_folder(path: Path) -> Path:
    """Make a folder and its parents if they are missing, and return it. Raises InputError."""
    try:
        missing = [each for each in (path, *path.parents) if not each.exists()]
        path.mkdir(parents=True, exist_ok=True)
        _made.extend(missing)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot make this folder: {_reason(error)}") from None
    return path


def remove_empty_folders() -> None:
    """Remove folders that `make_folder` made and nothing was written to, as when input is refused afterwards."""
    for folder in sorted(_made, key=lambda each: len(each.parts), reverse=True):
        with suppress(OSError):  # it holds something, or is gone
            folder.rmdir()
    _made.clear()


def make_subfolder(parent: Path, name: str) -> Path:
    """Make a folder of the program's own in an output folder, and return it.

    Raises:
        InputError: It cannot be made, or a link that somebody put there leads elsewhere.
    """
    path = make_folder(parent) / name
    if path.is_symlink():
        raise _link_error(path)
    return make_folder(path)


def check_outputs(outputs: Iterable[Path], inputs: Iterable[Path | None] = ()) -> None:
    """Check before any work that files can be written, and that no output is also an input or another output.

    Args:
        outputs: Files to be written.
        inputs: Files to be read; None stands for one that was not given.

    Raises:
        InputError: An output cannot be written, or is the same file as another, under whatever name or link.
    """
    taken = {identity: path for path in inputs if path is not None for identity in _identities(path)}
    for output in outputs:
        for identity in _identities(output):
            if identity in taken:
                other = taken[identity]
                raise InputError(f"{output}: the same file as {other}, in use already; choose another name")
        taken |= dict.fromkeys(_identities(output), output)
        _check_writable(output)


def check_distinct(paths: Sequence[Path]) -> None:
    """Raises InputError if two of the files hold the same bytes: a log given twice would count twice."""
    seen: dict[bytes, Path] = {}
    for path in filter(os.path.isfile, paths):
        try:
            with open(path, "rb") as file:
                digest = hashlib.sha256()
                while block := file.read(1 << 20):
                    digest.update(block)
        except (OSError, ValueError):
            continue  # reading it will report why it cannot be read
        first = seen.setdefault(digest.digest(), path)
        if first is not path:
            raise InputError(f"{path}: the same as {first}; give each log once")


def create_part_file(path: Path) -> tuple[int, Path]:
    """Open a hidden part file for writing, beside the file that it will replace.

    Returns:
        Descriptor and path of the part file.

    Raises:
        OSError: The file cannot be written.
        InputError: The path is a device, a pipe or a link.
    """
    if path.is_symlink() and not _is_special(path):
        raise _link_error(path)
    if _is_special(path):
        raise InputError(f"{path}: cannot write this file: it is a device or a pipe; name a file")
    if path.is_file() and not os.access(path, os.W_OK):
        raise PermissionError(13, "it is read-only", str(path))
    descriptor, part = tempfile.mkstemp(".part", f".{path.name[:60]}.", path.parent)
    return descriptor, Path(part)


def commit_part_file(part: Path, path: Path) -> None:
    """Rename a finished part file to its final name; a link there is replaced, not followed. Raises OSError."""
    # mkstemp makes files that only their owner can read; give this one the usual permissions.
    mask = os.umask(0)
    os.umask(mask)
    part.chmod(0o666 & ~mask)
    part.replace(path)


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file as a whole or not at all; write directly to a device or a pipe. Raises InputError."""
    try:
        if _is_special(path):
            path.write_bytes(content)
            return
        descriptor, part = create_part_file(path)
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(content)
            commit_part_file(part, path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot write this file: {_reason(error)}") from None


def delete_old(path: Path) -> None:
    """Delete a file of an earlier run that this run does not write, if it is there. Raises InputError."""
    try:
        path.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot delete this old file: {_reason(error)}") from None


def _link_error(path: Path) -> InputError:
    return InputError(f"{path}: is a link to {os.readlink(path)}; name that file itself, or delete the link")


def _identities(path: Path) -> list[object]:
    """What identifies a file: its real path and, if it exists, its device and inode."""
    try:
        status = os.stat(path)
    except OSError:
        return [os.path.realpath(path)]
    except ValueError:
        return []  # not a valid file name
    if not stat.S_ISREG(status.st_mode):
        return []
    return [os.path.realpath(path), (status.st_dev, status.st_ino)]


def _is_special(path: Path) -> bool:
    """Whether the path is a device, a pipe or in a special folder; a link elsewhere is not, whatever it leads to."""
    try:
        if os.path.islink(path) and not os.path.abspath(path).startswith(_SPECIAL_FOLDERS):
            return False
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return False
    return not stat.S_ISDIR(mode) and (not stat.S_ISREG(mode) or os.path.abspath(path).startswith(_SPECIAL_FOLDERS))


def _check_writable(path: Path) -> None:
    """Check that a file can be written by making and removing a part file. Raises InputError."""
    try:
        if path.is_dir():
            raise IsADirectoryError(21, "Is a directory", str(path))
        if _is_special(path):
            if not os.access(path, os.W_OK):
                raise PermissionError(13, "Permission denied", str(path))
            return
        descriptor, part = create_part_file(path)
        os.close(descriptor)
        part.unlink()
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot write this file: {_reason(error)}") from None


def _reason(error: OSError | ValueError) -> str:
    return getattr(error, "strerror", None) or str(error)
