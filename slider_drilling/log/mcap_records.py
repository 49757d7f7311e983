"""An MCAP file record by record, over damaged stretches to the next record that can be one."""

from __future__ import annotations

import bisect
import os
import re
import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import IO

from mcap.opcode import Opcode

MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")
HEAD = _HEAD.size
# Content bytes that a record has at least; those of a fixed size have exactly so many.
_LEAST = {
    Opcode.HEADER: 8, Opcode.FOOTER: 20, Opcode.SCHEMA: 14, Opcode.CHANNEL: 16, Opcode.MESSAGE: 22, Opcode.CHUNK: 40,
    Opcode.MESSAGE_INDEX: 6, Opcode.CHUNK_INDEX: 64, Opcode.ATTACHMENT: 36, Opcode.ATTACHMENT_INDEX: 48,
    Opcode.STATISTICS: 46, Opcode.METADATA: 8, Opcode.METADATA_INDEX: 20, Opcode.SUMMARY_OFFSET: 17, Opcode.DATA_END: 4,
}  # fmt: skip
_FIXED = (Opcode.FOOTER, Opcode.SUMMARY_OFFSET, Opcode.DATA_END)
_PRIVATE = 0x80  # opcodes from here on are other makers' own
# What a record can begin with: an opcode and a length below 4 GiB.
_CANDIDATE = re.compile(rb"[\x01-\x0f][\x00-\xff]{4}\x00{4}")
_LONGEST_COMPRESSION = 32
_CHAIN = 4  # records in a row that must fit before a stretch counts as read again
_BLOCK = 1 << 20


class FileBytes:
    """Bytes of a file at any place, read a block at a time. Raises OSError."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self.size = os.fstat(file.fileno()).st_size
        self._start = 0
        self._block = b""

    def read(self, at: int, length: int) -> bytes:
        """`length` bytes from `at` on, fewer at the file's end."""
        first = at - self._start
        if first < 0 or first + length > len(self._block):
            self._file.seek(at)
            self._start, self._block = at, self._file.read(max(length, _BLOCK))
            first = 0
        return self._block[first : first + length]

    def crc(self, first: int, last: int) -> int:
        """Checksum of the bytes from first up to last."""
        crc = 0
        for at in range(first, last, _BLOCK):
            crc = zlib.crc32(self.read(at, min(_BLOCK, last - at)), crc)
        return crc


@dataclass(frozen=True)
class RecordSpan:
    """Where a record is: its opcode, where it begins, where its content ends."""

    opcode: int
    start: int
    end: int

    @property
    def content_start(self) -> int:
        """Where its content begins."""
        return self.start + HEAD


@dataclass(frozen=True)
class DamagedSpan:
    """A stretch of bytes that hold no record; at_end: nothing follows it."""

    start: int
    end: int
    at_end: bool


@dataclass(frozen=True)
class EndOfLog:
    """What follows a footer, from here on."""

    at: int


def record_at(source: FileBytes, at: int) -> RecordSpan | None:
    """The record that begins here; None where none can."""
    head = source.read(at, HEAD)
    if len(head) < HEAD:
        return None
    opcode, length = _HEAD.unpack(head)
    if at + HEAD + length > source.size:
        return None
    if opcode != Opcode.MESSAGE and _fits_chunk(source, at, length):
        # Whatever a flipped bit made of the opcode: the lengths within leave no doubt, and the content has a checksum.
        return RecordSpan(Opcode.CHUNK, at, at + HEAD + length)
    least = _LEAST.get(opcode)
    if opcode == Opcode.CHUNK or (least is None and opcode < _PRIVATE):
        return None
    if least is not None and (length < least or (opcode in _FIXED and length != least)):
        return None
    return RecordSpan(opcode, at, at + HEAD + length)


def _fits_chunk(source: FileBytes, at: int, length: int) -> bool:
    """Whether the lengths within a record are those of a chunk: of its compression's name and of its data."""
    if length < _LEAST[Opcode.CHUNK]:
        return False
    (name,) = struct.unpack("<I", source.read(at + HEAD + 28, 4))
    if name > _LONGEST_COMPRESSION or length < _LEAST[Opcode.CHUNK] + name:
        return False
    (data,) = struct.unpack("<Q", source.read(at + HEAD + 32 + name, 8))
    return bool(data == length - 40 - name)


def iterate_records(
    source: FileBytes, at: int, chunks: Sequence[int] = ()
) -> Iterator[RecordSpan | DamagedSpan | EndOfLog]:
    """Records from `at` up to and with the next footer, then End. Where none can be, Damage and what comes after it.

    chunks: where chunks are known to begin, increasing: no record but a chunk reaches beyond one.
    """
    while True:
        record = record_at(source, at)
        if record is not None and record.opcode != Opcode.CHUNK:
            next_chunk = bisect.bisect_right(chunks, at)
            if next_chunk < len(chunks) and chunks[next_chunk] < record.end:
                record = None
        if record is None:
            found = find_next_record(source, at + 1)
            yield DamagedSpan(at, source.size if found is None else found, found is None)
            if found is None:
                return
            at = found
            continue
        yield record
        at = record.end
        if record.opcode == Opcode.FOOTER:
            yield EndOfLog(at)
            return
        if at == source.size:
            yield DamagedSpan(at, at, at_end=True)
            return


def find_next_record(source: FileBytes, at: int) -> int | None:
    """Where, from `at` on, the next record begins that others follow; None for nowhere."""
    while at < source.size:
        block = source.read(at, _BLOCK)
        first = 0
        while (match := _CANDIDATE.search(block, first)) is not None:
            if _chains(source, at + match.start()):
                return at + match.start()
            first = match.start() + 1
        if at + len(block) >= source.size:
            return None
        at += len(block) - HEAD + 1
    return None


def _chains(source: FileBytes, at: int) -> bool:
    """Whether records follow each other from here: several, or up to a footer with the file's magic behind it."""
    for _ in range(_CHAIN):
        record = record_at(source, at)
        if record is None or record.opcode >= _PRIVATE:
            return False
        at = record.end
        if record.opcode == Opcode.CHUNK or at == source.size:
            return True
        if record.opcode == Opcode.FOOTER:
            return source.read(at, len(MAGIC)) == MAGIC
    return True
