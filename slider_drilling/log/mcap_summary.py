"""The summary at the end of an MCAP file, read before the rest: it describes channels that a damaged chunk does not."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import dataclass, field

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, Schema, Statistics

from slider_drilling.log.mcap_chunk import PARSE_ERRORS
from slider_drilling.log.mcap_records import HEAD, MAGIC, FileBytes, RecordSpan, record_at

_FOOTER = 20
# A summary is some 200 bytes a chunk: this is one of a month of recording.
_LARGEST = 512 * 1024 * 1024


@dataclass(frozen=True)
class McapSummary:
    """What the summary says, its checksum having been found right. chunks: by where each begins."""

    schemas: list[Schema] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    chunks: dict[int, ChunkIndex] = field(default_factory=dict)
    statistics: Statistics | None = None


def read_mcap_summary(source: FileBytes, base: int) -> McapSummary | None:
    """The summary of the log that begins at `base` and ends with the file; None where there is no whole one."""
    at = source.size - len(MAGIC) - _FOOTER - HEAD
    footer = record_at(source, at) if at >= base else None
    if footer is None or footer.opcode != Opcode.FOOTER or source.read(footer.end, len(MAGIC)) != MAGIC:
        return None
    start, _, crc = struct.unpack("<QQI", source.read(footer.content_start, _FOOTER))
    if start == 0 or not base < base + start < at or at - base - start > _LARGEST:
        return None
    data = source.read(base + start, at - base - start)
    # The checksum goes on over the footer's own beginning.
    if crc and zlib.crc32(source.read(at, HEAD + 16), zlib.crc32(data)) != crc:
        return None
    tail = McapSummary()
    try:
        statistics = _collect(source, base, base + start, at, tail)
    except PARSE_ERRORS:
        return None
    return None if statistics is None else McapSummary(tail.schemas, tail.channels, tail.chunks, statistics)


def _collect(source: FileBytes, base: int, at: int, end: int, tail: McapSummary) -> Statistics | None:
    """Fill the tail from its records; its statistics. Raises one of DAMAGE, or gives None, where it is none."""
    statistics = None
    while at < end:
        record = record_at(source, at)
        if record is None or record.end > end:
            return None
        if record.opcode == Opcode.SCHEMA:
            tail.schemas.append(Schema.read(_stream(source, record)))
        elif record.opcode == Opcode.CHANNEL:
            tail.channels.append(Channel.read(_stream(source, record)))
        elif record.opcode == Opcode.CHUNK_INDEX:
            index = ChunkIndex.read(_stream(source, record))
            tail.chunks[base + index.chunk_start_offset] = index
        elif record.opcode == Opcode.STATISTICS:
            statistics = Statistics.read(_stream(source, record))
        at = record.end
    return statistics


def _stream(source: FileBytes, record: RecordSpan) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(source.read(record.content_start, record.end - record.content_start)))
