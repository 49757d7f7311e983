"""Where in a message's bytes its stamp and its numbers are: many messages of one make are then read at once."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.messages.cdr import CdrReader
from slider_drilling.messages.topics import FLUID_PRESSURE, JOINT_STATE, Topic

NAN = float("nan")
_NANO = 1_000_000_000
Array = NDArray[np.float64]
Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class MessageLayout:
    """Places in every message that has the same `fixed` bytes: of its stamp, of its values (-1: not given).

    order: "<" or ">". fixed: which bytes make the layout, all but stamp, values and padding; like: a message of it.
    """

    order: str
    stamp: int
    values: tuple[int, ...]
    fixed: NDArray[np.bool_]
    like: Bytes

    def fits(self, rows: Bytes) -> NDArray[np.bool_]:
        """Which of the messages (n, length) have this layout."""
        return np.asarray((rows[:, self.fixed] == self.like[self.fixed]).all(axis=1))

    def read(self, rows: Bytes) -> tuple[NDArray[np.int64], Array]:
        """Stamps, ns, and values (n, len(values)) of messages that fit, NaN where one is not given."""
        sec = self._numbers(rows, self.stamp, "i4").astype(np.int64)
        nanosec = self._numbers(rows, self.stamp + 4, "u4").astype(np.int64)
        values = np.full((len(rows), len(self.values)), NAN)
        for column, at in enumerate(self.values):
            if at >= 0:
                values[:, column] = self._numbers(rows, at, "f8")
        return sec * _NANO + nanosec, values

    def _numbers(self, rows: Bytes, at: int, kind: str) -> NDArray[np.generic]:
        size = int(kind[1])
        return np.ascontiguousarray(rows[:, at : at + size]).view(self.order + kind).reshape(-1)


def message_layout(topic: Topic, data: bytes) -> MessageLayout:
    """The layout of a message of the topic. Raises InputError where the bytes are none of its type."""
    find = {JOINT_STATE: _joint_state, FLUID_PRESSURE: _fluid_pressure}.get(topic.type, _wrench)
    reader = CdrReader(data)
    stamp = 4
    try:
        reader.stamp()
        reader.text()
        values = find(reader, topic.joint)
    except struct.error as error:
        raise InputError(f"{len(data)} bytes that are no {topic.type.rpartition('/')[2]}: {error}") from None
    fixed = np.ones(len(data), dtype=np.bool_)
    fixed[stamp : stamp + 8] = False
    for at in values:
        if at >= 0:
            fixed[at : at + 8] = False
    for first, last in reader.padding:
        fixed[first:last] = False
    # What follows the last field is padding too.
    fixed[reader.at :] = False
    return MessageLayout(reader.order, stamp, values, fixed, np.frombuffer(data, dtype=np.uint8))


def _joint_state(reader: CdrReader, joint: str) -> tuple[int, ...]:
    names = [reader.text() for _ in range(reader.items(4))]
    if joint in names:
        index = names.index(joint)
    elif len(names) <= 1:
        index = 0
    else:
        raise InputError(f"joints {', '.join(names)}, none named {joint}")
    places = []
    for _ in range(3):
        first, count = reader.skip_doubles()
        places.append(first + 8 * index if index < count else -1)
    return tuple(places)


def _fluid_pressure(reader: CdrReader, joint: str) -> tuple[int, ...]:
    return _next_double(reader), _next_double(reader)


def _wrench(reader: CdrReader, joint: str) -> tuple[int, ...]:
    places = [_next_double(reader) for _ in range(6)]
    return (places[0],)


def _next_double(reader: CdrReader) -> int:
    reader.number()
    return reader.at - 8

