"""The channels of a twin: those that drive the plant, and those that are compared with it."""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.messages.topics import TOPICS
from slider_drilling.rig import Rig


@dataclass(frozen=True)
class ComparedChannel:
    """A channel that plant and rig both have.

    Attributes:
        unit: SI.
        title: In words.
        sensor_site: Where a fault of its sensor lies.
    """

    unit: str
    title: str
    sensor_site: str = "sensor"


DRIVING = ("top_drive_angle", "top_drive_speed", "block_position", "block_speed", "pump_speed")
COMPARED = {
    "surface_torque": ComparedChannel("N m", "surface torque"),
    "hook_load": ComparedChannel("N", "hook load"),
    "standpipe_pressure": ComparedChannel("Pa", "standpipe pressure", "hydraulics"),
    "tool_face": ComparedChannel("rad", "toolface"),
}
CHANNELS = (*DRIVING, *COMPARED)
_QUANTITIES = {quantity.import_name or quantity.column: quantity
               for topic in TOPICS.values() if topic.is_measured for quantity in topic.quantities}  # fmt: skip
READING_RANGES = {name: _QUANTITIES[name].physical_range for name in CHANNELS}
"""Lowest and highest reading that a rig can have; what lies outside is no reading."""
SURFACE = ("surface_torque", "hook_load", "standpipe_pressure")


_ASSUMED_NOISE = {"surface_torque": 50.0, "hook_load": 1e3, "standpipe_pressure": 1e4, "tool_face": 0.01}


def declared_noise(rig: Rig, channel: str) -> float:
    """Standard deviation of a compared channel's noise: noise and rounding that the rig file declares.

    Where it declares none, what a good sensor has: the gap is counted in it.
    """
    sensors = rig.sensors
    sensor = sensors.mwd if channel == "tool_face" else getattr(sensors, channel)
    return float((sensor.noise**2 + sensor.resolution**2 / 12.0) ** 0.5) or _ASSUMED_NOISE[channel]
