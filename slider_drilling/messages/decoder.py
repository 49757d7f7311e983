"""Stamp and numbers of CDR and ROS 1 messages, one message or many at a time, by the descriptions of their types.

Where a message's numbers stand depends on its frame, its joints and its array lengths, which are the same in most
messages of a topic. So a message is walked through once; the layout found then reads all messages that share it.
"""

from __future__ import annotations

import operator
import struct
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.messages.message_reader import NANO, CdrReader, Ros1Reader
from slider_drilling.messages.message_types import FIELDS
from slider_drilling.messages.topics import TOPICS, Topic

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Mask = NDArray[np.bool_]

NAN = float("nan")
LITTLE_ENDIAN = b"\x00\x01\x00\x00"  # encapsulation header
PRIMITIVES = {"byte": ("B", 1), "int32": ("i", 4), "uint32": ("I", 4), "float64": ("d", 8)}
ENCODINGS = ("cdr", "ros1")  # that are decoded
# Where the stamp of a header begins: behind the encapsulation header of CDR, behind the sequence number in ROS 1.
_STAMP = 4
_JOINTS = frozenset(topic.joint for topic in TOPICS.values() if topic.joint)
# A recorder writes one layout a topic, or a few; what fits none of so many a length is read a message at a time.
_MAX_LAYOUTS = 8
_MAX_LENGTHS = 256


@dataclass(frozen=True)
class DecodedMessages:
    """What was read of n messages, m of them readable.

    Attributes:
        readable: Which of them are readable, (n,).
        stamp: ns, (m,).
        values: The logged numbers, (m, fields); NaN where one is not given or unknown.
        layout: Number of each message's layout, (m,): the same for messages whose texts and array lengths are the same.
    """

    readable: Mask
    stamp: Integers
    values: Array
    layout: Integers


@dataclass
class _FieldPlaces:
    """Where a message's fields are, by their paths: (first byte, count) of numbers, texts of string sequences."""

    numbers: dict[str, tuple[int, int]] = field(default_factory=dict)
    texts: dict[str, list[str]] = field(default_factory=dict)

    def find(self, reader: CdrReader, kind: str, prefix: str = "") -> None:
        """Walk through the fields of a type. Raises struct.error where the message breaks off."""
        if kind == "std_msgs/Header":
            reader.begin_header()
        for part in FIELDS[kind]:
            path = prefix + part.name
            if part.type in PRIMITIVES:
                size = PRIMITIVES[part.type][1]
                count = reader.count(size) if part.is_sequence else 1
                self.numbers[path] = (reader.skip(size, count), count)
            elif part.type == "string":
                self.texts[path] = [reader.text() for _ in range(reader.count(4) if part.is_sequence else 1)]
            else:
                for _ in range(reader.count(1) if part.is_sequence else 1):
                    self.find(reader, part.type, f"{path}.")


class MessageLayout:
    """Where stamp and numbers are in every message that shares its fixed bytes: all but stamp, numbers and padding.

    Attributes:
        values: First byte of each logged number; -1 for one that is not given.
        number: Of the layout, in the order in which a decoder met them.
        left_out: Which arrays are not read, and why; empty where all are.
    """

    def __init__(
        self, reader: CdrReader, data: bytes, places: _FieldPlaces, values: tuple[int, ...], number: int,
        left_out: str = "",
    ) -> None:  # fmt: skip
        self.values = values
        self.number = number
        self.left_out = left_out
        self._order = reader.order
        fixed = np.ones(len(data), dtype=np.bool_)
        fixed[_STAMP : _STAMP + 8] = False
        for first, count in places.numbers.values():
            fixed[first : first + 8 * count] = False
        for first, last in reader.gaps:
            fixed[first:last] = False
        fixed[reader.at :] = False  # what follows the last field is padding too
        self._fixed = fixed
        self._fixed_bytes = np.frombuffer(data, dtype=np.uint8)[fixed]
        self._prepare_single(data)

    def _prepare_single(self, data: bytes) -> None:
        """The `struct` that takes one message apart into its fixed parts, its stamp and its numbers."""
        form, parts, at = self._order, list[int](), 0
        while at < len(data):
            if at == _STAMP:
                form, parts, size = f"{form}iI", [*parts, _STAMP, _STAMP + 4], 8
            elif at in self.values:
                form, parts, size = f"{form}d", [*parts, at], 8
            elif self._fixed[at]:
                run = self._fixed[at:_STAMP] if at < _STAMP else self._fixed[at:]
                size = len(run) if run.all() else int(run.argmin())
                form, parts = f"{form}{size}s", [*parts, at]
            else:
                form, size = f"{form}x", 1
            at += size
        self._struct = struct.Struct(form)
        chosen = [k for k, at in enumerate(parts) if self._fixed[at]]
        self._take_fixed = operator.itemgetter(*chosen)
        self._numbers = tuple(parts.index(at) if at >= 0 else -1 for at in self.values)
        self._expected = self._take_fixed(self._struct.unpack(data))

    def read_one(self, data: bytes) -> tuple[int, tuple[float, ...]] | None:
        """Stamp, ns, and numbers of a message of the same length; None where it has another layout."""
        parts: tuple[Any, ...] = self._struct.unpack(data)
        if self._take_fixed(parts) != self._expected:
            return None
        return parts[1] * NANO + parts[2], tuple([parts[k] if k >= 0 else NAN for k in self._numbers])

    def fits(self, rows: Bytes) -> Mask:
        """Which of the messages (n, length) have this layout."""
        return np.asarray((rows[:, self._fixed] == self._fixed_bytes).all(axis=1))

    def read(self, rows: Bytes) -> tuple[Integers, Array]:
        """Stamps, ns, and numbers (n, len(values)) of messages that fit; NaN where one is not given."""
        sec = self._column(rows, _STAMP, "i4").astype(np.int64)
        nanosec = self._column(rows, _STAMP + 4, "u4").astype(np.int64)
        values = np.full((len(rows), len(self.values)), NAN)
        for column, at in enumerate(self.values):
            if at >= 0:
                values[:, column] = self._column(rows, at, "f8")
        return sec * NANO + nanosec, values

    def _column(self, rows: Bytes, at: int, kind: str) -> NDArray[np.generic]:
        size = int(kind[1])
        return np.ascontiguousarray(rows[:, at : at + size]).view(self._order + kind).reshape(-1)


