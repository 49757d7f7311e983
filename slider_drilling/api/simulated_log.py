"""Sensor readings of a simulated run, and the log that a recorder would make of it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.control.interface import MwdSample
from slider_drilling.drillstring import Commands, Response
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.sensors import MwdSensor, SurfaceSensor
from slider_drilling.log import JointSeries, RigLog, ScalarSeries
from slider_drilling.rig import Rig, dump_rig

SURFACE_SENSORS = ("surface_torque", "hook_load", "standpipe_pressure")


@dataclass(frozen=True)
class SensorReadings:
    """Sensor readings.

    Attributes:
        surface: Sensor -> readings (n,) in N m, N or Pa.
        mwd: The toolfaces that arrived at surface.
    """

    surface: dict[str, Array]
    mwd: tuple[MwdSample, ...]


def sample_sensors(rig: Rig, response: Response, seed: int) -> SensorReadings:
    """Apply noise, lag and resolution of the rig's sensors to a response; the same seed gives the same readings."""
    random = np.random.default_rng(seed)
    interval = float(np.median(np.diff(response.time))) if len(response.time) > 1 else 1.0 / rig.sensors.rate
    surface = {}
    for name in SURFACE_SENSORS:
        sensor = SurfaceSensor(getattr(rig.sensors, name), interval)
        surface[name] = np.array([sensor.read(float(value), random) for value in getattr(response, name)])
    sensor_below = MwdSensor(rig.sensors.mwd)
    samples: list[MwdSample] = []
    turned = list(zip(response.time - response.time[0], response.tool_face, strict=True))
    for before, now in itertools.pairwise(turned):
        samples += sensor_below.read(before, now, random)
    return SensorReadings(surface, tuple(samples))


def build_log(
    rig: Rig, commands: Commands, response: Response, readings: SensorReadings, targets: Sequence[tuple[float, float]],
    source: str,
) -> RigLog:
    """A run as a log in memory.

    Args:
        rig: The rig file that the log carries.
        commands: Motion of the drives.
        response: Noise-free response; becomes the log's truth topics.
        readings: Sensor readings.
        targets: Toolface targets: (time s, toolface rad).
        source: Name of the log.
    """
    time, none = response.time - response.time[0], np.full(len(response.time), np.nan)
    samples = [[sample.measured_at, sample.arrived_at, sample.tool_face] for sample in readings.mwd]
    measured = np.array(samples).reshape(-1, 3).T
    asked = np.array(targets, dtype=float).reshape(-1, 2).T
    blank = np.full(measured.shape[1], np.nan)
    unknown = np.full(asked.shape[1], np.nan)
    pressure = readings.surface["standpipe_pressure"]
    variance = np.full(len(time), rig.sensors.standpipe_pressure.noise**2)
    return RigLog(
        source=source,
        start_ns=0,
        rig_text=dump_rig(rig),
        rig_source=f"{source}: rig",
        top_drive=JointSeries(time, time, commands.top_drive_angle, commands.top_drive_speed,
                              readings.surface["surface_torque"]),
        draw_works=JointSeries(time, time, commands.block_position, commands.block_speed,
                               readings.surface["hook_load"]),
        standpipe_pressure=ScalarSeries(time, time, pressure, variance),
        mud_pump=JointSeries(time, time, none, commands.pump_speed, none),
        mwd_tool_face=JointSeries(measured[0], measured[1], measured[2], blank, blank) if readings.mwd else None,
        tool_face_target=JointSeries(asked[0], asked[0], asked[1], unknown, unknown) if targets else None,
        truth_bit=JointSeries(time, time, response.tool_face, response.tool_face_rate, response.bit_torque),
        truth_weight_on_bit=ScalarSeries(time, time, response.weight_on_bit, none),
        truth_depth=JointSeries(time, time, response.bit_depth, response.rate_of_penetration, none),
    )  # fmt: skip
