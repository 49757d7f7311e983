"""ROS messages as CDR bytes, which DDS carries and an MCAP file holds; encoded from their descriptions.

Existing encoders are not used, for two reasons: they take 20 to 50 us a message, most of a run at a hundred times real
time; and rclpy's leaves the padding between fields unset, so that equal messages differ in their bytes.

Encoding: CDR version 1 (OMG CORBA 3.0, section 15.3), little-endian. Every value is aligned to its own size, counted
from behind the four bytes of the encapsulation header.
"""

from __future__ import annotations

import functools
import math
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.messages.decoder import LITTLE_ENDIAN, PRIMITIVES, Array, Integers, TopicDecoder
from slider_drilling.messages.message_reader import NANO, CdrReader, padding
from slider_drilling.messages.message_types import (
    DIAGNOSTIC_ARRAY,
    FIELDS,
    FLUID_PRESSURE,
    JOINT_STATE,
    MESSAGE_TYPES,
    WRENCH_STAMPED,
)
from slider_drilling.messages.topics import Topic

FRAME_ID = "rig_floor"  # the frame of every reading of a rig: depths and lifts are counted from there
_NUMBER = object()  # stands for a number that each message fills in
_HEADER = ((_NUMBER, _NUMBER), FRAME_ID)


class _Packer:
    """The `struct` format and the values of one message, field by field."""

    def __init__(self) -> None:
        self.format = "<4s"
        self.values: list[Any] = [LITTLE_ENDIAN]
        self.offsets: list[int] = []  # of the numbers that each message fills in
        self._size = 4

    def put(self, kind: str, value: Any) -> None:
        """Add a value of a type: a number, a text, or the values of a message's fields in order."""
        if kind == "string":
            text = value.encode() + b"\x00"
            self._put_primitive("I", 4, len(text))
            self._put_primitive(f"{len(text)}s", 1, text)
            self._size += len(text) - 1
        elif kind in PRIMITIVES:
            self._put_primitive(*PRIMITIVES[kind], value)
        else:
            for field, part in zip(FIELDS[kind], value, strict=True):
                if field.is_sequence:
                    self._put_primitive("I", 4, len(part))
                for element in part if field.is_sequence else (part,):
                    self.put(field.type, element)

    def _put_primitive(self, code: str, size: int, value: Any) -> None:
        gap = padding(self._size, size)
        self.format += f"{gap}x{code}" if gap else code
        if value is _NUMBER:
            self.offsets.append(self._size + gap)
        self.values.append(value)
        self._size += gap + size


class _Template:
    """Encodes the messages of one type that differ in their stamp and numbers only."""

    def __init__(self, kind: str, value: Any) -> None:
        packer = _Packer()
        packer.put(kind.replace("/msg/", "/"), value)
        self._pack = struct.Struct(packer.format).pack
        self._values = packer.values
        self._slots = [index for index, filled in enumerate(packer.values) if filled is _NUMBER][2:]
        self._offsets = packer.offsets

    def encode(self, stamp_ns: int, numbers: Sequence[float]) -> bytes:
        """The message with these numbers in the places left open, in order."""
        values = self._values.copy()
        values[1], values[2] = divmod(stamp_ns, NANO)
        for slot, number in zip(self._slots, numbers, strict=True):
            values[slot] = number
        return self._pack(*values)


    def encode_rows(self, stamps_ns: Integers, numbers: Array) -> list[bytes]:
        """A message for each row of numbers, (n, k), with the stamps (n,) in ns."""
        empty = np.frombuffer(self.encode(0, [0.0] * numbers.shape[1]), dtype=np.uint8)
        rows = np.tile(empty, (len(stamps_ns), 1))
        seconds, rest = np.divmod(stamps_ns, NANO)
        for offset, part in zip(self._offsets, (seconds.astype("<i4"), rest.astype("<u4")), strict=False):
            rows[:, offset : offset + 4] = np.ascontiguousarray(part).view(np.uint8).reshape(-1, 4)
        for offset, column in zip(self._offsets[2:], numbers.T, strict=True):
            rows[:, offset : offset + 8] = column.astype("<f8").view(np.uint8).reshape(-1, 8)
        text, size = rows.tobytes(), len(empty)
        return [text[start : start + size] for start in range(0, len(text), size)]


