"""The messages of one chunk, or of a part of a file without chunks, as columns; sizes are limited."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from slider_drilling.log.mcap_records import RECORD_HEAD

MAX_CHUNK_BYTES = 256 * 1024 * 1024  # unpacked; recorders write a few MB
COMPRESSIONS = ("", "zstd", "lz4")
_MAGIC_NUMBERS = {b"\x28\xb5\x2f\xfd": "zstd", b"\x04\x22\x4d\x18": "lz4"}
_FIXED = np.dtype([("channel", "<u2"), ("sequence", "<u4"), ("log_time", "<u8"), ("publish_time", "<u8")])
_LENGTH = np.dtype([("length", "<u8")])
_ZSTD = zstandard.ZstdDecompressor(max_window_size=MAX_CHUNK_BYTES)
# What the parsers raise on bytes that are no record.
PARSE_ERRORS = (McapError, ValueError, struct.error, zstandard.ZstdError, RuntimeError, OverflowError)


class UnreadableChunk(Exception):
    """A chunk that cannot be unpacked; the message is the reason, as notes print it."""


class UnknownCompression(UnreadableChunk):
    """A whole chunk, but compressed by a method that this program does not have."""


@dataclass(frozen=True)
class MessageBlock:
    """Messages as columns, each (n,).

    Attributes:
        data: Bytes that hold them.
        channel: Channel id of each.
        sequence: Sequence number.
        log_time: When it was recorded, ns.
        publish_time: When it was sent, ns.
        start: First byte of its content in `data`.
        end: Behind the last byte of its content.
    """

    data: bytes
    channel: NDArray[np.int64]
    sequence: NDArray[np.int64]
    log_time: NDArray[np.uint64]
    publish_time: NDArray[np.uint64]
    start: NDArray[np.int64]
    end: NDArray[np.int64]

    def select(self, chosen: NDArray[np.bool_]) -> MessageBlock:
        """The chosen messages; `chosen` has shape (n,)."""
        return MessageBlock(
            self.data, self.channel[chosen], self.sequence[chosen], self.log_time[chosen], self.publish_time[chosen],
            self.start[chosen], self.end[chosen],
        )  # fmt: skip


@dataclass(frozen=True)
class ChunkContents:
    """What a chunk holds.

    Attributes:
        schemas: Its schema records.
        channels: Its channel records.
        data: Its unpacked bytes.
        message_offsets: Where in `data` the content of each message record begins.
    """

    schemas: list[Schema]
    channels: list[Channel]
    data: bytes
    message_offsets: list[int]


@dataclass(frozen=True)
class ChunkHeader:
    """The header of a chunk.

    Attributes:
        first: Log time of its first message, ns.
        last: Log time of its last message, ns.
        size: Bytes when unpacked.
        crc: Checksum of the unpacked bytes; 0 for none.
        compression: Name of the method.
        data: Where the compressed bytes begin in the record's content.
        end: Where they end; padding may follow.
    """

    first: int
    last: int
    size: int
    crc: int
    compression: str
    data: int
    end: int


def chunk_header(content: bytes) -> ChunkHeader:
    """The header at the beginning of a chunk's content."""
    first, last, size, crc, name = struct.unpack_from("<QQQII", content)
    raw = content[32 : 32 + name]
    (packed,) = struct.unpack_from("<Q", content, 32 + name)
    return ChunkHeader(first, last, size, crc, raw.decode("utf-8", "replace"), 40 + name, 40 + name + packed)


def unpack_chunk(content: bytes) -> ChunkContents:
    """Unpack a chunk.

    Raises:
        UnreadableChunk: It is damaged, or larger than MAX_CHUNK_BYTES.
    """
    head = chunk_header(content)
    packed = memoryview(content)[head.data : head.end]
    compression = head.compression if head.compression in COMPRESSIONS else _MAGIC_NUMBERS.get(bytes(packed[:4]))
    size = _size(head, compression, packed)
    if size > MAX_CHUNK_BYTES:
        raise UnreadableChunk(
            f"of {size / 1e6:.0f} MB unpacked, over the limit of {MAX_CHUNK_BYTES / 1e6:.0f} MB,"
        )
    data = _unpacked(head, compression, size, packed)
    if head.crc and zlib.crc32(data) != head.crc:
        raise UnreadableChunk("damaged")
    if not head.crc and len(data) != head.size:
        raise UnreadableChunk("damaged")
    try:
        return _opened(data)
    except PARSE_ERRORS:
        raise UnreadableChunk("damaged") from None


