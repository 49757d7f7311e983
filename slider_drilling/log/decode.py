"""One message into one row of numbers, by its type's name and not by the schema text in the file."""

from __future__ import annotations

from collections.abc import Callable

from slider_drilling.messages import cdr
from slider_drilling.messages.topics import FLUID_PRESSURE, JOINT_STATE, Topic

NAN = float("nan")
# The stamp in ns, then what the series holds: position, velocity, effort, or value, variance, nothing.
Row = tuple[int, float, float, float]


def _pressure_row(data: bytes) -> Row:
    stamp, pressure, variance = cdr.read_fluid_pressure(data)
    # FluidPressure.msg: a variance of 0 means that it is unknown.
    return stamp, pressure, variance if variance > 0.0 else NAN, NAN


def _wrench_row(data: bytes) -> Row:
    stamp, force, _ = cdr.read_wrench_stamped(data)
    return stamp, force[0], NAN, NAN


def row_decoder(topic: Topic) -> Callable[[bytes], Row]:
    """A function from CDR bytes of the topic's message to its row; it raises InputError for what is none."""
    if topic.type == JOINT_STATE:
        return lambda data: cdr.read_joint_state(data, topic.joint)
    return _pressure_row if topic.type == FLUID_PRESSURE else _wrench_row