@functools.cache
def _number_template(kind: str, joint: str, given: tuple[bool, ...]) -> _Template:
    """The template of a type's messages that hold these of its logged numbers."""
    held = {logged.path: there for logged, there in zip(MESSAGE_TYPES[kind].logged, given, strict=True)}
    return _Template(kind, (_HEADER, *_open_fields(kind.replace("/msg/", "/"), "", held, joint)[1:]))


def _open_fields(kind: str, prefix: str, held: dict[str, bool], joint: str) -> list[Any]:
    """The values of a message's fields: `_NUMBER` where a number is held, none or 0 elsewhere."""
    values: list[Any] = []
    for field in FIELDS[kind]:
        path = prefix + field.name
        if field.type == "string":
            values.append([joint] if field.is_sequence else FRAME_ID)
        elif field.is_sequence:
            values.append([_NUMBER] if held.get(path) else [])
        elif field.type in PRIMITIVES:
            values.append(_NUMBER if path in held else 0)
        else:
            values.append(_open_fields(field.type, f"{path}.", held, joint))
    return values


def encode_numbers(topic: Topic, stamp_ns: int, numbers: Sequence[float]) -> bytes:
    """A message of a topic from the numbers that a log keeps of it.

    Args:
        topic: Of a type whose numbers a log keeps.
        stamp_ns: Time of the measurement, ns.
        numbers: One for each of the type's logged fields, SI; NaN for one that is not given.

    Raises:
        InputError: The topic's type is another one.
    """
    logged = topic.message_type().logged
    unknown = [math.isnan(number) for number in numbers]
    if topic.type == JOINT_STATE:
        # The arrays of a joint are sequences, which can be empty.
        template = _number_template(topic.type, topic.joint, tuple([not nan for nan in unknown]))
        return template.encode(stamp_ns, [number for number, nan in zip(numbers, unknown, strict=True) if not nan])
    template = _number_template(topic.type, topic.joint, (True,) * len(logged))
    return template.encode(
        stamp_ns,
        [
            0.0 if nan and part.zero_is_unknown else number
            for part, number, nan in zip(logged, numbers, unknown, strict=True)
        ],
    )


def encode_rows(topic: Topic, stamps_ns: Integers, numbers: Array) -> list[bytes]:
    """The messages that `encode_numbers` would give, of many rows at once.

    Args:
        topic: Of a type whose numbers a log keeps.
        stamps_ns: Times of the measurements, ns, (n,).
        numbers: SI, NaN where one is not given, (n, k).

    Raises:
        InputError: The topic's type is another one.
    """
    logged = topic.message_type().logged
    if topic.type != JOINT_STATE:
        unknown_is_zero = np.array([part.zero_is_unknown for part in logged])
        filled = np.where(np.isnan(numbers) & unknown_is_zero, 0.0, numbers)
        return _number_template(topic.type, topic.joint, (True,) * len(logged)).encode_rows(stamps_ns, filled)
    messages: list[bytes] = [b""] * len(stamps_ns)
    given = ~np.isnan(numbers)
    for held in np.unique(given, axis=0):
        rows = np.flatnonzero((given == held).all(axis=1))
        template = _number_template(topic.type, topic.joint, tuple(held.tolist()))
        encoded = template.encode_rows(stamps_ns[rows], numbers[rows][:, held])
        for row, message in zip(rows.tolist(), encoded, strict=True):
            messages[row] = message
    return messages


def encode_joint_state(
    stamp_ns: int, name: str, position: float | None = None, velocity: float | None = None, effort: float | None = None
) -> bytes:
    """sensor_msgs/JointState of one joint; None leaves a quantity out."""
    given = (position is not None, velocity is not None, effort is not None)
    template = _number_template(JOINT_STATE, name, given)
    return template.encode(stamp_ns, [number for number in (position, velocity, effort) if number is not None])


