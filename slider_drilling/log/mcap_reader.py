"""Reads MCAP files that may be whole, unfinished, damaged or several in one, and notes what is lost."""

from __future__ import annotations

import io
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Header, Metadata, Schema, Statistics

from slider_drilling.errors import InputError
from slider_drilling.log.being_written import is_being_written
from slider_drilling.log.log_reader import LogReader
from slider_drilling.log.mcap_chunk import (
    PARSE_ERRORS,
    MessageBlock,
    UnknownCompression,
    UnreadableChunk,
    chunk_header,
    message_block,
    unpack_chunk,
)
from slider_drilling.log.mcap_records import (
    HEAD_SIZE,
    MAGIC,
    DamagedSpan,
    EndOfLog,
    FileBytes,
    RecordSpan,
    find_next_record,
    is_cut_record,
    iterate_records,
    record_at,
)
from slider_drilling.log.mcap_summary import McapSummary, read_mcap_summary
from slider_drilling.log.unpack_file import unpacked_file
from slider_drilling.log.unpack_messages import unpack_messages

# Largest record, apart from chunks and messages, that is read: rig files and notes have some kB.
MAX_RECORD_BYTES = 64 * 1024 * 1024
# Small chunks are gathered into blocks of about this many bytes.
_BLOCK_BYTES = 1 << 20
_KEPT = (
    Opcode.HEADER, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.ATTACHMENT, Opcode.METADATA, Opcode.STATISTICS
)  # fmt: skip
_READ_TO_THE_END = "recovered up to the last complete chunk"


@dataclass
class LostContent:
    """What could not be read.

    Attributes:
        chunks: Reason -> (number of chunks, seconds that they cover).
        unknown: Channel id -> number of messages whose channel is not described.
        late: Number of messages with a log time beyond 2^63 ns.
    """

    chunks: dict[str, tuple[int, float]] = field(default_factory=dict)
    unknown: Counter[int] = field(default_factory=Counter)
    late: int = 0

    def add_chunk(self, reason: str, seconds: float) -> None:
        """Count a chunk."""
        count, before = self.chunks.get(reason, (0, 0.0))
        self.chunks[reason] = (count + 1, before + seconds)


@dataclass
class McapReader(LogReader):
    """One MCAP file.

    Attributes:
        sections: Number of logs in the file.
    """

    sections: int = 0

    def read_blocks(self) -> Iterator[MessageBlock]:
        """Messages in blocks, in the order of the file.

        Messages of unknown channels, and those with a log time of 2^63 ns or more, are left out.

        Raises:
            InputError: The file cannot be read or is no MCAP file.
        """
        try:
            with unpacked_file(self.path, self.notes) as path, path.open("rb") as file:
                yield from self._read(FileBytes(file))
        except FileNotFoundError:
            raise InputError(f"{self.path}: no such log; check the path") from None
        except OSError as error:
            raise InputError(f"{self.path}: cannot read this log: {error.strerror}") from None

    def _read(self, source: FileBytes) -> Iterator[MessageBlock]:
        """Yield the messages of every log in the file."""
        if source.size == 0:
            raise InputError(f"{self.path}: is empty; expected an MCAP file")
        self._check_beginning(source)
        begin: int | None = len(MAGIC)
        while begin is not None:
            section = McapSection(self, source, begin)
            self.sections += 1
            for block in section.blocks():
                yield unpack_messages(block)
            begin = section.next_begin
        if self.sections > 1:
            self.notes.append(f"holds {self.sections} logs one after another; all were read")

    def _check_beginning(self, source: FileBytes) -> None:
        """Raise InputError unless the file starts with MCAP's magic; one wrong byte is tolerated."""
        begins = source.read(0, len(MAGIC))
        wrong = sum(byte != right for byte, right in zip(begins, MAGIC, strict=False)) + len(MAGIC) - len(begins)
        first = record_at(source, len(MAGIC))
        if wrong > 1 or (wrong == 1 and (first is None or first.opcode != Opcode.HEADER)):
            raise InputError(f"{self.path}: not an MCAP file; logs are MCAP, see `slider-drilling import`")
        if wrong:
            self.notes.append("its first bytes are damaged")


