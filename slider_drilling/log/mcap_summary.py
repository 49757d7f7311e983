"""The summary at the end of an MCAP file. It is read first: it describes channels whose chunk may be damaged."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import dataclass, field

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, Schema

from slider_drilling.log.mcap_chunk import PARSE_ERRORS
from slider_drilling.log.mcap_records import HEAD_SIZE, MAGIC, MAX_PADDING, FileBytes, RecordSpan, record_at

_FOOTER = 20
# A summary has some 200 bytes a chunk: this is a month of recording.
_MAX_BYTES = 512 * 1024 * 1024


@dataclass(frozen=True)
class McapSummary:
    """The records of a summary whose checksum is right; chunks by the offset where each starts."""

    schemas: list[Schema] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    chunks: dict[int, ChunkIndex] = field(default_factory=dict)


def read_mcap_summary(source: FileBytes, base: int) -> McapSummary | None:
    """The summary of the log that starts at `base` and ends with the file; None where it is missing or damaged."""
    footer = _find_footer(source, base)
    if footer is None:
        return None
    at = footer.start
    start, _, crc = struct.unpack("<QQI", source.read(footer.content_start, _FOOTER))
    if start == 0 or not base < base + start < at or at - base - start > _MAX_BYTES:
        return None
    data = source.read(base + start, at - base - start)
    # The checksum includes the beginning of the footer.
    if crc and zlib.crc32(source.read(at, HEAD_SIZE + 16), zlib.crc32(data)) != crc:
        return None
    summary = McapSummary()
    try:
        _collect(source, base, base + start, at, summary)
    except PARSE_ERRORS:
        return None
    return summary


def _find_footer(source: FileBytes, base: int) -> RecordSpan | None:
    """The footer before the magic that ends the file, with or without padding behind its fields."""
    end = source.size - len(MAGIC)
    if source.read(end, len(MAGIC)) != MAGIC:
        return None
    last = end - _FOOTER - HEAD_SIZE
    first = max(base, last - MAX_PADDING)
    tail = source.read(first, last + 1 - first) if last >= first else b""
    at = tail.rfind(Opcode.FOOTER)
    while at >= 0:
        record = record_at(source, first + at)
        if record is not None and record.opcode == Opcode.FOOTER and record.end == end:
            return record
        at = tail.rfind(Opcode.FOOTER, 0, at)
    return None


def _collect(source: FileBytes, base: int, at: int, end: int, summary: McapSummary) -> None:
    """Fill the lists of a summary from its records. Raises one of PARSE_ERRORS where one is damaged."""
    while at < end:
        record = record_at(source, at)
        if record is None or record.end > end:
            raise ValueError("a record runs beyond the summary")
        if record.opcode == Opcode.SCHEMA:
            summary.schemas.append(Schema.read(_stream(source, record)))
        elif record.opcode == Opcode.CHANNEL:
            summary.channels.append(Channel.read(_stream(source, record)))
        elif record.opcode == Opcode.CHUNK_INDEX:
            index = ChunkIndex.read(_stream(source, record))
            summary.chunks[base + index.chunk_start_offset] = index
        at = record.end


def _stream(source: FileBytes, record: RecordSpan) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(source.read(record.content_start, record.end - record.content_start)))
