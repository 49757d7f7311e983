"""The messages of one chunk, or of a stretch without chunks, as columns; nothing larger than memory can bear."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
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

MAX_CHUNK_BYTES = 256 * 1024 * 1024  # bytes of a chunk that is opened: recorders write a few MB
COMPRESSIONS = ("", "zstd", "lz4")
_SIGNS = {b"\x28\xb5\x2f\xfd": "zstd", b"\x04\x22\x4d\x18": "lz4"}
_HEAD = struct.Struct("<BQ")
_FIXED = np.dtype([("channel", "<u2"), ("sequence", "<u4"), ("log_time", "<u8"), ("publish_time", "<u8")])
_LENGTH = np.dtype([("length", "<u8")])
_ZSTD = zstandard.ZstdDecompressor(max_window_size=MAX_CHUNK_BYTES)
# What the parsers beneath raise on bytes that are no record.
PARSE_ERRORS = (McapError, ValueError, struct.error, zstandard.ZstdError, RuntimeError, OverflowError)


class UnreadableChunk(Exception):
    """A chunk that cannot be opened: the message says why, in the words of a note."""


class UnknownCompression(UnreadableChunk):
    """One that is whole, but packed by a method that this program does not have."""


@dataclass(frozen=True)
class MessageBlock:
    """Messages as columns, each (n,): channel, sequence, log and publish time, ns; start, end: of their data."""

    data: bytes
    channel: NDArray[np.int64]
    sequence: NDArray[np.int64]
    log_time: NDArray[np.uint64]
    publish_time: NDArray[np.uint64]
    start: NDArray[np.int64]
    end: NDArray[np.int64]

    def select(self, chosen: NDArray[np.bool_]) -> MessageBlock:
        """Those messages alone."""
        return MessageBlock(
            self.data, self.channel[chosen], self.sequence[chosen], self.log_time[chosen], self.publish_time[chosen],
            self.start[chosen], self.end[chosen],
        )  # fmt: skip


@dataclass(frozen=True)
class ChunkContents:
    """What a chunk holds; places: where in its data the content of each message begins."""

    schemas: list[Schema]
    channels: list[Channel]
    data: bytes
    message_offsets: list[int]


@dataclass(frozen=True)
class ChunkHeader:
    """What a chunk says of itself; data: where its compressed bytes begin in its content."""

    first: int
    last: int
    size: int
    crc: int
    compression: str
    data: int


def chunk_header(content: bytes) -> ChunkHeader:
    """The beginning of a chunk's content. Raises Unreadable."""
    first, last, size, crc, name = struct.unpack_from("<QQQII", content)
    raw = content[32 : 32 + name]
    return ChunkHeader(first, last, size, crc, raw.decode("utf-8", "replace"), 40 + name)


def unpack_chunk(content: bytes) -> ChunkContents:
    """Unpack a chunk. Raises Unreadable where it is damaged or larger than LARGEST."""
    head = chunk_header(content)
    packed = memoryview(content)[head.data :]
    compression = head.compression if head.compression in COMPRESSIONS else _SIGNS.get(bytes(packed[:4]))
    size = _size(head, compression, packed)
    if size > MAX_CHUNK_BYTES:
        raise UnreadableChunk(
            f"of {size / 1e6:.0f} MB unpacked, more than the {MAX_CHUNK_BYTES / 1e6:.0f} MB that are opened"
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
    """Bytes that it will unpack to: as zstd's own head says, which the checksum then has to agree with, or the chunk's.

    Raises Unreadable where it is damaged.
    """
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
            # Not `decompress`: that allocates whatever size the packed bytes claim.
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
    """The records of an unpacked chunk. Raises one of DAMAGE where it is none."""
    schemas, channels, places = [], [], []
    at, size = 0, len(data)
    message = int(Opcode.MESSAGE)
    while at < size:
        opcode, length = _HEAD.unpack_from(data, at)
        at += 9
        if at + length > size:
            raise ValueError("a record runs beyond its chunk")
        if opcode == message:
            if length < _FIXED.itemsize:
                raise ValueError("a message shorter than its own head")
            places.append(at)
        elif opcode == Opcode.CHANNEL:
            channels.append(Channel.read(_stream(data, at, length)))
        elif opcode == Opcode.SCHEMA:
            schemas.append(Schema.read(_stream(data, at, length)))
        at += length
    return ChunkContents(schemas, channels, data, places)


def message_block(data: bytes, places: list[int]) -> MessageBlock:
    """The block of messages whose contents begin at these places of `data`, each behind its opcode and length."""
    place = np.array(places, dtype=np.int64)
    raw = np.frombuffer(data, dtype=np.uint8)
    length = _columns(raw, place - 8, _LENGTH)["length"].astype(np.int64)
    fixed = _columns(raw, place, _FIXED)
    return MessageBlock(
        data, fixed["channel"].astype(np.int64), fixed["sequence"].astype(np.int64), fixed["log_time"],
        fixed["publish_time"], place + _FIXED.itemsize, place + length,
    )  # fmt: skip


def _columns(raw: NDArray[np.uint8], place: NDArray[np.int64], kind: np.dtype[np.void]) -> NDArray[np.void]:
    """Structures of this kind at these places."""
    if not len(place):
        return np.empty(0, dtype=kind)
    return np.ascontiguousarray(sliding_window_view(raw, kind.itemsize)[place]).reshape(-1).view(kind)


def _stream(data: bytes, at: int, length: int) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(data[at : at + length]))


def iterate_messages(block: MessageBlock) -> Iterator[tuple[int, int, int, int, bytes]]:
    """Channel, sequence, log time, publish time and data of every message."""
    columns = (block.channel, block.sequence, block.log_time, block.publish_time, block.start, block.end)
    for channel, sequence, logged, published, start, end in zip(*(c.tolist() for c in columns), strict=True):
        yield channel, sequence, logged, published, block.data[start:end]
