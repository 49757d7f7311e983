"""The summary at the end of an MCAP file. It is read first: it describes channels whose chunk may be damaged."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import dataclass, field, replace

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, Schema, Statistics

from slider_drilling.log.mcap_chunk import PARSE_ERRORS
from slider_drilling.log.mcap_records import HEAD, MAGIC, FileBytes, RecordSpan, record_at

_FOOTER = 20
# A summary has some 200 bytes a chunk: this is a month of recording.
_MAX_BYTES = 512 * 1024 * 1024


@dataclass(frozen=True)
class McapSummary:
    """The records of a summary whose checksum is right; chunks by the offset where each starts."""

    schemas: list[Schema] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    chunks: dict[int, ChunkIndex] = field(default_factory=dict)
    statistics: Statistics | None = None


def read_mcap_summary(source: FileBytes, base: int) -> McapSummary | None:
    """The summary of the log that starts at `base` and ends with the file; None where it is missing or damaged."""
    at = source.size - len(MAGIC) - _FOOTER - HEAD
    footer = record_at(source, at) if at >= base else None
    if footer is None or footer.opcode != Opcode.FOOTER or source.read(footer.end, len(MAGIC)) != MAGIC:
        return None
    start, _, crc = struct.unpack("<QQI", source.read(footer.content_start, _FOOTER))
    if start == 0 or not base < base + start < at or at - base - start > _MAX_BYTES:
        return None
    data = source.read(base + start, at - base - start)
    # The checksum includes the beginning of the footer.
    if crc and zlib.crc32(source.read(at, HEAD + 16), zlib.crc32(data)) != crc:
        return None
    summary = McapSummary()
    try:
        statistics = _collect(source, base, base + start, at, summary)
    except PARSE_ERRORS:
        return None
    return None if statistics is None else replace(summary, statistics=statistics)


def _collect(source: FileBytes, base: int, at: int, end: int, summary: McapSummary) -> Statistics | None:
    """Fill the lists of a summary from its records; return its statistics, None where it is damaged.

    Raises one of PARSE_ERRORS where a record is damaged.
    """
    statistics = None
    while at < end:
        record = record_at(source, at)
        if record is None or record.end > end:
            return None
        if record.opcode == Opcode.SCHEMA:
            summary.schemas.append(Schema.read(_stream(source, record)))
        elif record.opcode == Opcode.CHANNEL:
            summary.channels.append(Channel.read(_stream(source, record)))
        elif record.opcode == Opcode.CHUNK_INDEX:
            index = ChunkIndex.read(_stream(source, record))
            summary.chunks[base + index.chunk_start_offset] = index
        elif record.opcode == Opcode.STATISTICS:
            statistics = Statistics.read(_stream(source, record))
        at = record.end
    return statistics


def _stream(source: FileBytes, record: RecordSpan) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(source.read(record.content_start, record.end - record.content_start)))
