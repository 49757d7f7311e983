"""A simulated run written as a log like any other: without noise, and with the true state downhole."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from slider_drilling.angles import wrap_angle
from slider_drilling.drillstring.recorded_channels import Commands, Response
from slider_drilling.log.write import LogWriter
from slider_drilling.messages.topics import TOPICS
from slider_drilling.rig import Rig, dump_rig


def write_simulated(path: Path, rig: Rig, commands: Commands, response: Response, start: float, notes: str) -> None:
    """Write a run to an MCAP file that holds the rig file too.

    The MWD samples the true toolface every period; its samples reach surface latency later.

    Args:
        start: Time of the first sample, s since 1970.
        notes: Free text for the log's metadata.

    Raises:
        InputError: Where the file cannot be written.
    """
    with LogWriter(path, dump_rig(rig), "slider-drilling replay", notes, whole=True) as writer:
        origin = start - response.time[0]
        arrivals = _mwd(rig, response)
        for k, time in enumerate(response.time):
            while arrivals and arrivals[0][1] <= time:
                measured, arrived, angle = arrivals.pop(0)
                topic = TOPICS["mwd_tool_face"]
                writer.joint_state(
                    topic.name, origin + measured, topic.joint, position=angle, log_time_s=origin + arrived
                )
            _write_sample(writer, origin + float(time), k, commands, response)


def _write_sample(writer: LogWriter, stamp: float, k: int, commands: Commands, response: Response) -> None:
    drive, works, pump = TOPICS["top_drive"], TOPICS["draw_works"], TOPICS["mud_pump"]
    writer.joint_state(
        drive.name, stamp, drive.joint, commands.top_drive_angle[k], commands.top_drive_speed[k],
        response.surface_torque[k],
    )  # fmt: skip
    writer.joint_state(
        works.name, stamp, works.joint, commands.block_position[k], commands.block_speed[k], response.hook_load[k]
    )
    writer.joint_state(pump.name, stamp, pump.joint, velocity=commands.pump_speed[k])
    writer.fluid_pressure(TOPICS["standpipe_pressure"].name, stamp, response.standpipe_pressure[k])
    bit = TOPICS["truth_bit"]
    writer.joint_state(
        bit.name, stamp, bit.joint, response.tool_face[k], response.tool_face_rate[k], response.bit_torque[k]
    )
    writer.wrench(TOPICS["truth_weight_on_bit"].name, stamp, (response.weight_on_bit[k], 0.0, 0.0))
    depth = TOPICS["truth_depth"]
    writer.joint_state(depth.name, stamp, depth.joint, response.bit_depth[k], response.rate_of_penetration[k])


def _mwd(rig: Rig, response: Response) -> list[tuple[float, float, float]]:
    """(measured at, arrives at, toolface) of each MWD sample, s, s, rad, oldest first."""
    settings = rig.sensors.mwd
    first, last = response.time[0], response.time[-1]
    times = np.arange(first + settings.period, last + 1e-9, settings.period)
    angles = np.interp(times, response.time, response.tool_face)
    return [(float(t), float(t + settings.latency), wrap_angle(float(a))) for t, a in zip(times, angles, strict=True)]
