"""The registry of a rig's topics: what each is called, what it holds, and how a log, a table and a page show it.

Reader, writer, recorder, tables, summaries, imports and documents follow `TOPICS`. A new topic needs an entry here and
a field of the same name in `slider_drilling.log.series.LogContents`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from slider_drilling.messages.message_types import (
    DIAGNOSTIC_ARRAY,
    FLUID_PRESSURE,
    JOINT_STATE,
    STRING,
    WRENCH_STAMPED,
    MessageType,
    logged_type,
)


@dataclass(frozen=True)
class TopicQuantity:
    """One number that a topic's messages give.

    Attributes:
        array: Its array in the log in memory: position, velocity or effort of a joint, value of anything else.
        column: Its column in tables (CSV, Parquet, data frames).
        unit: SI.
        label: What pages call it.
        import_name: What a mapping file for `slider-drilling import` calls it; empty where it cannot be imported.
        max_magnitude: Values beyond it are no reading of any rig, in any unit that logs come in: a flipped bit, say.
        physical_range: Lowest and highest reading that a rig can have, with room for any rig and a sensor's offset.
        is_wrapped: Whether an imported angle is wrapped into (-pi, pi].
    """

    array: str
    column: str
    unit: str
    label: str
    import_name: str = ""
    max_magnitude: float = math.inf
    physical_range: tuple[float, float] = (-math.inf, math.inf)
    is_wrapped: bool = False


@dataclass(frozen=True)
class Topic:
    """One topic.

    Attributes:
        name: Relative to the rig's namespace.
        type: Message type, ``package/msg/Name``.
        joint: Name of the joint in a JointState; empty for other types.
        quantities: The numbers that a log keeps of it.
        content: What its messages hold, as the documents say it.
        is_simulated_only: Whether only a simulation publishes it; no controller reads it.
        is_surface: Whether its messages are stamped in the order in which they arrive.
        is_measured: Whether it is what one sensor of a rig reads.
    """

    name: str
    type: str
    joint: str = ""
    quantities: tuple[TopicQuantity, ...] = ()
    content: str = ""
    is_simulated_only: bool = False
    is_surface: bool = False
    is_measured: bool = False

    def message_type(self) -> MessageType:
        """The description of its messages. Raises InputError for a type whose numbers a log does not keep."""
        return logged_type(self.type, self.name)

    def quantity(self, array: str) -> TopicQuantity:
        """The quantity of one array: position, velocity, effort or value."""
        return next(quantity for quantity in self.quantities if quantity.array == array)


# Readings that a rig can have, SI. Nulls of recorders (-999.25, -9999) lie outside in most oilfield units.
_DRIVE_SPEEDS = (-60.0, 60.0)  # rad/s: 570 rpm; top drives reach 250 rpm
_TORQUES = (-5e5, 5e5)  # N m; the largest top drives give 150 kN m
_BLOCK_POSITIONS = (-300.0, 20_000.0)  # m, lowered since the start, possibly over many stands
_BLOCK_SPEEDS = (-5.0, 5.0)  # m/s
_HOOK_LOADS = (-5e5, 2e7)  # N; the largest hooks carry 11 MN, and a load cell may be tared
_PRESSURES = (-5e5, 2e8)  # Pa; mud pumps reach 70 MPa
_PUMP_SPEEDS = (-1.0, 100.0)  # rad/s; 120 strokes a minute are 12.6 rad/s
_TOOL_FACES = (-400.0, 400.0)  # rad; room for degrees, which the log checks find
_DEPTHS = (-100.0, 20_000.0)  # m

# What sensors and controllers of a rig say. Keys are the names of the series of a log in memory (RigLog).
_RIG_TOPICS: dict[str, Topic] = {
    "top_drive": Topic(
        "top_drive/joint_states", JOINT_STATE, "top_drive",
        (
            TopicQuantity("position", "top_drive_angle", "rad", "top drive angle", "top_drive_angle", 1e8),
            TopicQuantity("velocity", "top_drive_speed", "rad/s", "top drive speed", "top_drive_speed", 1e5,
                          _DRIVE_SPEEDS),
            TopicQuantity("effort", "surface_torque", "N m", "surface torque", "surface_torque", 1e9, _TORQUES),
        ),
        "angle rad, speed rad/s, effort = surface torque N m", is_surface=True, is_measured=True,
    ),
    "top_drive_command": Topic(
        "top_drive/command", JOINT_STATE, "top_drive",
        (
            TopicQuantity("position", "top_drive_angle_command", "rad", "top drive angle setpoint",
                     "top_drive_angle_command", 1e8),
            TopicQuantity("velocity", "top_drive_speed_command", "rad/s", "top drive speed setpoint",
                     "top_drive_speed_command", 1e5, _DRIVE_SPEEDS),
            TopicQuantity("effort", "surface_torque_command", "N m", "surface torque setpoint", "", 1e9, _TORQUES),
        ),
        "setpoints of angle rad and speed rad/s", is_surface=True,
    ),
    "draw_works": Topic(
        "draw_works/joint_states", JOINT_STATE, "block",
        (
            TopicQuantity("position", "block_position", "m", "block position", "block_position", 1e7, _BLOCK_POSITIONS),
            TopicQuantity("velocity", "block_speed", "m/s", "block speed", "block_speed", 1e5, _BLOCK_SPEEDS),
            TopicQuantity("effort", "hook_load", "N", "hook load", "hook_load", 1e11, _HOOK_LOADS),
        ),
        "block position m, lowered since the start; speed m/s; effort = hook load N", is_surface=True,
        is_measured=True,
    ),
    "draw_works_command": Topic(
        "draw_works/command", JOINT_STATE, "block",
        (
            TopicQuantity("position", "block_position_command", "m", "block position setpoint", "", 1e7,
                          _BLOCK_POSITIONS),
            TopicQuantity("velocity", "block_speed_command", "m/s", "block speed setpoint", "block_speed_command",
                          1e5, _BLOCK_SPEEDS),
            TopicQuantity("effort", "hook_load_command", "N", "hook load setpoint", "", 1e11, _HOOK_LOADS),
        ),
        "setpoint of the block speed m/s, positive lowers",
    ),
    "standpipe_pressure": Topic(
        "standpipe_pressure", FLUID_PRESSURE, "",
        (
            TopicQuantity("value", "standpipe_pressure", "Pa", "standpipe pressure", "standpipe_pressure", 1e11,
                          _PRESSURES),
        ),
        "gauge pressure Pa with its variance Pa2; 0 is unknown", is_surface=True, is_measured=True,
    ),
    "mud_pump": Topic(
        "mud_pump/joint_states", JOINT_STATE, "mud_pump",
        (
            TopicQuantity("position", "pump_angle", "rad", "pump angle", "", 1e10),
            TopicQuantity("velocity", "pump_speed", "rad/s", "pump speed", "pump_speed", 1e6, _PUMP_SPEEDS),
            TopicQuantity("effort", "pump_torque", "N m", "pump torque", "", 1e11),
        ),
        "crank speed rad/s; flow = speed times the rig file's `mud_pump.displacement`", is_surface=True,
        is_measured=True,
    ),
    "mwd_tool_face": Topic(
        "mwd/tool_face", JOINT_STATE, "tool_face",
        (
            TopicQuantity("position", "mwd_tool_face", "rad", "MWD toolface", "tool_face", 1e6, _TOOL_FACES,
                          is_wrapped=True),
            TopicQuantity("velocity", "mwd_tool_face_rate", "rad/s", "MWD toolface rate"),
            TopicQuantity("effort", "mwd_torque", "N m", "MWD torque"),
        ),
        "toolface rad in (-pi, pi]; stamped when measured downhole, logged when decoded at surface", is_measured=True,
    ),
    "tool_face_target": Topic(
        "tool_face/target", JOINT_STATE, "tool_face",
        (
            TopicQuantity("position", "tool_face_target", "rad", "toolface target", "tool_face_target", 1e6,
                     _TOOL_FACES, is_wrapped=True),
            TopicQuantity("velocity", "tool_face_target_rate", "rad/s", "toolface target rate"),
            TopicQuantity("effort", "tool_face_target_torque", "N m", "toolface target torque"),
        ),
        "toolface to hold, rad",
    ),
    "bit_depth": Topic(
        "bit_depth", JOINT_STATE, "bit",
        (
            TopicQuantity("position", "measured_bit_depth", "m", "bit depth", "bit_depth", 1e6, _DEPTHS),
            TopicQuantity("velocity", "measured_bit_speed", "m/s", "bit speed"),
            TopicQuantity("effort", "measured_bit_force", "N", "bit force"),
        ),
        "measured depth of the bit m, where the rig's recorder has it",
    ),
    "truth_bit": Topic(
        "truth/bit", JOINT_STATE, "bit",
        (
            TopicQuantity("position", "tool_face", "rad", "toolface"),
            TopicQuantity("velocity", "tool_face_rate", "rad/s", "toolface rate"),
            TopicQuantity("effort", "bit_torque", "N m", "bit torque"),
        ),
        "toolface rad, unwrapped; its rate rad/s; effort = bit torque N m", is_simulated_only=True, is_surface=True,
    ),
    "truth_weight_on_bit": Topic(
        "truth/weight_on_bit", WRENCH_STAMPED, "",
        (TopicQuantity("value", "weight_on_bit", "N", "weight on bit"),),
        "force.x = weight on bit N", is_simulated_only=True,
    ),
    "truth_depth": Topic(
        "truth/depth", JOINT_STATE, "bit",
        (
            TopicQuantity("position", "bit_depth", "m", "true bit depth"),
            TopicQuantity("velocity", "rate_of_penetration", "m/s", "rate of penetration"),
            TopicQuantity("effort", "bit_force", "N", "true bit force"),
        ),
        "measured depth of the bit m, rate of penetration m/s", is_simulated_only=True,
    ),
}  # fmt: skip


def _of_twin(prefix: str, key: str, content: str) -> Topic:
    """What a twin says of a sensor: a topic of the same type under a prefix, which viewers draw over the sensor's."""
    sensor = _RIG_TOPICS[key]
    quantities = tuple(
        replace(one, column=f"{prefix}_{one.column}", label=f"{prefix} {one.label}", import_name="")
        for one in sensor.quantities
    )
    return Topic(f"{prefix}/{sensor.name}", sensor.type, sensor.joint, quantities, content)


