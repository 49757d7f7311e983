"""The channels of a twin: those that drive the plant, and those that are compared with it."""

from __future__ import annotations

from dataclasses import dataclass

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
SURFACE = ("surface_torque", "hook_load", "standpipe_pressure")


def declared_noise(rig: Rig, channel: str) -> float:
    """Standard deviation of a compared channel's noise, as the rig file declares it: noise and rounding."""
    sensors = rig.sensors
    sensor = sensors.mwd if channel == "tool_face" else getattr(sensors, channel)
    return float((sensor.noise**2 + sensor.resolution**2 / 12.0) ** 0.5)
