"""Writes an MCAP file by whole records, so that it can be finished at any moment, even on a full disk.

Records are encoded by the mcap package. Its own Writer is not used: after a failed write it can neither finish the
file nor say what is in it.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import struct
import zlib
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from slider_drilling.log.mcap_records import MAGIC

# opcode, length, channel, sequence, log time, publish time; the message's data follows.
_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_FIXED = 22
# opcode, length, channel, bytes of the entries; these follow.
_INDEX = struct.Struct("<BQHI")
# A chunk is written when it has this size.
CHUNK_BYTES = 64 * 1024


def encoded(record: McapRecord) -> bytes:
    """The bytes of one record."""
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


def _encoded_index(channel_id: int, entries: list[tuple[int, int]]) -> bytes:
    """The bytes of a MessageIndex record; mcap's encoder takes a microsecond an entry."""
    size = 16 * len(entries)
    head = _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + size, channel_id, size)
    return head + struct.pack(f"<{2 * len(entries)}Q", *itertools.chain.from_iterable(entries))


class AppendOnlyFile:
    """A file that holds whole records only: a failed write is rolled back.

    Attributes:
        size: Bytes in the file.
        crc: CRC-32 of them; 0 once the file was shortened, as in a DataEnd record.
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._open = True
        self.size = 0
        self.crc = 0

    def append(self, data: bytes) -> int:
        """Append bytes and return their offset. Raises OSError and leaves the file as it was."""
        start, rest = self.size, memoryview(data)
        try:
            while rest:
                rest = rest[os.write(self._descriptor, rest) :]
        except BaseException:
            # The end of the file needs the room that the partial record takes.
            with contextlib.suppress(OSError):
                os.ftruncate(self._descriptor, start)
                os.lseek(self._descriptor, start, os.SEEK_SET)
            raise
        self.size += len(data)
        self.crc = zlib.crc32(data, self.crc)
        return start

    def shorten(self, size: int) -> None:
        """Keep the first `size` bytes. Raises OSError."""
        os.ftruncate(self._descriptor, size)
        os.lseek(self._descriptor, size, os.SEEK_SET)
        self.size, self.crc = size, 0

    def close(self) -> None:
        """Close the file; a second call does nothing. Raises OSError where the system lost what was written."""
        if self._open:
            self._open = False
            os.close(self._descriptor)


@dataclass
class OpenChunk:
    """Messages that are not in the file yet.

    Attributes:
        data: Their records.
        index: Channel id -> (log time ns, offset in `data`) of each message.
        first: Lowest log time, ns.
        last: Highest log time, ns.
        count: Number of messages.
    """

    data: bytearray = field(default_factory=bytearray)
    index: dict[int, list[tuple[int, int]]] = field(default_factory=lambda: defaultdict(list))
    first: int = 0
    last: int = 0
    count: int = 0


class McapWriter:
    """Writes one MCAP file to an open descriptor, and closes it.

    Messages are collected in a chunk, which is written when it is full, or by `flush`. Every method raises OSError
    where a write fails; the file stays readable then and can still be finished.

    Attributes:
        messages: Number of messages in the file.
        counts: Number of messages by channel id.
        first: Lowest log time in the file, ns.
        until: Highest log time in the file, ns.
    """

    def __init__(
        self, descriptor: int, library: str, chunk_bytes: int = CHUNK_BYTES, profile: str = "ros2"
    ) -> None:
        self._chunk_bytes = chunk_bytes
        self._file = AppendOnlyFile(descriptor)
        self._compress = zstandard.ZstdCompressor().compress
        self._chunk = OpenChunk()
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self.counts: dict[int, int] = defaultdict(int)
        self.messages = 0
        self.first, self.until = 0, 0
        try:
            self._file.append(MAGIC + encoded(Header(profile=profile, library=library)))
        except BaseException:
            self._file.close()
            raise

    @property
    def size(self) -> int:
        """Bytes in the file and in the open chunk, which is not compressed yet."""
        return self._file.size + len(self._chunk.data)

    @property
    def pending(self) -> int:
        """Number of messages that are not in the file yet."""
        return self._chunk.count

    def schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema and return its id."""
        self._schemas.append(Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=data))
        self._chunk.data += encoded(self._schemas[-1])
        return self._schemas[-1].id

    def channel(self, topic: str, encoding: str, schema_id: int, metadata: dict[str, str]) -> int:
        """Add a channel and return its id; `schema_id` is 0 for none."""
        channel = Channel(
            id=len(self._channels) + 1, topic=topic, message_encoding=encoding, metadata=metadata, schema_id=schema_id
        )
        self._channels.append(channel)
        self._chunk.data += encoded(channel)
        return channel.id

    def message(self, channel_id: int, sequence: int, log_time: int, publish_time: int, data: bytes) -> None:
        """Add a message, times in ns."""
        chunk, offset = self._chunk, len(self._chunk.data)
        head = _MESSAGE.pack(
            Opcode.MESSAGE, _MESSAGE_FIXED + len(data), channel_id, sequence & 0xFFFFFFFF, log_time, publish_time
        )
        # The record goes in first and in one step: an interrupt afterwards leaves a valid chunk.
        chunk.data += head + data
        chunk.index[channel_id].append((log_time, offset))
        chunk.first = log_time if not chunk.count else min(chunk.first, log_time)
        chunk.last = max(chunk.last, log_time)
        chunk.count += 1
        if len(chunk.data) >= self._chunk_bytes:
            self.flush()

    def messages_in_order(
        self, channels: Sequence[int], sequences: Sequence[int], times: Sequence[int], data: Sequence[bytes]
    ) -> None:
        """Add many messages, each with its channel, number, time in ns (logged and sent), and bytes."""
        pack, fixed = _MESSAGE.pack, _MESSAGE_FIXED
        for channel, sequence, time, content in zip(channels, sequences, times, data, strict=True):
            chunk = self._chunk
            body = chunk.data
            offset = len(body)
            body += pack(Opcode.MESSAGE, fixed + len(content), channel, sequence & 0xFFFFFFFF, time, time) + content
            chunk.index[channel].append((time, offset))
            chunk.first = time if not chunk.count else min(chunk.first, time)
            chunk.last = max(chunk.last, time)
            chunk.count += 1
            if offset >= self._chunk_bytes:
                self.flush()

    def attachment(
        self, name: str, media_type: str, data: bytes, log_time: int = 0, create_time: int = 0
    ) -> None:
        """Add an attachment behind the messages so far; its times, ns, are 0 where they are not known."""
        self.flush()
        record = encoded(
            Attachment(create_time=create_time, log_time=log_time, name=name, media_type=media_type, data=data)
        )
        self._attachments.append(
            AttachmentIndex(
                offset=self._file.append(record), length=len(record), log_time=log_time, create_time=create_time,
                data_size=len(data), name=name, media_type=media_type,
            )
        )  # fmt: skip

    def metadata(self, name: str, values: dict[str, str]) -> None:
        """Add a metadata record behind the messages so far."""
        self.flush()
        record = encoded(Metadata(name=name, metadata=values))
        self._metadata.append(MetadataIndex(offset=self._file.append(record), length=len(record), name=name))

    def flush(self) -> None:
        """Write the open chunk. A program that is killed afterwards loses none of it."""
        chunk = self._chunk
        if not chunk.data:
            return
        data = bytes(chunk.data)
        compressed = self._compress(data)
        record = encoded(
            Chunk(compression="zstd", data=compressed, message_start_time=chunk.first,
                  message_end_time=chunk.last, uncompressed_crc=zlib.crc32(data), uncompressed_size=len(data))
        )  # fmt: skip
        offsets, indexes = {}, bytearray()
        for channel_id, entries in chunk.index.items():
            offsets[channel_id] = self._file.size + len(record) + len(indexes)
            indexes += _encoded_index(channel_id, entries)
        start = self._file.append(record + bytes(indexes))
        self._chunk = OpenChunk()
        self._chunks.append(
            ChunkIndex(chunk_start_offset=start, chunk_length=len(record), compression="zstd",
                       compressed_size=len(compressed), uncompressed_size=len(data), message_start_time=chunk.first,
                       message_end_time=chunk.last, message_index_length=len(indexes), message_index_offsets=offsets)
        )  # fmt: skip
        if chunk.count:
            self.first = min(self.first, chunk.first) if self.messages else chunk.first
            self.until = max(self.until, chunk.last)
            self.messages += chunk.count
            for channel_id, entries in chunk.index.items():
                self.counts[channel_id] += len(entries)

    def finish(self) -> None:
        """Write the end of the file and close it. A full disk raises OSError; what fits is in the file then.

        Where the summary does not fit, the file ends without one: readers then go through it from the front.
        """
        try:
            try:
                self.flush()
            finally:
                self._write_end()
        finally:
            self._file.close()

    def close(self) -> None:
        """Close the file as it is, if it is still open."""
        self._file.close()

    def _write_end(self) -> None:
        end = encoded(DataEnd(self._file.crc))
        try:
            self._file.append(end + self._summary(self._file.size + len(end)) + MAGIC)
        except OSError:
            self._write_short_end()
            raise

    def _write_short_end(self) -> None:
        """End the file without a summary; the last chunk's index gives its room where there is none."""
        footer = encoded(Footer(summary_start=0, summary_offset_start=0, summary_crc=0)) + MAGIC
        try:
            self._file.append(encoded(DataEnd(self._file.crc)) + footer)
        except OSError:
            if not self._chunks:
                raise
            end_of_chunk = self._chunks[-1].chunk_start_offset + self._chunks[-1].chunk_length
            if end_of_chunk + self._chunks[-1].message_index_length != self._file.size:
                raise  # an attachment or metadata follows the chunk
            self._file.shorten(end_of_chunk)
            self._file.append(encoded(DataEnd(self._file.crc)) + footer)

    def _summary(self, start: int) -> bytes:
        """The summary section, which starts at offset `start`, and the footer."""
        statistics = Statistics(
            attachment_count=len(self._attachments), channel_count=len(self._channels),
            channel_message_counts=dict(self.counts), chunk_count=len(self._chunks), message_count=self.messages,
            message_start_time=self.first, message_end_time=self.until, metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )  # fmt: skip
        groups: list[tuple[Opcode, list[McapRecord]]] = [
            (Opcode.SCHEMA, [*self._schemas]), (Opcode.CHANNEL, [*self._channels]),
            (Opcode.STATISTICS, [statistics]), (Opcode.CHUNK_INDEX, [*self._chunks]),
            (Opcode.ATTACHMENT_INDEX, [*self._attachments]), (Opcode.METADATA_INDEX, [*self._metadata]),
        ]  # fmt: skip
        out, offsets = bytearray(), bytearray()
        for opcode, records in groups:
            group = b"".join(encoded(record) for record in records)
            if group:
                offsets += encoded(
                    SummaryOffset(group_opcode=opcode, group_start=start + len(out), group_length=len(group))
                )
            out += group
        offset_start = start + len(out)
        out += offsets
        crc = zlib.crc32(struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start), zlib.crc32(out))
        return bytes(out) + encoded(Footer(summary_start=start, summary_offset_start=offset_start, summary_crc=crc))
