"""Message definitions of the standard types that a log holds, as the ros2msg text that MCAP files carry.

A standard type is the same in every ROS 2 distribution, so a log is decoded by its types' names: the schema text in
the file may be ros2msg, ros2idl or missing.
"""

from __future__ import annotations

from collections.abc import Mapping

from slider_drilling.messages.topics import DIAGNOSTIC_ARRAY, FLUID_PRESSURE, JOINT_STATE, WRENCH_STAMPED

_TIME = """\
# Seconds and nanoseconds of ROS time.
int32 sec
uint32 nanosec
"""
_HEADER = """\
# When the data was measured, and the frame it is in.
builtin_interfaces/Time stamp
string frame_id
"""
_JOINT_STATE = """\
# State of joints: rad or m, rad/s or m/s, N m or N. An empty array means that the quantity is not given.
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
"""
_FLUID_PRESSURE = """\
# Absolute pressure in Pa; a variance of 0 is an unknown variance.
std_msgs/Header header
float64 fluid_pressure
float64 variance
"""
_WRENCH_STAMPED = """\
# A force in N and a torque in N m.
std_msgs/Header header
geometry_msgs/Wrench wrench
"""
_WRENCH = """\
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
"""
_VECTOR3 = """\
float64 x
float64 y
float64 z
"""
_DIAGNOSTIC_ARRAY = """\
# Health of components.
std_msgs/Header header
diagnostic_msgs/DiagnosticStatus[] status
"""
_DIAGNOSTIC_STATUS = """\
byte OK=0
byte WARN=1
byte ERROR=2
byte STALE=3
byte level
string name
string message
string hardware_id
diagnostic_msgs/KeyValue[] values
"""
_KEY_VALUE = """\
string key
string value
"""


def join_definitions(own: str, parts: Mapping[str, str]) -> str:
    """A definition followed by those it uses (`package/Name` -> definition), separated as `ros2 bag` does."""
    separator = "=" * 80
    used = [f"{separator}\nMSG: {name}\n{text}" for name, text in parts.items()]
    return "\n".join([own, *used])


_STAMP = {"std_msgs/Header": _HEADER, "builtin_interfaces/Time": _TIME}

SCHEMAS = {
    JOINT_STATE: join_definitions(_JOINT_STATE, _STAMP),
    FLUID_PRESSURE: join_definitions(_FLUID_PRESSURE, _STAMP),
    WRENCH_STAMPED: join_definitions(
        _WRENCH_STAMPED, {**_STAMP, "geometry_msgs/Wrench": _WRENCH, "geometry_msgs/Vector3": _VECTOR3}
    ),
    DIAGNOSTIC_ARRAY: join_definitions(
        _DIAGNOSTIC_ARRAY,
        {**_STAMP, "diagnostic_msgs/DiagnosticStatus": _DIAGNOSTIC_STATUS, "diagnostic_msgs/KeyValue": _KEY_VALUE},
    ),
}
