"""Text files read and files written as a whole, each failure a line that names the file."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from slider_drilling.errors import InputError


def read_text(path: str | os.PathLike[str], what: str, longest: int | None = None) -> str:
    """A UTF-8 file's text; ``what`` it should be, such as "rig file", goes into errors.

    longest: bytes that such a file has at most. Raises InputError.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(-1 if longest is None else longest + 1)
        if longest is not None and len(content) > longest:
            raise InputError(f"{path}: longer than {longest / 1e6:g} MB, which no {what} is; check the path")
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except FileNotFoundError:
        raise InputError(f"{path}: no such {what}; check the path") from None
    except OSError as error:
        raise InputError(f"{path}: cannot read this {what}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: cannot read this {what}: not UTF-8 text") from None


def begin_file(path: Path) -> tuple[int, Path]:
    """An empty file beside ``path``, hidden, open for writing: its descriptor and its name. Raises OSError."""
    descriptor, part = tempfile.mkstemp(".part", f".{path.name}.", path.parent)
    return descriptor, Path(part)


def end_file(part: Path, path: Path) -> None:
    """Give a finished file its name, in place of whatever had it. Raises OSError."""
    # mkstemp makes files for their owner alone; these are to be read as any other file is.
    mask = os.umask(0)
    os.umask(mask)
    part.chmod(0o666 & ~mask)
    part.replace(path)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file as a whole or not at all. Raises InputError."""
    try:
        descriptor, part = begin_file(path)
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(content)
            end_file(part, path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(f"{path}: cannot write this file: {error.strerror}") from None
