"""MCAP files record by record, recovering what a damaged or unfinished one still holds."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from mcap.data_stream import RecordBuilder
from mcap.exceptions import EndOfFile, InvalidMagic, McapError
from mcap.records import Attachment, Channel, Chunk, Footer, McapRecord, Message, Metadata, Schema, Statistics
from mcap.stream_reader import StreamReader, breakup_chunk
from zstandard import ZstdError

from slider_drilling.errors import InputError

COMPRESSIONS = ("", "zstd", "lz4")
# What the mcap package raises on bytes that are no record: its own errors, and those of the parsers beneath it.
DAMAGE = (McapError, ValueError, struct.error, ZstdError, RuntimeError, MemoryError, OverflowError)


@dataclass
class Container:
    """What one MCAP file holds besides messages, filled while its messages are read."""

    path: Path
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    attachments: list[Attachment] = field(default_factory=list)
    metadata: list[Metadata] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def messages(self) -> Iterator[tuple[Channel, Message]]:
        """Every message in the order of the file. Raises InputError where the file is no MCAP file at all."""
        try:
            with self.path.open("rb") as file:
                count = 0
                for record in self._records(file):
                    if isinstance(record, Message):
                        count += 1
                        channel = self.channels.get(record.channel_id)
                        if channel is not None:
                            yield channel, record
                    elif isinstance(record, Statistics):
                        self._compare(count, record.message_count)
                    else:
                        self._keep(record)
        except FileNotFoundError:
            raise InputError(f"{self.path}: no such log; check the path") from None
        except OSError as error:
            raise InputError(f"{self.path}: cannot read this log: {error.strerror}") from None

    def _compare(self, found: int, counted: int) -> None:
        if found < counted:
            self.notes.append(f"holds {found} messages of the {counted} that its own summary counts")

    def _keep(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record
        elif isinstance(record, Attachment):
            self.attachments.append(record)
        elif isinstance(record, Metadata):
            self.metadata.append(record)

    def _records(self, file: IO[bytes]) -> Iterator[McapRecord]:
        """Records with chunks opened, up to the footer or to where the file breaks off."""
        size = self.path.stat().st_size
        if size == 0:
            raise InputError(f"{self.path}: is empty; expected an MCAP file")
        reader = StreamReader(file, emit_chunks=True, record_size_limit=size)
        closed = False
        try:
            for record in reader.records:
                if isinstance(record, Chunk):
                    yield from self._opened(record)
                elif isinstance(record, Attachment) and _damaged(record, file):
                    self.notes.append(f"attachment {record.name} is damaged and was left out")
                else:
                    yield record
                closed = closed or isinstance(record, Footer)
        except InvalidMagic:
            if not closed:
                raise InputError(
                    f"{self.path}: not an MCAP file; logs are MCAP, see `slider-drilling import`"
                ) from None
            self.notes.append("does not end as an MCAP file does; everything before its end was read")
        except EndOfFile:
            self._broken_off(file.tell(), size)
        except DAMAGE:
            if file.tell() <= 8:
                raise InputError(f"{self.path}: not an MCAP file: {size} bytes; check the path") from None
            self._broken_off(file.tell(), size)

    def _broken_off(self, position: int, size: int) -> None:
        self.notes.append(
            f"breaks off or is damaged at byte {position} of {size}; recovered up to the last complete chunk"
        )

    def _opened(self, chunk: Chunk) -> list[McapRecord]:
        if chunk.compression not in COMPRESSIONS:
            raise InputError(
                f"{self.path}: a chunk is compressed with {chunk.compression!r}; "
                "write it again with zstd, lz4 or no compression"
            )
        try:
            return breakup_chunk(chunk, validate_crc=True)
        except DAMAGE:
            span = (chunk.message_end_time - chunk.message_start_time) * 1e-9
            self.notes.append(f"a damaged chunk was left out: a gap of {span:.1f} s")
            return []


def _damaged(attachment: Attachment, file: IO[bytes]) -> bool:
    """Whether the checksum at the end of the attachment, which the file has just been read to, does not fit it."""
    file.seek(-4, 1)
    written = file.read(4)
    right = RecordBuilder()
    attachment.write(right)
    return written not in (b"\0\0\0\0", right.end()[-4:])
