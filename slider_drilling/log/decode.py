"""One message into one row of numbers, whichever way its schema was written down."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from mcap.exceptions import McapError
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from slider_drilling.log.schemas import SCHEMAS
from slider_drilling.log.topics import FLUID_PRESSURE, JOINT_STATE, WRENCH_STAMPED, Topic

NAN = float("nan")
# stamp in ns, then the values of the series in order
Row = tuple[int, float, float, float]
# What the decoder raises on bytes that are not its message.
UNREADABLE = (McapError, ValueError, struct.error, IndexError, OverflowError, MemoryError)


def stamp_ns(message: Any) -> int:
    """The header's stamp, ns."""
    stamp = message.header.stamp
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _element(values: Any, index: int) -> float:
    return float(values[index]) if index < len(values) else NAN


def _joint_row(message: Any, joint: str) -> Row:
    """Position, velocity and effort of the named joint, or of the only one.

    Raises ValueError for several joints none of which has the name.
    """
    names = list(message.name)
    if joint in names:
        index = names.index(joint)
    elif len(names) <= 1:
        index = 0
    else:
        raise ValueError(f"joints {names}, none named {joint!r}")
    return (
        stamp_ns(message),
        _element(message.position, index),
        _element(message.velocity, index),
        _element(message.effort, index),
    )


def _pressure_row(message: Any) -> Row:
    # FluidPressure.msg: a variance of 0 means that it is unknown.
    variance = float(message.variance)
    return stamp_ns(message), float(message.fluid_pressure), variance if variance > 0.0 else NAN, NAN


def _wrench_row(message: Any) -> Row:
    return stamp_ns(message), float(message.wrench.force.x), NAN, NAN


def row_decoder(topic: Topic) -> Callable[[bytes], Row]:
    """A function from CDR bytes of the topic's message to its row; it raises one of UNREADABLE."""
    schema = Schema(id=1, name=topic.type, encoding="ros2msg", data=SCHEMAS[topic.type].encode())
    decode = DecoderFactory().decoder_for("cdr", schema)
    if decode is None:
        raise AssertionError(f"mcap_ros2 cannot decode {topic.type}")
    read: Callable[[bytes], Any] = decode
    if topic.type == JOINT_STATE:
        return lambda data: _joint_row(read(data), topic.joint)
    if topic.type == FLUID_PRESSURE:
        return lambda data: _pressure_row(read(data))
    if topic.type == WRENCH_STAMPED:
        return lambda data: _wrench_row(read(data))
    raise AssertionError(f"{topic.type} is no series")
