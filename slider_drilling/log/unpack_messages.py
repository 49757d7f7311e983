"""Unpacks messages that were compressed one by one: `ros2 bag record --compression-mode message`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import zstandard
from numpy.lib.stride_tricks import sliding_window_view

from slider_drilling.log.mcap_chunk import MAX_CHUNK_BYTES, MessageBlock

# A zstd frame. CDR begins with a zero byte, and a ROS 1 header with a sequence number that will hardly be this one.
_ZSTD_MAGIC = np.frombuffer(b"\x28\xb5\x2f\xfd", dtype=np.uint8)


def unpack_messages(block: MessageBlock) -> MessageBlock:
    """The block with every compressed message unpacked; one that is damaged stays as it is, and is unreadable."""
    raw = np.frombuffer(block.data, dtype=np.uint8)
    long = np.flatnonzero(block.end - block.start > len(_ZSTD_MAGIC))
    if not len(long):
        return block
    # Most files hold none: look at the first bytes only, before those of every message.
    first = block.start[long[0]]
    if block.data[first] != _ZSTD_MAGIC[0] and not (raw[block.start[long]] == _ZSTD_MAGIC[0]).any():
        return block
    packed = np.zeros(len(block.start), dtype=np.bool_)
    packed[long] = (sliding_window_view(raw, len(_ZSTD_MAGIC))[block.start[long]] == _ZSTD_MAGIC).all(axis=1)
    if not packed.any():
        return block
    unpacker = zstandard.ZstdDecompressor(max_window_size=MAX_CHUNK_BYTES)
    parts = [
        _unpack(unpacker, block.data[start:end]) if is_packed else block.data[start:end]
        for start, end, is_packed in zip(block.start.tolist(), block.end.tolist(), packed.tolist(), strict=True)
    ]
    end = np.cumsum([len(part) for part in parts], dtype=np.int64)
    return replace(block, data=b"".join(parts), start=np.concatenate([[0], end[:-1]]), end=end)


def _unpack(unpacker: zstandard.ZstdDecompressor, data: bytes) -> bytes:
    try:
        size = zstandard.frame_content_size(data)
        # A frame without its size cannot be a recorder's, and one beyond the limit is no message.
        return unpacker.decompress(data) if 0 <= size <= MAX_CHUNK_BYTES else data
    except zstandard.ZstdError:
        return data
