"""Readers of one message, value by value: CDR of either byte order, and ROS 1."""

from __future__ import annotations

import struct

from slider_drilling.errors import InputError

NANO = 1_000_000_000


def padding(length: int, alignment: int) -> int:
    """Bytes to add to a message of this length (encapsulation included) before a value so aligned."""
    return -(length - 4) % alignment


class CdrReader:
    """Reads one CDR message of either byte order, value by value; struct.error is raised where it breaks off.

    Attributes:
        order: "<" or ">".
        at: Where the next value begins, before any padding.
        gaps: (first, last) of the bytes so far that mean nothing.
    """

    def __init__(self, data: bytes) -> None:
        if len(data) < 4 or data[0] != 0 or data[1] not in (0, 1):
            raise InputError(f"not a CDR message: it begins with {data[:4].hex() or 'nothing'}")
        self._data = data
        self.order = "<" if data[1] else ">"
        self.at = 4
        self.gaps: list[tuple[int, int]] = []

    def skip(self, size: int, count: int = 1) -> int:
        """Go over values of this size; where the first one is."""
        if count:
            gap = self._padding(size)
            if gap:
                self.gaps.append((self.at, self.at + gap))
                self.at += gap
        first = self.at
        if first + size * count > len(self._data):
            raise struct.error("it breaks off")
        self.at += size * count
        return first

    def _padding(self, size: int) -> int:
        """Bytes before a value of this size."""
        return padding(self.at, size)

    def begin_header(self) -> None:
        """Go over what stands before the fields of a header."""

    def count(self, min_size: int) -> int:
        """The length of a sequence whose elements have at least so many bytes: no more than the message can hold."""
        (count,) = struct.unpack_from(f"{self.order}I", self._data, self.skip(4))
        if count * min_size > len(self._data) - self.at:
            raise struct.error(f"a sequence of {count} elements runs beyond its end")
        return int(count)

    def text(self) -> str:
        """A string."""
        length = self.count(1)
        first = self.skip(1, length)
        return self._data[first : first + length].rstrip(b"\x00").decode("utf-8", "replace")

    def stamp(self) -> int:
        """A time, ns."""
        sec, nanosec = struct.unpack_from(f"{self.order}iI", self._data, self.skip(4, 2))
        return int(sec) * NANO + int(nanosec)


class Ros1Reader(CdrReader):
    """Reads one message of ROS 1: little-endian, without padding, with a sequence number before the header's fields."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self.order = "<"
        self.at = 0
        self.gaps = []

    def _padding(self, size: int) -> int:
        return 0

    def begin_header(self) -> None:
        """Go over the sequence number."""
        first = self.skip(4)
        self.gaps.append((first, first + 4))
