"""The topics of a rig and what each holds: one table for reading and writing, live and recorded."""

from __future__ import annotations

from dataclasses import dataclass

JOINT_STATE = "sensor_msgs/msg/JointState"
FLUID_PRESSURE = "sensor_msgs/msg/FluidPressure"
WRENCH_STAMPED = "geometry_msgs/msg/WrenchStamped"
DIAGNOSTIC_ARRAY = "diagnostic_msgs/msg/DiagnosticArray"


@dataclass(frozen=True)
class Topic:
    """One topic: its name relative to the rig's namespace, its message type, and its joint's name if any."""

    name: str
    type: str
    joint: str = ""


# Keys are the names of RigLog's series.
TOPICS = {
    "top_drive": Topic("top_drive/joint_states", JOINT_STATE, "top_drive"),
    "top_drive_command": Topic("top_drive/command", JOINT_STATE, "top_drive"),
    "draw_works": Topic("draw_works/joint_states", JOINT_STATE, "block"),
    "draw_works_command": Topic("draw_works/command", JOINT_STATE, "block"),
    "standpipe_pressure": Topic("standpipe_pressure", FLUID_PRESSURE),
    "mud_pump": Topic("mud_pump/joint_states", JOINT_STATE, "mud_pump"),
    "mwd_tool_face": Topic("mwd/tool_face", JOINT_STATE, "tool_face"),
    "tool_face_target": Topic("tool_face/target", JOINT_STATE, "tool_face"),
    "bit_depth": Topic("bit_depth", JOINT_STATE, "bit"),
    "truth_bit": Topic("truth/bit", JOINT_STATE, "bit"),
    "truth_weight_on_bit": Topic("truth/weight_on_bit", WRENCH_STAMPED),
    "truth_depth": Topic("truth/depth", JOINT_STATE, "bit"),
}
# Channels stamped in the order in which they arrive.
SURFACE_TOPICS = ("top_drive", "draw_works", "standpipe_pressure", "mud_pump", "top_drive_command", "truth_bit")
# Whose first sample is t = 0 of a log: the first of these that it has.
CLOCK_TOPICS = (*SURFACE_TOPICS, *(key for key in TOPICS if key not in SURFACE_TOPICS))
DIAGNOSTICS = Topic("diagnostics", DIAGNOSTIC_ARRAY)


def namespace_of(topic: str, relative: str) -> str | None:
    """The namespace in front of a relative topic name, "" for none; None where the topic is another one."""
    name = topic.strip("/")
    if name == relative:
        return ""
    return "/" + name[: -len(relative) - 1] if name.endswith("/" + relative) else None


def canonical_type(name: str) -> str:
    """`package/msg/Name` of the ways that recorders write a message type: without `msg`, or as DDS mangles it."""
    parts = name.replace("::dds_::", "::").replace("::", "/").split("/")
    return f"{parts[0]}/msg/{parts[-1].rstrip('_')}"
