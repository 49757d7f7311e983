"""Text files read and files written as a whole, each failure a line that names the file."""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from slider_drilling.errors import InputError

_LONGEST_LINE = 1_000_000
_LONGEST_TEXT = 100_000_000  # bytes; what is read line by line may be longer
_NO_FILES = ("/dev/", "/proc/")  # even where a link there leads to a file, whoever opened it goes on writing to it


def read_text(path: str | os.PathLike[str], what: str, longest: int = _LONGEST_TEXT) -> str:
    """A UTF-8 file's text; ``what`` it should be, such as "rig file", goes into errors.

    longest: bytes that such a file has at most. Raises InputError.
    """
    with _readable(path, what):
        with open(path, "rb") as file:
            content = file.read(longest + 1)
        if len(content) > longest:
            raise InputError(f"{path}: longer than {longest / 1e6:g} MB, which no {what} is; check the path")
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")


def read_lines(path: str | os.PathLike[str], what: str) -> Iterator[str]:
    """A UTF-8 file's lines, each with its end, read as they are asked for; errors as of `read_text`."""
    with _readable(path, what), open(path, encoding="utf-8-sig") as file:
        number = 0
        while line := file.readline(_LONGEST_LINE):
            number += 1
            if len(line) == _LONGEST_LINE:
                raise InputError(f"{path}: line {number}: longer than a million characters; is this a {what}?")
            yield line


@contextmanager
def _readable(path: str | os.PathLike[str], what: str) -> Iterator[None]:
    """Failures to open, read and decode a file as errors that name it."""
    try:
        if stat.S_ISFIFO(os.stat(path).st_mode) and not os.path.abspath(path).startswith(_NO_FILES):
            raise InputError(f"{path}: is a pipe, which may never end, and no {what}; give a file")
        yield
    except FileNotFoundError:
        raise InputError(f"{path}: no such {what}; check the path") from None
    except OSError as error:
        raise InputError(f"{path}: cannot read this {what}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: cannot read this {what}: not UTF-8 text") from None
    except ValueError as error:
        raise InputError(f"{path}: cannot read this {what}: {error}") from None


def make_folder(path: Path) -> Path:
    """The folder itself, made with those above it where it is missing. Raises InputError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot make this folder: {_reason(error)}") from None
    return path


def check_outputs(outputs: Iterable[Path], inputs: Iterable[Path | None] = ()) -> None:
    """Make sure, before any work, that these files can be written and that none of them is read or written twice.

    A file counts as the same under whatever name or link; None among the inputs is one that was not given. Raises
    InputError naming the output and what to do.
    """
    taken = {identity: path for path in inputs if path is not None for identity in _identities(path)}
    for output in outputs:
        for identity in _identities(output):
            if identity in taken:
                other = taken[identity]
                raise InputError(f"{output}: is to be written, and is {other}, in use already; choose another name")
        taken |= dict.fromkeys(_identities(output), output)
        _check_writable(output)


def check_distinct(paths: Sequence[Path]) -> None:
    """Raises InputError where two of these files hold the same bytes: what is counted twice weighs twice."""
    seen: dict[bytes, Path] = {}
    for path in filter(os.path.isfile, paths):
        try:
            with open(path, "rb") as file:
                digest = hashlib.sha256()
                while block := file.read(1 << 20):
                    digest.update(block)
        except (OSError, ValueError):
            continue  # whoever reads it says why it cannot be read
        first = seen.setdefault(digest.digest(), path)
        if first is not path:
            raise InputError(f"{path}: the same as {first}; give each log once")


def create_part_file(path: Path) -> tuple[int, Path]:
    """An empty file beside ``path`` (beside what it links to), hidden, open for writing: its descriptor and its name.

    Raises OSError, and InputError for what is neither absent nor a file.
    """
    if _is_special(path):
        raise InputError(f"{path}: cannot write this file: it is a device or a pipe; name a file")
    target = Path(os.path.realpath(path))
    if target.is_file() and not os.access(target, os.W_OK):
        raise PermissionError(13, "it is read-only", str(path))
    descriptor, part = tempfile.mkstemp(".part", f".{target.name[:60]}.", target.parent)
    return descriptor, Path(part)


def commit_part_file(part: Path, path: Path) -> None:
    """Give a finished file its name, in place of whatever had it; a link stays one. Raises OSError."""
    # mkstemp makes files for their owner alone; these are to be read as any other file is.
    mask = os.umask(0)
    os.umask(mask)
    part.chmod(0o666 & ~mask)
    part.replace(os.path.realpath(path))


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file as a whole or not at all; into a device or a pipe, as it is. Raises InputError."""
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


def _identities(path: Path) -> list[object]:
    """What tells a file from every other: where it is, and where the disk has it if it is there."""
    try:
        found = os.stat(path)
    except OSError:
        return [os.path.realpath(path)]
    except ValueError:
        return []  # no file can have such a name
    if not stat.S_ISREG(found.st_mode):
        return []
    return [os.path.realpath(path), (found.st_dev, found.st_ino)]


def _is_special(path: Path) -> bool:
    """Whether there is something that is no file, or a file that others hold open by this name."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return False
    return not stat.S_ISDIR(mode) and (not stat.S_ISREG(mode) or os.path.abspath(path).startswith(_NO_FILES))


def _check_writable(path: Path) -> None:
    """Write nothing where the file will be, to see that something can be. Raises InputError."""
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
