"""MCAP files as they are found: whole, unfinished, damaged, several in one; what is lost of them is said."""

from __future__ import annotations

import io
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Message, Metadata, Schema, Statistics

from slider_drilling.errors import InputError
from slider_drilling.log.mcap_chunk import (
    PARSE_ERRORS,
    MessageBlock,
    UnknownCompression,
    UnreadableChunk,
    chunk_header,
    iterate_messages,
    message_block,
    unpack_chunk,
)
from slider_drilling.log.mcap_records import (
    HEAD,
    MAGIC,
    DamagedSpan,
    EndOfLog,
    FileBytes,
    RecordSpan,
    find_next_record,
    iterate_records,
    record_at,
)
from slider_drilling.log.mcap_summary import McapSummary, read_mcap_summary

# Bytes of a record, chunks and messages aside, that is read: rig files and notes are some kB.
MAX_RECORD_BYTES = 64 * 1024 * 1024
# Bytes of messages that are handed on at a time, about, however small the chunks are.
_TOGETHER = 1 << 20
_TO_THE_END = "recovered up to the last complete chunk"


@dataclass
class LostContent:
    """Chunks that could not be opened: why -> (how many, the seconds that they were to cover)."""

    chunks: dict[str, tuple[int, float]] = field(default_factory=dict)
    unknown: Counter[int] = field(default_factory=Counter)
    late: int = 0

    def add_chunk(self, why: str, seconds: float) -> None:
        """Count one."""
        count, before = self.chunks.get(why, (0, 0.0))
        self.chunks[why] = (count + 1, before + seconds)


@dataclass
class McapReader:
    """What one file holds besides messages, filled while its messages are read.

    Ids of schemas and channels are made unique over the logs that a file may hold one after another. moved: its
    chunks are not in the order in which they were written.
    """

    path: Path
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    attachments: list[Attachment] = field(default_factory=list)
    metadata: list[Metadata] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    chunks_out_of_order: bool = False
    sections: int = 0

    def messages(self) -> Iterator[tuple[Channel, Message]]:
        """Every message in the order of the file. Raises InputError where the file is no MCAP file at all."""
        for block in self.blocks():
            for channel, sequence, logged, published, data in iterate_messages(block):
                yield self.channels[channel], Message(
                    channel_id=channel, sequence=sequence, log_time=logged, publish_time=published, data=data
                )

    def blocks(self) -> Iterator[MessageBlock]:
        """The same, many at a time, each with a channel that is known and a log time below 2^63 ns."""
        try:
            # A pipe would be waited for, and a device has no end.
            if self.path.exists() and not (self.path.is_file() or self.path.is_dir()):
                raise InputError(f"{self.path}: is a pipe or a device; give a file")
            with self.path.open("rb") as file:
                source = FileBytes(file)
                if source.size == 0:
                    raise InputError(f"{self.path}: is empty; expected an MCAP file")
                self._check_beginning(source)
                begin: int | None = len(MAGIC)
                while begin is not None:
                    section = McapSection(self, source, begin)
                    self.sections += 1
                    yield from section.blocks()
                    begin = section.next_begin
        except FileNotFoundError:
            raise InputError(f"{self.path}: no such log; check the path") from None
        except OSError as error:
            raise InputError(f"{self.path}: cannot read this log: {error.strerror}") from None
        if self.sections > 1:
            self.notes.append(f"holds {self.sections} logs one after another; all were read")

    def _check_beginning(self, source: FileBytes) -> None:
        """Raises InputError unless the file begins as an MCAP file does, but for a byte."""
        begins = source.read(0, len(MAGIC))
        wrong = sum(one != two for one, two in zip(begins, MAGIC, strict=False)) + len(MAGIC) - len(begins)
        first = record_at(source, len(MAGIC))
        if wrong > 1 or (wrong == 1 and (first is None or first.opcode != Opcode.HEADER)):
            raise InputError(f"{self.path}: not an MCAP file; logs are MCAP, see `slider-drilling import`")
        if wrong:
            self.notes.append("its first bytes are damaged")