def _size(head: ChunkHeader, compression: str | None, packed: memoryview) -> int:
    """Unpacked size: from the header of zstd where a checksum confirms it, else from the chunk's own header."""
    if compression == "zstd" and head.crc:
        try:
            size = zstandard.frame_content_size(packed)
        except zstandard.ZstdError:
            raise UnreadableChunk("damaged") from None
        if size >= 0:
            return int(size)
    return head.size


def _unpacked(head: ChunkHeader, compression: str | None, size: int, packed: memoryview) -> bytes:
    try:
        if compression == "zstd":
            # `decompress` would allocate whatever size the packed bytes claim.
            with _ZSTD.stream_reader(packed) as reader:
                return bytes(reader.read(size + 1))
        if compression == "lz4":
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size + 1))
    except (*PARSE_ERRORS, MemoryError):
        raise UnreadableChunk("damaged") from None
    if compression == "":
        return bytes(packed)
    raise UnknownCompression(f"compressed with {head.compression!r}")


def _opened(data: bytes) -> ChunkContents:
    """The records of an unpacked chunk. Raises one of PARSE_ERRORS where they are damaged."""
    schemas, channels, offsets = [], [], []
    at, size = 0, len(data)
    message = int(Opcode.MESSAGE)
    while at < size:
        opcode, length = RECORD_HEAD.unpack_from(data, at)
        at += 9
        if at + length > size:
            raise ValueError("a record runs beyond its chunk")
        if opcode == message:
            if length < _FIXED.itemsize:
                raise ValueError("a message record is too short")
            offsets.append(at)
        elif opcode == Opcode.CHANNEL:
            channels.append(Channel.read(_stream(data, at, length)))
        elif opcode == Opcode.SCHEMA:
            schemas.append(Schema.read(_stream(data, at, length)))
        at += length
    return ChunkContents(schemas, channels, data, offsets)


def message_block(data: bytes, offsets: list[int]) -> MessageBlock:
    """The block of messages whose contents begin at these offsets of `data`, each behind its opcode and length."""
    offset = np.array(offsets, dtype=np.int64)
    raw = np.frombuffer(data, dtype=np.uint8)
    length = _columns(raw, offset - 8, _LENGTH)["length"].astype(np.int64)
    fixed = _columns(raw, offset, _FIXED)
    return MessageBlock(
        data, fixed["channel"].astype(np.int64), fixed["sequence"].astype(np.int64), fixed["log_time"],
        fixed["publish_time"], offset + _FIXED.itemsize, offset + length,
    )  # fmt: skip


def block_of_rows(rows: Sequence[tuple[int, int, bytes]]) -> MessageBlock:
    """The block of messages given as channel, log time, ns, and data; they have no sequence numbers."""
    channel, time, data = zip(*rows, strict=True)
    end = np.cumsum([len(part) for part in data], dtype=np.int64)
    logged = np.array(time, dtype=np.int64).astype(np.uint64)
    return MessageBlock(
        b"".join(data), np.array(channel, dtype=np.int64), np.zeros(len(rows), dtype=np.int64), logged, logged,
        np.concatenate([[0], end[:-1]]), end,
    )  # fmt: skip


def _columns(raw: NDArray[np.uint8], offset: NDArray[np.int64], kind: np.dtype[np.void]) -> NDArray[np.void]:
    """Structures of this kind at these offsets."""
    if not len(offset):
        return np.empty(0, dtype=kind)
    return np.ascontiguousarray(sliding_window_view(raw, kind.itemsize)[offset]).reshape(-1).view(kind)


def _stream(data: bytes, at: int, length: int) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(data[at : at + length]))


def iterate_messages(block: MessageBlock) -> Iterator[tuple[int, int, int, int, bytes]]:
    """Channel, sequence, log time, publish time and data of every message."""
    columns = (block.channel, block.sequence, block.log_time, block.publish_time, block.start, block.end)
    for channel, sequence, logged, published, start, end in zip(*(c.tolist() for c in columns), strict=True):
        yield channel, sequence, logged, published, block.data[start:end]