# What the node `twin` says of a rig's sensors: no measurement, and no controller reads it.
TWIN_SERIES: dict[str, Topic] = {
    "expected_top_drive": _of_twin("expected", "top_drive", "by the twin: effort = expected surface torque N m"),
    "expected_draw_works": _of_twin("expected", "draw_works", "by the twin: effort = expected hook load N"),
    "expected_standpipe_pressure": _of_twin(
        "expected", "standpipe_pressure", "by the twin: expected pressure Pa with its variance Pa2"
    ),
    "expected_mwd_tool_face": _of_twin(
        "expected", "mwd_tool_face", "by the twin: toolface rad that the tool is expected to read now"
    ),
    "forecast_top_drive": _of_twin(
        "forecast", "top_drive", "by the twin: effort = surface torque N m at the time of the stamp, which is ahead"
    ),
    "forecast_mwd_tool_face": _of_twin(
        "forecast", "mwd_tool_face", "by the twin: toolface rad at the time of the stamp, which is ahead"
    ),
}
TOPICS: dict[str, Topic] = _RIG_TOPICS | TWIN_SERIES
# Messages of the twin whose numbers a log does not read back. A JointState holds a number for each channel or quantity:
# `name` its name, `position` the number.
GAP_TIMES = (10, 60, 300)  # s over which the gap is averaged
GAP_TOPICS: dict[int, Topic] = {
    seconds: Topic(f"gap/over_{seconds}_s", JOINT_STATE,
                   content=f"gap of each channel over {seconds} s, in noise levels")
    for seconds in GAP_TIMES
}  # fmt: skip
GAP_THRESHOLD = Topic("gap/threshold", JOINT_STATE,
                      content="gap over 60 s that the channel exceeded in 1 % of the time")  # fmt: skip