class McapSection:
    """One log within a file, from behind its magic on. next_begin: where the next one's first record is, if any."""

    def __init__(self, container: McapReader, source: FileBytes, begin: int) -> None:
        self._container = container
        self._source = source
        self._begin = begin
        self._base = begin - len(MAGIC)
        self._offset = container.sections << 16
        self._tail: McapSummary | None = read_mcap_summary(source, self._base)
        self._lost = LostContent()
        self._parts: list[bytes] = []
        self._places: list[int] = []
        self._gathered_size = 0
        self._count = 0
        self._unchunked = 0
        self._is_damaged = False
        self.next_begin: int | None = None

    def blocks(self) -> Iterator[MessageBlock]:
        """Messages; schemas, channels, attachments, metadata and notes go to the container on the way."""
        for schema in self._tail.schemas if self._tail else ():
            self._keep_schema(schema)
        for channel in self._tail.channels if self._tail else ():
            self._keep_channel(channel)
        starts = sorted(self._tail.chunks) if self._tail else []
        for item in iterate_records(self._source, self._begin, starts):
            if isinstance(item, DamagedSpan):
                self._note_damage(item)
            elif isinstance(item, EndOfLog):
                self._look_behind(item.at)
            elif item.opcode == Opcode.HEADER and item.start > self._begin:
                # The end of the log before is missing: this begins another.
                self.next_begin = item.start
                break
            else:
                self._take(item)
            if self._gathered_size >= _TOGETHER:
                yield from self._gathered()
        yield from self._gathered()
        self._tell()

    def _take(self, record: RecordSpan) -> None:
        """What one record holds."""
        if record.opcode == Opcode.MESSAGE:
            self._unchunked += 1
            self._gather(self._source.read(record.start, record.end - record.start), [HEAD])
        elif record.opcode == Opcode.CHUNK:
            self._chunk(record)
        elif record.opcode == Opcode.DATA_END:
            self._check_data(record)
        elif record.opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.ATTACHMENT, Opcode.METADATA, Opcode.STATISTICS):
            self._keep(record)

    def _chunk(self, record: RecordSpan) -> None:
        """The messages of a chunk, and the channels that it describes."""
        content = self._content(record)
        head = chunk_header(content)
        index = self._tail.chunks.get(record.start) if self._tail else None
        try:
            opened = unpack_chunk(content)
        except UnknownCompression as error:
            raise InputError(
                f"{self._container.path}: a chunk is {error}; write it again with zstd, lz4 or no compression"
            ) from None
        except UnreadableChunk as error:
            first, last = (
                (head.first, head.last) if index is None else (index.message_start_time, index.message_end_time)
            )
            self._is_damaged = True
            self._lost.add_chunk(str(error), max(0, last - first) * 1e-9)
            return
        if self._tail and self._tail.chunks:
            self._container.chunks_out_of_order |= index is None or (
                index.message_start_time != head.first and index.message_end_time != head.last
            )
        for schema in opened.schemas:
            self._keep_schema(schema)
        for channel in opened.channels:
            self._keep_channel(channel)
        self._gather(opened.data, opened.message_offsets)

    def _gather(self, data: bytes, places: list[int]) -> None:
        """Add messages, whose content begins at these places, to those that are handed on together."""
        self._count += len(places)
        self._parts.append(data)
        self._places += [self._gathered_size + place for place in places]
        self._gathered_size += len(data)

    def _gathered(self) -> Iterator[MessageBlock]:
        """The messages that came since the last time."""
        data, places = b"".join(self._parts), self._places
        self._parts, self._places, self._gathered_size = [], [], 0
        if places:
            yield from self._usable(message_block(data, places))

    def _usable(self, block: MessageBlock) -> Iterator[MessageBlock]:
        """The messages that can be used; the others are counted."""
        known = np.isin(block.channel, [key - self._offset for key in self._container.channels])
        if not known.all():
            self._lost.unknown.update(block.channel[~known].tolist())
        early = block.log_time < 2**63
        self._lost.late += int(np.count_nonzero(known & ~early))
        if not (known & early).all():
            block = block.select(known & early)
        if len(block.channel):
            yield replace(block, channel=block.channel + self._offset)

    def _content(self, record: RecordSpan) -> bytes:
        return self._source.read(record.content_start, record.end - record.content_start)

    def _keep(self, record: RecordSpan) -> None:
        """A record that is neither chunk nor message."""
        if record.end - record.content_start > MAX_RECORD_BYTES:
            self._container.notes.append(f"a record of {(record.end - record.content_start) / 1e6:.0f} MB was left out")
            return
        content = self._content(record)
        stream = ReadDataStream(io.BytesIO(content))
        try:
            if record.opcode == Opcode.SCHEMA:
                self._keep_schema(Schema.read(stream))
            elif record.opcode == Opcode.CHANNEL:
                self._keep_channel(Channel.read(stream))
            elif record.opcode == Opcode.METADATA:
                self._container.metadata.append(Metadata.read(stream))
            elif record.opcode == Opcode.STATISTICS:
                self._compare(Statistics.read(stream).message_count)
            else:
                self._keep_attachment(Attachment.read(stream), content)
        except PARSE_ERRORS:
            self._is_damaged = True
            self._container.notes.append(f"a damaged record at byte {record.start} was left out")

    def _keep_attachment(self, attachment: Attachment, content: bytes) -> None:
        written = content[-4:]
        right = RecordBuilder()
        attachment.write(right)
        if written in (b"\0\0\0\0", right.end()[-4:]):
            self._container.attachments.append(attachment)
        else:
            self._is_damaged = True
            self._container.notes.append(f"attachment {attachment.name} is damaged and was left out")

    def _keep_schema(self, schema: Schema) -> None:
        # What came first stays: the summary, whose checksum is right, or what the messages so far were taken for.
        self._container.schemas.setdefault(schema.id + self._offset, replace(schema, id=schema.id + self._offset))

    def _keep_channel(self, channel: Channel) -> None:
        key = channel.id + self._offset
        schema_id = channel.schema_id + self._offset if channel.schema_id else 0
        self._container.channels.setdefault(key, replace(channel, id=key, schema_id=schema_id))

    def _compare(self, counted: int) -> None:
        if self._count < counted:
            self._container.notes.append(
                f"holds {self._count} messages of the {counted} that its own summary counts"
            )

    def _check_data(self, record: RecordSpan) -> None:
        """Compare the checksum over all that came before with the one that was written."""
        (written,) = struct.unpack("<I", self._content(record))
        if written == 0 or (not self._unchunked and (self._is_damaged or self._container.chunks_out_of_order)):
            return
        # Some writers leave the magic out of it.
        if written in (self._source.crc(self._base, record.start), self._source.crc(self._begin, record.start)):
            return
        if self._unchunked:
            self._container.notes.append("the checksum over its messages does not fit: some of them may be wrong")
        else:
            self._container.notes.append("is damaged outside its chunks: the messages are whole, its notes may not be")

    def _look_behind(self, at: int) -> None:
        """What follows the footer: the magic, and at times another log."""
        source, notes = self._source, self._container.notes
        behind = source.read(at, 2 * len(MAGIC))
        if behind[: len(MAGIC)] != MAGIC:
            notes.append("does not end as an MCAP file does; everything before its end was read")
        at += len(MAGIC)
        if at >= source.size:
            if self._tail is None and not self._is_damaged and self._has_summary(at):
                notes.append("its summary is damaged and was not used")
            return
        begin = at + len(MAGIC) if source.read(at, len(MAGIC)) == MAGIC else find_next_record(source, at)
        if begin is None:
            notes.append(f"{source.size - at} bytes after its end were not read")
        else:
            self.next_begin = begin

    def _has_summary(self, end: int) -> bool:
        """Whether the footer, which ends with the file's magic at `end`, names a summary."""
        start, _, _ = struct.unpack("<QQI", self._source.read(end - len(MAGIC) - 20, 20))
        return bool(start)

    def _note_damage(self, damage: DamagedSpan) -> None:
        size = self._source.size
        self._is_damaged = True
        if damage.at_end:
            self._container.notes.append(f"breaks off or is damaged at byte {damage.start} of {size}; {_TO_THE_END}")
        else:
            self._container.notes.append(
                f"is damaged from byte {damage.start} to {damage.end} of {size}; that stretch was left out"
            )

    def _tell(self) -> None:
        """Notes on what was counted."""
        notes = self._container.notes
        for why, (count, seconds) in self._lost.chunks.items():
            what = f"a {why} chunk was" if why == "damaged" else f"a chunk {why} was"
            if count > 1:
                what = f"{count} {why} chunks were" if why == "damaged" else f"{count} chunks {why} were"
            notes.append(f"{what} left out: a gap of {seconds:.1f} s")
        if self._lost.unknown:
            total, ids = sum(self._lost.unknown.values()), ", ".join(map(str, sorted(self._lost.unknown)))
            notes.append(f"{total} messages of channels whose description is lost were left out (ids {ids})")
        if self._lost.late:
            notes.append(f"{self._lost.late} messages logged after the year 2262 were left out")
        if self._container.chunks_out_of_order:
            notes.append("its chunks are not where its index says; put in the order of their times")