def encode_joint_states(
    stamp_ns: int, names: Sequence[str], positions: Sequence[float], velocities: Sequence[float]
) -> bytes:
    """sensor_msgs/JointState of several joints; NaN for a number that is not given."""
    packer = _Packer()
    header = (divmod(stamp_ns, NANO), FRAME_ID)
    packer.put(JOINT_STATE.replace("/msg/", "/"), (header, names, positions, velocities, ()))
    return struct.pack(packer.format, *packer.values)


_PRESSURE = _number_template(FLUID_PRESSURE, "", (True, True))
_WRENCH = _Template(WRENCH_STAMPED, (_HEADER, ((_NUMBER,) * 3, (_NUMBER,) * 3)))
_CLOCK = struct.Struct("<4siI")


def encode_fluid_pressure(stamp_ns: int, pressure: float, variance: float) -> bytes:
    """sensor_msgs/FluidPressure, Pa and Pa2; a variance of 0 is an unknown one."""
    return _PRESSURE.encode(stamp_ns, (pressure, variance))


def encode_wrench_stamped(
    stamp_ns: int, force: Sequence[float], torque: Sequence[float] = (0.0, 0.0, 0.0)
) -> bytes:
    """geometry_msgs/WrenchStamped: a force (x, y, z), N, and a torque, N m."""
    return _WRENCH.encode(stamp_ns, (*force, *torque))


def encode_diagnostic_array(
    stamp_ns: int, status: Sequence[tuple[int, str, str, str, Sequence[tuple[str, str]]]]
) -> bytes:
    """diagnostic_msgs/DiagnosticArray of (level, name, message, hardware_id, values) each."""
    packer = _Packer()
    packer.put(DIAGNOSTIC_ARRAY.replace("/msg/", "/"), ((divmod(stamp_ns, NANO), FRAME_ID), status))
    return struct.pack(packer.format, *packer.values)


def encode_clock(stamp_ns: int) -> bytes:
    """rosgraph_msgs/Clock."""
    return _CLOCK.pack(LITTLE_ENDIAN, *divmod(stamp_ns, NANO))


def decode_clock(data: bytes) -> int:
    """The time of a rosgraph_msgs/Clock, ns. Raises InputError where the bytes are no such message."""
    return header_stamp_ns(data)


def decode_string(data: bytes) -> str:
    """The text of a std_msgs/String. Raises InputError where the bytes are no such message."""
    try:
        return CdrReader(data).text()
    except struct.error as error:
        raise InputError(f"no String in a message of {len(data)} bytes: {error}") from None


@functools.lru_cache(maxsize=64)
def _decoder(kind: str, joint: str) -> TopicDecoder:
    return TopicDecoder(Topic(joint or kind, kind, joint))


def decode_joint_state(data: bytes, joint: str) -> tuple[int, float, float, float]:
    """Stamp ns, position, velocity and effort of the named joint, or of the only one; NaN where not given.

    Raises:
        InputError: The bytes are no JointState, or hold several joints and none of this name.
    """
    stamp, (position, velocity, effort) = _decoder(JOINT_STATE, joint).decode_one(data)
    return stamp, position, velocity, effort


def header_stamp_ns(data: bytes) -> int:
    """The stamp, ns, of any message that begins with a header. Raises InputError where it has none."""
    try:
        return CdrReader(data).stamp()
    except struct.error:
        raise InputError(f"no stamp in a message of {len(data)} bytes: too short") from None


def shift_header_stamp(data: bytes, shift_ns: int) -> bytes:
    """The same message with the stamp of its header shifted. Raises InputError where it has none."""
    order = "<" if data[1:2] == b"\x01" else ">"
    sec, nanosec = divmod(header_stamp_ns(data) + shift_ns, NANO)
    return data[:4] + struct.pack(f"{order}iI", sec, nanosec) + data[12:]