class McapSection:
    """One log within a file.

    Attributes:
        next_begin: Offset of the first record of the next log in the file; None where this is the last one.
    """

    def __init__(self, reader: McapReader, source: FileBytes, begin: int) -> None:
        self._reader = reader
        self._source = source
        self._begin = begin
        self._base = begin - len(MAGIC)
        self._offset = reader.sections << 16
        self._summary: McapSummary | None = read_mcap_summary(source, self._base)
        self._lost = LostContent()
        self._parts: list[bytes] = []
        self._offsets: list[int] = []
        self._gathered_bytes = 0
        self._count = 0
        self._unchunked = 0
        self._is_damaged = False
        self._footer_names_summary = False
        self.next_begin: int | None = None

    def blocks(self) -> Iterator[MessageBlock]:
        """Yield the messages; everything else goes to the reader's attributes on the way."""
        for schema in self._summary.schemas if self._summary else ():
            self._keep_schema(schema)
        for channel in self._summary.channels if self._summary else ():
            self._keep_channel(channel)
        starts = sorted(self._summary.chunks) if self._summary else []
        for item in iterate_records(self._source, self._begin, starts):
            if isinstance(item, DamagedSpan):
                self._note_damage(item)
            elif isinstance(item, EndOfLog):
                self._check_after_footer(item.at)
            elif item.opcode == Opcode.HEADER and item.start > self._begin:
                # The end of this log is missing, and another one starts.
                self.next_begin = item.start
                break
            else:
                self._read_record(item)
            if self._gathered_bytes >= _BLOCK_BYTES:
                yield from self._flush()
        yield from self._flush()
        self._add_notes()

    def read_whole_records(self, source: FileBytes, at: int) -> tuple[list[MessageBlock], int, bool]:
        """Read a log that is still being written as far as its records are whole.

        Args:
            source: The file as it is now.
            at: Offset where the last call ended; at first, behind the file's magic.

        Returns:
            Messages, the offset behind the last whole record, and whether the log ends there.
        """
        self._source, ended = source, False
        while not ended and (record := record_at(source, at)) is not None:
            self._read_record(record)
            at, ended = record.end, record.opcode == Opcode.FOOTER
        return [unpack_messages(block) for block in self._flush()], at, ended

    def _read_record(self, record: RecordSpan) -> None:
        """Read one record."""
        if record.opcode == Opcode.MESSAGE:
            self._unchunked += 1
            self._gather(self._source.read(record.start, record.end - record.start), [HEAD_SIZE])
        elif record.opcode == Opcode.CHUNK:
            self._read_chunk(record)
        elif record.opcode == Opcode.DATA_END:
            self._check_data(record)
        elif record.opcode == Opcode.FOOTER:
            self._footer_names_summary = any(self._source.read(record.content_start, 8))
        elif record.opcode in _KEPT:
            self._keep_record(record)

    def _read_chunk(self, record: RecordSpan) -> None:
        """Read the messages of a chunk, and the channels that it describes."""
        content = self._content(record)
        header = chunk_header(content)
        index = self._summary.chunks.get(record.start) if self._summary else None
        try:
            chunk = unpack_chunk(content)
        except UnknownCompression as error:
            raise InputError(
                f"{self._reader.path}: a chunk is {error}; write it again with zstd, lz4 or no compression"
            ) from None
        except UnreadableChunk as error:
            first, last = (
                (header.first, header.last) if index is None else (index.message_start_time, index.message_end_time)
            )
            self._is_damaged = True
            self._lost.add_chunk(str(error), max(0, last - first) * 1e-9)
            return
        if self._summary and self._summary.chunks:
            self._reader.chunks_out_of_order |= index is None or (
                index.message_start_time != header.first and index.message_end_time != header.last
            )
        for schema in chunk.schemas:
            self._keep_schema(schema)
        for channel in chunk.channels:
            self._keep_channel(channel)
        self._gather(chunk.data, chunk.message_offsets)

    def _gather(self, data: bytes, offsets: list[int]) -> None:
        """Add messages, whose contents start at these offsets of `data`, to the next block."""
        self._count += len(offsets)
        self._parts.append(data)
        self._offsets += [self._gathered_bytes + offset for offset in offsets]
        self._gathered_bytes += len(data)

    def _flush(self) -> Iterator[MessageBlock]:
        """Yield the messages gathered since the last call."""
        data, offsets = b"".join(self._parts), self._offsets
        self._parts, self._offsets, self._gathered_bytes = [], [], 0
        if offsets:
            yield from self._usable(message_block(data, offsets))

    def _usable(self, block: MessageBlock) -> Iterator[MessageBlock]:
        """Yield the usable messages of a block; count the others."""
        known = np.isin(block.channel, [key - self._offset for key in self._reader.channels])
        if not known.all():
            self._lost.unknown.update(block.channel[~known].tolist())
        valid = block.log_time < 2**63
        self._lost.late += int(np.count_nonzero(known & ~valid))
        if not (known & valid).all():
            block = block.select(known & valid)
        if len(block.channel):
            yield replace(block, channel=block.channel + self._offset)

    def _content(self, record: RecordSpan) -> bytes:
        return self._source.read(record.content_start, record.end - record.content_start)

    def _keep_record(self, record: RecordSpan) -> None:
        """Read a record that is neither chunk nor message."""
        if record.end - record.content_start > MAX_RECORD_BYTES:
            self._reader.notes.append(f"a record of {(record.end - record.content_start) / 1e6:.0f} MB was left out")
            return
        content = self._content(record)
        stream = ReadDataStream(io.BytesIO(content))
        try:
            if record.opcode == Opcode.HEADER:
                self._reader.profile = Header.read(stream).profile
            elif record.opcode == Opcode.SCHEMA:
                self._keep_schema(Schema.read(stream))
            elif record.opcode == Opcode.CHANNEL:
                self._keep_channel(Channel.read(stream))
            elif record.opcode == Opcode.METADATA:
                self._reader.metadata.append(Metadata.read(stream))
            elif record.opcode == Opcode.STATISTICS:
                self._compare_count(Statistics.read(stream).message_count)
            else:
                self._keep_attachment(Attachment.read(stream), content)
        except PARSE_ERRORS:
            self._is_damaged = True
            self._reader.notes.append(f"a damaged record at byte {record.start} was left out")

    def _keep_attachment(self, attachment: Attachment, content: bytes) -> None:
        """Keep an attachment whose checksum is right, or not given (0)."""
        # Behind two times, two texts and the data, each with its length. Padding may follow.
        end = 8 + 8 + 4 + len(attachment.name.encode()) + 4 + len(attachment.media_type.encode()) + 8
        end += len(attachment.data)
        (checksum,) = struct.unpack_from("<I", content, end)
        if checksum in (0, zlib.crc32(content[:end])):
            self._reader.attachments.append(attachment)
        else:
            self._is_damaged = True
            self._reader.notes.append(f"attachment {attachment.name} is damaged and was left out")

    def _keep_schema(self, schema: Schema) -> None:
        # The first one stays: it is from the summary, whose checksum is right, or has been used for messages.
        self._reader.schemas.setdefault(schema.id + self._offset, replace(schema, id=schema.id + self._offset))

    def _keep_channel(self, channel: Channel) -> None:
        key = channel.id + self._offset
        schema_id = channel.schema_id + self._offset if channel.schema_id else 0
        self._reader.channels.setdefault(key, replace(channel, id=key, schema_id=schema_id))

    def _compare_count(self, counted: int) -> None:
        """Note where fewer messages were read than the summary counts."""
        if self._count < counted:
            self._reader.notes.append(
                f"holds {self._count} messages of the {counted} that its own summary counts"
            )

    def _check_data(self, record: RecordSpan) -> None:
        """Compare the checksum of everything before the DATA_END record with the one in it."""
        (written,) = struct.unpack_from("<I", self._content(record))
        if written == 0 or (not self._unchunked and (self._is_damaged or self._reader.chunks_out_of_order)):
            return
        # Some writers leave the magic out of the checksum.
        if written in (self._source.crc(self._base, record.start), self._source.crc(self._begin, record.start)):
            return
        if self._unchunked:
            self._reader.notes.append("the checksum over its messages does not fit: some of them may be wrong")
        else:
            self._reader.notes.append("is damaged outside its chunks: the messages are whole, its notes may not be")

    def _check_after_footer(self, at: int) -> None:
        """Check what follows the footer: the magic, and possibly another log."""
        source, notes = self._source, self._reader.notes
        rest = source.read(at, 2 * len(MAGIC))
        if rest[: len(MAGIC)] != MAGIC:
            notes.append("does not end as an MCAP file does; everything before its end was read")
        at += len(MAGIC)
        if at >= source.size:
            if self._summary is None and not self._is_damaged and self._footer_names_summary:
                notes.append("its summary is damaged and was not used")
            return
        begin = at + len(MAGIC) if source.read(at, len(MAGIC)) == MAGIC else find_next_record(source, at)
        if begin is None:
            notes.append(f"{source.size - at} bytes after its end were not read")
        else:
            self.next_begin = begin

    def _note_damage(self, damage: DamagedSpan) -> None:
        """Note a damaged range of bytes."""
        size = self._source.size
        self._is_damaged = True
        if damage.at_end and is_cut_record(self._source, damage.start):
            why = f"breaks off at byte {damage.start} of {size}: its recording was ended early, or it is a partial copy"
            if is_being_written(self._reader.path):
                why = "is still being recorded"
            self._reader.notes.append(f"{why}; {_READ_TO_THE_END}")
        elif damage.at_end:
            self._reader.notes.append(f"breaks off or is damaged at byte {damage.start} of {size}; {_READ_TO_THE_END}")
        else:
            self._reader.notes.append(
                f"is damaged from byte {damage.start} to {damage.end} of {size}; these bytes were left out"
            )

    def _add_notes(self) -> None:
        """Add notes on what was lost."""
        notes = self._reader.notes
        for reason, (count, seconds) in self._lost.chunks.items():
            what = f"a {reason} chunk was" if reason == "damaged" else f"a chunk {reason} was"
            if count > 1:
                what = f"{count} {reason} chunks were" if reason == "damaged" else f"{count} chunks {reason} were"
            notes.append(f"{what} left out: a gap of {seconds:.1f} s")
        if self._lost.unknown:
            total, ids = sum(self._lost.unknown.values()), ", ".join(map(str, sorted(self._lost.unknown)))
            notes.append(f"{total} messages of channels whose description is lost were left out (ids {ids})")
        if self._lost.late:
            notes.append(f"{self._lost.late} messages logged after the year 2262 were left out")
        if self._reader.chunks_out_of_order:
            notes.append("its chunks are not where its index says; put in the order of their times")
