"""An MCAP file record by record; damaged bytes are skipped up to the next plausible record."""

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
RECORD_HEAD = struct.Struct("<BQ")  # opcode, length of the content
HEAD_SIZE = RECORD_HEAD.size
# Smallest content of each record, bytes. Any record may be longer: readers skip what follows its fields.
_MIN_BYTES = {
    Opcode.HEADER: 8, Opcode.FOOTER: 20, Opcode.SCHEMA: 14, Opcode.CHANNEL: 16, Opcode.MESSAGE: 22, Opcode.CHUNK: 40,
    Opcode.MESSAGE_INDEX: 6, Opcode.CHUNK_INDEX: 64, Opcode.ATTACHMENT: 36, Opcode.ATTACHMENT_INDEX: 48,
    Opcode.STATISTICS: 46, Opcode.METADATA: 8, Opcode.METADATA_INDEX: 20, Opcode.SUMMARY_OFFSET: 17, Opcode.DATA_END: 4,
}  # fmt: skip
# Records of fixed fields; a longer padding than this behind them is taken for damage.
_FIXED = (Opcode.FOOTER, Opcode.SUMMARY_OFFSET, Opcode.DATA_END)
MAX_PADDING = 4096
_PRIVATE = 0x80  # opcodes from here on are extensions of other programs
# The possible beginning of a record: an opcode and a length below 4 GiB.
_CANDIDATE = re.compile(rb"[\x01-\x0f][\x00-\xff]{4}\x00{4}")
_LONGEST_COMPRESSION = 32
_CHAIN = 4  # consecutive valid records after which reading resumes
_BLOCK = 1 << 20


class FileBytes:
    """Random access to the bytes of a file, read in blocks. Methods raise OSError."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self.size = os.fstat(file.fileno()).st_size
        self._start = 0
        self._block = b""

    def read(self, at: int, length: int) -> bytes:
        """`length` bytes from offset `at` on; fewer at the file's end."""
        first = at - self._start
        if first < 0 or first + length > len(self._block):
            self._file.seek(at)
            self._start, self._block = at, self._file.read(max(length, _BLOCK))
            first = 0
        return self._block[first : first + length]

    def crc(self, first: int, last: int) -> int:
        """CRC-32 of the bytes in [first, last)."""
        crc = 0
        for at in range(first, last, _BLOCK):
            crc = zlib.crc32(self.read(at, min(_BLOCK, last - at)), crc)
        return crc


@dataclass(frozen=True)
class RecordSpan:
    """A record's opcode, and the offsets where it starts and ends."""

    opcode: int
    start: int
    end: int

    @property
    def content_start(self) -> int:
        """Offset where its content starts."""
        return self.start + HEAD_SIZE


@dataclass(frozen=True)
class DamagedSpan:
    """A range of bytes without a valid record; `at_end`: no record follows."""

    start: int
    end: int
    at_end: bool


@dataclass(frozen=True)
class EndOfLog:
    """The offset behind a footer, where the log ends."""

    at: int


def record_at(source: FileBytes, at: int) -> RecordSpan | None:
    """The record that starts at this offset; None where there is no valid one."""
    head = source.read(at, HEAD_SIZE)
    if len(head) < HEAD_SIZE:
        return None
    opcode, length = RECORD_HEAD.unpack(head)
    if at + HEAD_SIZE + length > source.size:
        return None
    if opcode != Opcode.MESSAGE and _fits_chunk(source, at, length, MAX_PADDING if opcode == Opcode.CHUNK else 0):
        # A flipped bit may have changed the opcode, but the lengths inside identify a chunk, and it has a checksum.
        return RecordSpan(Opcode.CHUNK, at, at + HEAD_SIZE + length)
    min_bytes = _MIN_BYTES.get(opcode)
    if opcode == Opcode.CHUNK or (min_bytes is None and opcode < _PRIVATE):
        return None
    if min_bytes is not None and (length < min_bytes or (opcode in _FIXED and length > min_bytes + MAX_PADDING)):
        return None
    return RecordSpan(opcode, at, at + HEAD_SIZE + length)


def is_cut_record(source: FileBytes, at: int) -> bool:
    """Whether the file ends here, or within a record that starts here: what is there is whole as far as it goes."""
    head = source.read(at, HEAD_SIZE)
    if len(head) < HEAD_SIZE:
        return not head or head[0] in _MIN_BYTES or head[0] >= _PRIVATE
    opcode, length = RECORD_HEAD.unpack(head)
    return (opcode in _MIN_BYTES or opcode >= _PRIVATE) and source.size < at + HEAD_SIZE + length < at + (1 << 32)


def _fits_chunk(source: FileBytes, at: int, length: int, max_padding: int) -> bool:
    """Whether the lengths inside a record (of the compression's name, of the data) are those of a chunk."""
    if length < _MIN_BYTES[Opcode.CHUNK]:
        return False
    (name,) = struct.unpack("<I", source.read(at + HEAD_SIZE + 28, 4))
    if name > _LONGEST_COMPRESSION or length < _MIN_BYTES[Opcode.CHUNK] + name:
        return False
    (data,) = struct.unpack("<Q", source.read(at + HEAD_SIZE + 32 + name, 8))
    return 0 <= length - 40 - name - int(data) <= max_padding


def iterate_records(
    source: FileBytes, at: int, chunks: Sequence[int] = ()
) -> Iterator[RecordSpan | DamagedSpan | EndOfLog]:
    """Yield the records from an offset up to and including the next footer, then EndOfLog.

    Args:
        source: The file.
        at: Offset of the first record.
        chunks: Offsets of chunks that the summary lists, increasing. A record that reaches beyond one is damaged.

    Yields:
        Records; DamagedSpan for bytes that hold none; EndOfLog behind the footer.
    """
    while True:
        record = record_at(source, at)
        if record is not None and record.opcode != Opcode.CHUNK:
            next_chunk = bisect.bisect_right(chunks, at)
            if next_chunk < len(chunks) and chunks[next_chunk] < record.end:
                record = None
        if record is None:
            resume = find_next_record(source, at + 1)
            yield DamagedSpan(at, source.size if resume is None else resume, resume is None)
            if resume is None:
                return
            at = resume
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
    """Offset of the next record, from `at` on, that is followed by valid records; None where there is none."""
    while at < source.size:
        block = source.read(at, _BLOCK)
        first = 0
        while (match := _CANDIDATE.search(block, first)) is not None:
            if _starts_chain(source, at + match.start()):
                return at + match.start()
            first = match.start() + 1
        if at + len(block) >= source.size:
            return None
        at += len(block) - HEAD_SIZE + 1
    return None


def _starts_chain(source: FileBytes, at: int) -> bool:
    """Whether valid records follow each other from here: _CHAIN of them, or up to a footer and the file's magic."""
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
