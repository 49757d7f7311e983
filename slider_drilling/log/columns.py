"""A log as one table: the names that its quantities have, and their units."""

from __future__ import annotations

from slider_drilling.columns import Columns, SampledQuantity, join_samples
from slider_drilling.log.series import JointSeries, RigLog, ScalarSeries
from slider_drilling.messages.topics import TOPICS

# Of a joint its position, velocity and effort, of anything else its value.
NAMES = {
    "top_drive": ("top_drive_angle", "top_drive_speed", "surface_torque"),
    "top_drive_command": ("top_drive_angle_command", "top_drive_speed_command", "surface_torque_command"),
    "draw_works": ("block_position", "block_speed", "hook_load"),
    "draw_works_command": ("block_position_command", "block_speed_command", "hook_load_command"),
    "standpipe_pressure": ("standpipe_pressure",),
    "mud_pump": ("pump_angle", "pump_speed", "pump_torque"),
    "mwd_tool_face": ("mwd_tool_face", "mwd_tool_face_rate", "mwd_torque"),
    "tool_face_target": ("tool_face_target", "tool_face_target_rate", "tool_face_target_torque"),
    "bit_depth": ("measured_bit_depth", "measured_bit_speed", "measured_bit_force"),
    "truth_bit": ("tool_face", "tool_face_rate", "bit_torque"),
    "truth_weight_on_bit": ("weight_on_bit",),
    "truth_depth": ("bit_depth", "rate_of_penetration", "bit_force"),
}
_ANGLE, _LENGTH = ("rad", "rad/s", "N m"), ("m", "m/s", "N")
_VALUE = {"standpipe_pressure": "Pa", "truth_weight_on_bit": "N"}


def columns_of(log: RigLog) -> Columns:
    """Every quantity that the log holds over the union of its times, s since the log's start, when measured."""
    quantities: list[SampledQuantity] = []
    for key in TOPICS:
        series = getattr(log, key)
        if series is None:
            continue
        quantities += _of_joint(key, series) if isinstance(series, JointSeries) else [_of_scalar(key, series)]
    return join_samples(quantities)


def _of_joint(key: str, series: JointSeries) -> list[SampledQuantity]:
    names = NAMES.get(key, (f"{key}_position", f"{key}_velocity", f"{key}_effort"))
    arrays = (series.position, series.velocity, series.effort)
    units = _LENGTH if "works" in key or "depth" in key else _ANGLE
    return [
        SampledQuantity(name, unit, series.time, array) for name, unit, array in zip(names, units, arrays, strict=True)
    ]


def _of_scalar(key: str, series: ScalarSeries) -> SampledQuantity:
    (name,) = NAMES.get(key, (key,))
    return SampledQuantity(name, _VALUE.get(key, "-"), series.time, series.value)