TREND_TOPICS: dict[str, Topic] = {
    "value": Topic("trend/value", JOINT_STATE, content="calibrated parameters of the rig: best values"),
    "lower": Topic("trend/lower", JOINT_STATE, content="lower ends of their 95 % intervals"),
    "upper": Topic("trend/upper", JOINT_STATE, content="upper ends of their 95 % intervals"),
}
GAP_DIAGNOSIS = Topic("gap/diagnosis", STRING, content="what changed, since when and why, as JSON; latched")
TWIN_TOPICS = (*GAP_TOPICS.values(), GAP_THRESHOLD, *TREND_TOPICS.values(), GAP_DIAGNOSIS)
# The commands of all drives in one message, which is taken or refused as a whole; instead of their own topics.
DRIVES_COMMAND = Topic("drives/command", JOINT_STATE)
DIAGNOSTICS = Topic("diagnostics", DIAGNOSTIC_ARRAY, content="health of each node")

# The first of these that a log holds gives its t = 0. Order matters: the top drive is what drives the plant.
CLOCK_TOPICS = ("top_drive", "draw_works", "standpipe_pressure", "mud_pump", "top_drive_command", "truth_bit",
                *(key for key, topic in TOPICS.items() if not topic.is_surface))  # fmt: skip


def namespace_of(topic: str, relative: str) -> str | None:
    """The namespace in front of a relative topic name, "" for none; None where the topic is another one."""
    name = topic.strip("/")
    if name == relative:
        return ""
    return "/" + name[: -len(relative) - 1] if name.endswith("/" + relative) else None


def fitting_keys(topic: str) -> list[str]:
    """The entries of `TOPICS` that a topic may be, in any namespace; of several the most specific.

    `/expected/standpipe_pressure` is what a twin expects of the pressure, not the pressure in a namespace `expected`.
    """
    fitting = [key for key, known in TOPICS.items() if namespace_of(topic, known.name) is not None]
    longest = max((len(TOPICS[key].name) for key in fitting), default=0)
    return [key for key in fitting if len(TOPICS[key].name) == longest]


def is_of_twin(topic: str) -> bool:
    """Whether a topic, in any namespace, is one of the twin's."""
    return any(namespace_of(topic, known.name) is not None for known in (*TWIN_SERIES.values(), *TWIN_TOPICS))


def canonical_type(name: str) -> str:
    """`package/msg/Name` for the spellings that recorders use: without `msg`, or as DDS mangles it."""
    parts = name.replace("::dds_::", "::").replace("::", "/").split("/")
    return f"{parts[0]}/msg/{parts[-1].rstrip('_')}"