def header_stamps(data: bytes, start: Integers, end: Integers, encoding: str) -> tuple[Mask, Integers]:
    """Stamps of messages of any types that begin with a header.

    Args:
        data: Bytes that hold them.
        start: First byte of each message, (n,).
        end: Behind the last byte of each, (n,).
        encoding: One of ENCODINGS.

    Returns:
        Which of them are long enough, (n,), and the stamps of those, ns, (m,).
    """
    stamped = end - start >= _STAMP + 8
    if not stamped.any():
        return stamped, np.empty(0, dtype=np.int64)
    rows = sliding_window_view(np.frombuffer(data, dtype=np.uint8), _STAMP + 8)[start[stamped]]
    times = np.ascontiguousarray(rows[:, _STAMP:])
    little, big = (times.view(np.dtype([("sec", f"{order}i4"), ("nanosec", f"{order}u4")]))[:, 0] for order in "<>")
    is_big = np.zeros(len(rows), dtype=np.bool_) if encoding == "ros1" else rows[:, 1] == 0
    sec, nanosec = (np.where(is_big, big[name], little[name]).astype(np.int64) for name in ("sec", "nanosec"))
    return stamped, sec * NANO + nanosec


class TopicDecoder:
    """Reads the messages of one topic.

    Args:
        topic: Its entry in the registry.
        joint: Name or index of its joint in a JointState; the registry's name if not given.
        encoding: One of ENCODINGS.

    Attributes:
        unreadable: Number of messages that could not be read, by the reason.
        left_out: Number of messages of which an array could not be read, by the reason.

    Raises:
        InputError: The topic's type is not one whose numbers a log keeps.
    """

    def __init__(self, topic: Topic, joint: str | int | None = None, encoding: str = "cdr") -> None:
        self._joint = topic.joint if joint is None else joint
        self._is_given = joint is not None
        self._reader = Ros1Reader if encoding == "ros1" else CdrReader
        self._type = topic.message_type()
        self._layouts: dict[int, list[MessageLayout]] = {}
        self._count = 0
        self.unreadable: Counter[str] = Counter()
        self.left_out: Counter[str] = Counter()

    def decode_one(self, data: bytes) -> tuple[int, tuple[float, ...]]:
        """Stamp, ns, and logged numbers of a message, NaN where not given. Raises InputError where it is unreadable."""
        for layout in self._layouts.get(len(data), ()):
            read = layout.read_one(data)
            if read is not None:
                return read
        layout, _ = self._learn(data)
        read = layout.read_one(data)
        assert read is not None  # the layout is this message's own
        return read

    def decode(self, data: bytes, start: Integers, end: Integers) -> DecodedMessages:
        """Read many messages.

        Args:
            data: Bytes that hold them.
            start: First byte of each message, (n,).
            end: Behind the last byte of each, (n,).
        """
        raw = np.frombuffer(data, dtype=np.uint8)
        readable = np.zeros(len(start), dtype=np.bool_)
        stamp = np.zeros(len(start), dtype=np.int64)
        values = np.full((len(start), len(self._type.logged)), NAN)
        numbers = np.zeros(len(start), dtype=np.int64)

        def fill(layout: MessageLayout, left: Integers, rows: Bytes) -> tuple[Integers, Bytes]:
            """Read the rows that have the layout; what is left."""
            fits = layout.fits(rows)
            at = left[fits]
            stamp[at], values[at] = layout.read(rows[fits])
            readable[at] = True
            numbers[at] = layout.number
            if layout.left_out:
                self.left_out[layout.left_out] += len(at)
            return left[~fits], rows[~fits]

        lengths = end - start
        for length in np.unique(lengths).tolist():
            left = np.flatnonzero(lengths == length)
            rows = sliding_window_view(raw, length)[start[left]]
            for known in self._layouts.get(length, ()):
                left, rows = fill(known, left, rows)
            while len(left):
                layout, is_kept = self._try_learn(rows[0].tobytes())
                if layout is not None and is_kept:
                    left, rows = fill(layout, left, rows)
                    continue
                if layout is not None:
                    fill(layout, left[:1], rows[:1])
                left, rows = left[1:], rows[1:]
        for column, logged in enumerate(self._type.logged):
            if logged.zero_is_unknown:
                values[~(values[:, column] > 0.0), column] = NAN
        return DecodedMessages(readable, stamp[readable], values[readable], numbers[readable])

    def _try_learn(self, data: bytes) -> tuple[MessageLayout | None, bool]:
        """As `_learn`; None, and counted, where the message is unreadable."""
        try:
            return self._learn(data)
        except InputError as error:
            self.unreadable[str(error)] += 1
            return None, False

    def _learn(self, data: bytes) -> tuple[MessageLayout, bool]:
        """The layout of a message that fits none that is known, and whether it is kept. Raises InputError."""
        places = _FieldPlaces()
        try:
            reader = self._reader(data)
            places.find(reader, self._type.name.replace("/msg/", "/"))
            values = self._value_places(places)
        except struct.error as error:
            raise InputError(f"no {self._type.short_name} in a message of {len(data)} bytes: {error}") from None
        self._count += 1
        layout = MessageLayout(reader, data, places, values, self._count, self._left_out(places))
        if len(self._layouts) >= _MAX_LENGTHS:
            self._layouts.clear()
        known = self._layouts.setdefault(len(data), [])
        if len(known) >= _MAX_LAYOUTS:
            layout.number = 0
            return layout, False
        known.append(layout)
        return layout, True

    def _value_places(self, places: _FieldPlaces) -> tuple[int, ...]:
        """First byte of each logged number, -1 for one that is not given. Raises InputError for another joint."""
        found: Sequence[tuple[int, int]] = [places.numbers[logged.path] for logged in self._type.logged]
        if "name" not in places.texts:
            return tuple(first if count else -1 for first, count in found)
        names, counts = places.texts["name"], {count for _, count in found if count}
        joints = len(names) or max(counts, default=0)
        index = self._joint_index(names, joints)
        if counts and joints not in counts:
            lengths = " and ".join(map(str, sorted(counts)))
            raise InputError(f"{joints} joint names ({', '.join(names)}) for {lengths} values")
        # In an array of another length it is not known which value is whose.
        return tuple(first + 8 * index if 0 < count == joints else -1 for first, count in found)

    def _left_out(self, places: _FieldPlaces) -> str:
        """Arrays of a joint message that have another length than its others, and so cannot be read."""
        if "name" not in places.texts:
            return ""
        counts = {logged.path: places.numbers[logged.path][1] for logged in self._type.logged}
        joints = len(places.texts["name"]) or max(counts.values(), default=0)
        wrong = [f"{count} values of {path}" for path, count in counts.items() if count not in (0, joints)]
        return f"{' and '.join(wrong)} for {joints} joints, of which each needs one: left out" if wrong else ""

    def _joint_index(self, names: list[str], joints: int) -> int:
        """Which joint of a message is the topic's. Raises InputError where that is unknown.

        Args:
            names: Of the joints; may be empty.
            joints: Number of joints.
        """
        wanted = self._joint
        if isinstance(wanted, int):
            if not 0 <= wanted < joints:
                raise InputError(f"{joints} joints, none with index {wanted}")
            return wanted
        if names.count(wanted) == 1:
            return names.index(wanted)
        if not names and (joints > 1 or self._is_given):
            raise InputError(f"{joints} joints without names: which is {wanted} is unknown")
        if len(names) > 1:
            several = "several" if wanted in names else "none"
            raise InputError(f"joints {', '.join(names)}, {several} named {wanted}")
        if names and (self._is_given or names[0] in _JOINTS):
            raise InputError(f"joint {names[0]}, not {wanted}")
        return 0
