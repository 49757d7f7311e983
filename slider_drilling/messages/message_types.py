"""The message types of a rig's topics: one description each, from which messages are encoded, decoded and declared.

A standard type is the same in every ROS 2 distribution, so a log is decoded by its types' names: the schema text in
the file may be ros2msg, ros2idl or missing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from slider_drilling.errors import InputError

JOINT_STATE = "sensor_msgs/msg/JointState"
FLUID_PRESSURE = "sensor_msgs/msg/FluidPressure"
WRENCH_STAMPED = "geometry_msgs/msg/WrenchStamped"
DIAGNOSTIC_ARRAY = "diagnostic_msgs/msg/DiagnosticArray"
STRING = "std_msgs/msg/String"

# The ros2msg text of each type, by its name without "msg".
_DEFINITIONS = {
    "builtin_interfaces/Time": """\
# Seconds and nanoseconds of ROS time.
int32 sec
uint32 nanosec
""",
    "std_msgs/Header": """\
# When the data was measured, and the frame it is in.
builtin_interfaces/Time stamp
string frame_id
""",
    "sensor_msgs/JointState": """\
# State of joints: rad or m, rad/s or m/s, N m or N. An empty array means that the quantity is not given.
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
""",
    "sensor_msgs/FluidPressure": """\
# Absolute pressure in Pa; a variance of 0 is an unknown variance.
std_msgs/Header header
float64 fluid_pressure
float64 variance
""",
    "geometry_msgs/WrenchStamped": """\
# A force in N and a torque in N m.
std_msgs/Header header
geometry_msgs/Wrench wrench
""",
    "geometry_msgs/Wrench": """\
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
""",
    "geometry_msgs/Vector3": """\
float64 x
float64 y
float64 z
""",
    "diagnostic_msgs/DiagnosticArray": """\
# Health of components.
std_msgs/Header header
diagnostic_msgs/DiagnosticStatus[] status
""",
    "diagnostic_msgs/DiagnosticStatus": """\
byte OK=0
byte WARN=1
byte ERROR=2
byte STALE=3
byte level
string name
string message
string hardware_id
diagnostic_msgs/KeyValue[] values
""",
    "diagnostic_msgs/KeyValue": """\
string key
string value
""",
}


class MessageField(NamedTuple):
    """One field of a definition; `type` is that of the elements where the field is a sequence."""

    name: str
    type: str
    is_sequence: bool


class LoggedField(NamedTuple):
    """A number of a message that a log keeps.

    Attributes:
        path: Its field, such as ``wrench.force.x``. Of a sequence the element of the topic's joint is kept.
        array: The array of the series in memory that it goes to.
        zero_is_unknown: Whether 0 means that the number is not known.
    """

    path: str
    array: str
    zero_is_unknown: bool = False


@dataclass(frozen=True)
class MessageType:
    """One message type.

    Attributes:
        name: ``package/msg/Name``.
        definition: Its ros2msg text with those of the types that it uses, as an MCAP file carries it.
        logged: The numbers that a log keeps; none for a type that is recorded but not read back.
    """

    name: str
    definition: str
    logged: tuple[LoggedField, ...] = ()

    @property
    def short_name(self) -> str:
        """The name without its package: ``JointState``."""
        return self.name.rpartition("/")[2]


def _parse_fields(definition: str) -> tuple[MessageField, ...]:
    """The fields of a ros2msg definition; comments and constants are left out."""
    lines = [line.split() for line in definition.splitlines() if line and "=" not in line and not line.startswith("#")]
    return tuple(MessageField(name, kind.removesuffix("[]"), kind.endswith("[]")) for kind, name in lines)


FIELDS: dict[str, tuple[MessageField, ...]] = {name: _parse_fields(text) for name, text in _DEFINITIONS.items()}


def join_definitions(own: str, used: Mapping[str, str]) -> str:
    """A definition followed by those it uses, separated as `ros2 bag` does.

    Args:
        own: The ros2msg text of the type itself.
        used: ``package/Name`` and ros2msg text of each type that it uses.
    """
    separator = "=" * 80
    return "\n".join([own, *(f"{separator}\nMSG: {name}\n{text}" for name, text in used.items())])


def _message_type(name: str, used: tuple[str, ...], *logged: LoggedField) -> MessageType:
    own = _DEFINITIONS[name.replace("/msg/", "/")]
    used = ("std_msgs/Header", "builtin_interfaces/Time", *used)
    return MessageType(name, join_definitions(own, {other: _DEFINITIONS[other] for other in used}), logged)


MESSAGE_TYPES: dict[str, MessageType] = {
    described.name: described
    for described in (
        _message_type(
            JOINT_STATE,
            (),
            LoggedField("position", "position"),
            LoggedField("velocity", "velocity"),
            LoggedField("effort", "effort"),
        ),
        _message_type(
            FLUID_PRESSURE,
            (),
            LoggedField("fluid_pressure", "value"),
            LoggedField("variance", "variance", zero_is_unknown=True),
        ),
        _message_type(
            WRENCH_STAMPED,
            ("geometry_msgs/Wrench", "geometry_msgs/Vector3"),
            LoggedField("wrench.force.x", "value"),
        ),
        _message_type(DIAGNOSTIC_ARRAY, ("diagnostic_msgs/DiagnosticStatus", "diagnostic_msgs/KeyValue")),
    )
}


def logged_type(name: str, topic: str) -> MessageType:
    """The description of a type whose numbers a log keeps.

    Raises:
        InputError: The type is none of these; the message names it and the topic.
    """
    described = MESSAGE_TYPES.get(name)
    if described is None or not described.logged:
        known = ", ".join(described.name for described in MESSAGE_TYPES.values() if described.logged)
        raise InputError(f"{topic}: message type {name} has no numbers that a log keeps; use one of {known}")
    return described
