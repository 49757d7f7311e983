"""The four message types of a log, and /clock, as CDR bytes: what DDS carries and an MCAP file holds.

Written by hand for two reasons. The generic encoders cost 20 to 50 us a message, most of a run at a hundred times real
time; and rclpy's leaves the padding between fields unset, so that equal messages differ in their bytes.

Encoding: CDR version 1 (OMG CORBA 3.0, section 15.3), little-endian; every value is aligned to its own size,
counted from behind the four bytes of the encapsulation header.
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Sequence

from slider_drilling.errors import InputError

NAN = float("nan")
_LITTLE = b"\x00\x01\x00\x00"
_NANO = 1_000_000_000
# header, sec, nanosec, frame_id: its length, its text, padding
FRAME_ID = "rig_floor"  # the frame of every reading of a rig: depths and lifts are counted from there
_FRAMES = (FRAME_ID, "")  # what the quick ways read; any other frame is read the long way


def _stamped(frame: str) -> str:
    """Layout of a header in this frame."""
    return f"<4siII{len(frame) + 1}s{-(len(frame) + 1) % 4}x"


@functools.cache
def _framed(frame: str) -> tuple[int, bytes]:
    return len(frame) + 1, frame.encode() + b"\x00"


_STAMPED, _FRAMED = _stamped(FRAME_ID), _framed(FRAME_ID)


def _padding(length: int, alignment: int) -> int:
    """Bytes to add to a message of this length (encapsulation included) before a value so aligned."""
    return -(length - 4) % alignment


@functools.cache
def _joint_layout(
    name: str, present: tuple[bool, ...], frame: str = FRAME_ID
) -> tuple[struct.Struct, bytes, tuple[int, ...]]:
    """Layout of a JointState of one joint that holds the quantities present: struct, name, counts."""
    text = name.encode() + b"\x00"
    layout = f"{_stamped(frame)}II{len(text)}s"
    layout += f"{_padding(struct.calcsize(layout), 4)}x"
    for there in present:
        layout += "I"
        if there:
            layout += f"{_padding(struct.calcsize(layout), 8)}xd"
    return struct.Struct(layout), text, tuple(int(there) for there in present)


def encode_joint_state(
    stamp_ns: int, name: str, position: float | None = None, velocity: float | None = None, effort: float | None = None
) -> bytes:
    """sensor_msgs/JointState of one joint; None leaves a quantity out."""
    layout, text, counts = _joint_layout(name, (position is not None, velocity is not None, effort is not None))
    sec, nanosec = divmod(stamp_ns, _NANO)
    values: list[float] = []
    for count, value in zip(counts, (position, velocity, effort), strict=True):
        values.append(count)
        if value is not None:
            values.append(value)
    return layout.pack(_LITTLE, sec, nanosec, *_FRAMED, 1, len(text), text, *values)


# What a rig's messages hold of position, velocity and effort; anything else is read the long way.
_PRESENT = ((True, True, True), (True, True, False), (False, True, False), (True, False, False))

_PRESSURE = struct.Struct(_STAMPED + "dd")
_PRESSURES = [(frame, struct.Struct(_stamped(frame) + "dd")) for frame in _FRAMES]
_WRENCH = struct.Struct(_STAMPED + "6d")
_CLOCK = struct.Struct("<4siI")


def encode_fluid_pressure(stamp_ns: int, pressure: float, variance: float) -> bytes:
    """sensor_msgs/FluidPressure, Pa and Pa2; a variance of 0 is an unknown one."""
    sec, nanosec = divmod(stamp_ns, _NANO)
    return _PRESSURE.pack(_LITTLE, sec, nanosec, *_FRAMED, pressure, variance)


def encode_wrench_stamped(stamp_ns: int, force: Sequence[float], torque: Sequence[float] = (0.0, 0.0, 0.0)) -> bytes:
    """geometry_msgs/WrenchStamped: a force (x, y, z), N, and a torque, N m."""
    sec, nanosec = divmod(stamp_ns, _NANO)
    return _WRENCH.pack(_LITTLE, sec, nanosec, *_FRAMED, *force, *torque)


def encode_clock(stamp_ns: int) -> bytes:
    """rosgraph_msgs/Clock."""
    return _CLOCK.pack(_LITTLE, *divmod(stamp_ns, _NANO))


def decode_clock(data: bytes) -> int:
    """The time, ns, of a rosgraph_msgs/Clock. Raises InputError where the bytes are none."""
    return header_stamp_ns(data)


def decode_string(data: bytes) -> str:
    """The text of a std_msgs/String. Raises InputError where the bytes are none."""
    try:
        return CdrReader(data).text()
    except struct.error:
        raise InputError(f"{len(data)} bytes that are no String") from None


def encode_diagnostic_array(
    stamp_ns: int, status: Sequence[tuple[int, str, str, str, Sequence[tuple[str, str]]]]
) -> bytes:
    """diagnostic_msgs/DiagnosticArray of (level, name, message, hardware_id, values) each."""
    out = bytearray(struct.pack(_STAMPED, _LITTLE, *divmod(stamp_ns, _NANO), *_FRAMED))
    _put_count(out, len(status))
    for level, name, message, hardware_id, values in status:
        out.append(level)
        for text in (name, message, hardware_id):
            _put_text(out, text)
        _put_count(out, len(values))
        for key, value in values:
            _put_text(out, key)
            _put_text(out, value)
    return bytes(out)


def _put_count(out: bytearray, count: int) -> None:
    out += b"\x00" * _padding(len(out), 4)
    out += struct.pack("<I", count)


def _put_text(out: bytearray, text: str) -> None:
    data = text.encode() + b"\x00"
    _put_count(out, len(data))
    out += data


class CdrReader:
    """Walks through one CDR message of either byte order. Raises struct.error where it breaks off.

    at: where the next value begins, before any padding; padding: (first, last) of what lay between values so far.
    """

    def __init__(self, data: bytes) -> None:
        if len(data) < 4 or data[0] != 0 or data[1] not in (0, 1):
            raise InputError(f"not a CDR message: it begins with {data[:4].hex() or 'nothing'}")
        self._data = data
        self.order = "<" if data[1] else ">"
        self.at = 4
        self.padding: list[tuple[int, int]] = []

    def align(self, size: int) -> None:
        """Go on to where a value of this size may begin."""
        gap = _padding(self.at, size)
        if gap:
            self.padding.append((self.at, self.at + gap))
            self.at += gap

    def take(self, code: str, size: int) -> int | float:
        self.align(size)
        (value,) = struct.unpack_from(self.order + code, self._data, self.at)
        self.at += size
        return value

    def count(self) -> int:
        return int(self.take("I", 4))

    def items(self, least: int) -> int:
        """The count of a sequence whose items have so many bytes at least: no more than the message can hold."""
        count = self.count()
        if count * least > len(self._data) - self.at:
            raise struct.error(f"a sequence of {count} items runs beyond the message")
        return count

    def text(self) -> str:
        length = self.count()
        if self.at + length > len(self._data):
            raise struct.error("text runs beyond the message")
        data = self._data[self.at : self.at + length]
        self.at += length
        return data.rstrip(b"\x00").decode("utf-8", "replace")

    def number(self) -> float:
        return float(self.take("d", 8))

    def skip_doubles(self) -> tuple[int, int]:
        """Go over a sequence of doubles: where the first is, and how many there are."""
        count = self.items(8)
        if count:
            self.align(8)
        first = self.at
        self.at += 8 * count
        if self.at > len(self._data):
            raise struct.error("numbers run beyond the message")
        return first, count

    def stamp(self) -> int:
        sec = int(self.take("i", 4))
        return sec * _NANO + int(self.take("I", 4))

    def doubles(self) -> tuple[float, ...]:
        first, count = self.skip_doubles()
        return struct.unpack_from(f"{self.order}{count}d", self._data, first)


def header_stamp_ns(data: bytes) -> int:
    """The stamp, ns, of any message that begins with a header. Raises InputError where it has none."""
    try:
        return CdrReader(data).stamp()
    except struct.error:
        raise InputError(f"a message of {len(data)} bytes is too short for a stamp") from None


def shift_header_stamp(data: bytes, shift_ns: int) -> bytes:
    """The same message, one that begins with a header, with its stamp shifted. Raises InputError where it has none."""
    order = "<" if data[1:2] == b"\x01" else ">"
    sec, nanosec = divmod(header_stamp_ns(data) + shift_ns, _NANO)
    return data[:4] + struct.pack(f"{order}iI", sec, nanosec) + data[12:]


def decode_joint_state(data: bytes, joint: str) -> tuple[int, float, float, float]:
    """Stamp ns, position, velocity, effort of the named joint, or of the only one; NaN where not given.

    Raises InputError where the bytes are no JointState or hold several joints of other names.
    """
    try:
        for frame in _FRAMES:
            for present in _PRESENT:
                layout, text, counts = _joint_layout(joint, present, frame)
                if len(data) != layout.size:
                    continue
                head, sec, nanosec, size, framed, names, length, name, *rest = layout.unpack(data)
                values = [rest.pop(1 + k) if there else NAN for k, there in enumerate(present)]
                expected = (_LITTLE, *_framed(frame), 1, len(text), text, *counts)
                if (head, size, framed, names, length, name, *rest) == expected:
                    return sec * _NANO + nanosec, values[0], values[1], values[2]
        return _read_any_joint_state(data, joint)
    except struct.error as error:
        raise InputError(f"{joint}: {len(data)} bytes that are no JointState: {error}") from None


def _read_any_joint_state(data: bytes, joint: str) -> tuple[int, float, float, float]:
    reader = CdrReader(data)
    stamp = reader.stamp()
    reader.text()
    names = [reader.text() for _ in range(reader.items(4))]
    if joint in names:
        index = names.index(joint)
    elif len(names) <= 1:
        index = 0
    else:
        raise InputError(f"joints {', '.join(names)}, none named {joint}")
    columns = [reader.doubles() for _ in range(3)]
    position, velocity, effort = (column[index] if index < len(column) else NAN for column in columns)
    return stamp, position, velocity, effort


def decode_fluid_pressure(data: bytes) -> tuple[int, float, float]:
    """Stamp ns, pressure Pa and variance Pa2. Raises InputError where the bytes are no FluidPressure."""
    try:
        for frame, layout in _PRESSURES:
            if len(data) == layout.size:
                head, sec, nanosec, size, framed, pressure, variance = layout.unpack(data)
                if (head, size, framed) == (_LITTLE, *_framed(frame)):
                    return sec * _NANO + nanosec, pressure, variance
        reader = CdrReader(data)
        stamp = reader.stamp()
        reader.text()
        return stamp, reader.number(), reader.number()
    except struct.error as error:
        raise InputError(f"{len(data)} bytes that are no FluidPressure: {error}") from None


def decode_wrench_stamped(data: bytes) -> tuple[int, tuple[float, ...], tuple[float, ...]]:
    """Stamp ns, force N and torque N m, each (x, y, z). Raises InputError where the bytes are no WrenchStamped."""
    try:
        reader = CdrReader(data)
        stamp = reader.stamp()
        reader.text()
        force, torque = (tuple(reader.number() for _ in range(3)) for _ in range(2))
        return stamp, force, torque
    except struct.error as error:
        raise InputError(f"{len(data)} bytes that are no WrenchStamped: {error}") from None
