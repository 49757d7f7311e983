"""Unpacks files that were compressed as a whole: `ros2 bag record --compression-mode file`, gzip, bzip2, xz, lz4."""

from __future__ import annotations

import bz2
import contextlib
import gzip
import lzma
import shutil
import tempfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import lz4.frame
import zstandard

from slider_drilling.errors import InputError

_BLOCK = 1 << 14  # a block that breaks off is lost
# The longest of the magic numbers below.
_MAGIC_BYTES = 6


def _open_zstd(file: IO[bytes]) -> Any:
    return zstandard.ZstdDecompressor().stream_reader(file, read_across_frames=True)


_OPENERS: dict[bytes, tuple[str, Callable[[IO[bytes]], Any]]] = {
    b"\x28\xb5\x2f\xfd": ("zstd", _open_zstd),
    b"\x1f\x8b": ("gzip", lambda file: gzip.GzipFile(fileobj=file)),
    b"BZh": ("bzip2", bz2.BZ2File),
    b"\xfd7zXZ\x00": ("xz", lzma.LZMAFile),
    b"\x04\x22\x4d\x18": ("lz4", lz4.frame.LZ4FrameFile),
}
_BROKEN = (EOFError, OSError, RuntimeError, zlib.error, lzma.LZMAError, zstandard.ZstdError)


def _opener(file: IO[bytes]) -> tuple[str, Callable[[IO[bytes]], Any]] | None:
    """Method and opener of a compressed file; None for any other. Raises OSError."""
    begin = file.read(_MAGIC_BYTES)
    file.seek(0)
    return next((value for magic, value in _OPENERS.items() if begin.startswith(magic)), None)


def first_unpacked_bytes(path: Path, count: int) -> bytes:
    """The first bytes of a file's unpacked content; fewer where it is short or damaged. Raises OSError."""
    with path.open("rb") as file:
        opener = _opener(file)
        if opener is None:
            return file.read(count)
        try:
            return bytes(opener[1](file).read(count))
        except _BROKEN:
            return b""


@contextlib.contextmanager
def unpacked_file(path: Path, notes: list[str]) -> Iterator[Path]:
    """Yields the path of a file's unpacked content: its own where it is not compressed, else of a temporary file.

    Args:
        path: The file.
        notes: Gets a sentence where the compressed bytes break off.

    Raises:
        InputError: Nothing can be unpacked, or it does not fit on the disk.
        OSError: The file cannot be read.
    """
    with path.open("rb") as file:
        opener = _opener(file)
        if opener is None:
            yield path
            return
        with tempfile.NamedTemporaryFile(prefix="slider_drilling_", suffix=path.stem[-40:]) as unpacked:
            _unpack(path, opener[0], opener[1](file), unpacked, notes)
            yield Path(unpacked.name)


def _unpack(path: Path, method: str, packed: IO[bytes], unpacked: IO[bytes], notes: list[str]) -> None:
    """Unpack as far as possible. Raises InputError where nothing can be, or where it does not fit on the disk."""
    room = shutil.disk_usage(tempfile.gettempdir()).free // 2
    while True:
        try:
            block = packed.read(_BLOCK)
        except _BROKEN:
            notes.append(f"its {method} compression breaks off or is damaged; what could be unpacked was read")
            break
        if not block:
            break
        room -= len(block)
        try:
            if room < 0:
                raise OSError
            unpacked.write(block)
        except OSError:
            raise InputError(
                f"{path}: no room to unpack it in {tempfile.gettempdir()}; set TMPDIR, or unpack it with `{method} -d`"
            ) from None
    if not unpacked.tell():
        raise InputError(f"{path}: its {method} compression holds nothing, or is damaged from the beginning")
    unpacked.flush()
