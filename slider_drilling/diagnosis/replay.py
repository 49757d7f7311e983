"""Drive the plant with a log's commands and hold its channels against what the log measured."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.drillstring import ELEMENTS, Commands, InitialState, Modifiers, Response, simulate_batch
from slider_drilling.drillstring.recorded_channels import require_finite
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Array, Channel
from slider_drilling.log import RigLog
from slider_drilling.log_checks.repeated_samples import mask_repeated_samples
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.log_inputs.infer_initial_state import LOADED_START_NOTE, infer_initial_state
from slider_drilling.rig import Mwd, Rig, Sensor


@dataclass(frozen=True)
class Comparison:
    """A channel beside the plant's own: simulated and residual (n,) at the channel's times."""

    channel: Channel
    simulated: Array
    residual: Array

    @property
    def rms(self) -> float:
        """Root mean square of the residual, in the channel's unit."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def rms_over_noise(self) -> float | None:
        """The same in units of the declared sensor noise; None where none is declared."""
        declared = self.channel.declared_noise
        return self.rms / declared if declared else None


@dataclass(frozen=True)
class Replay:
    """The plant driven by a log."""

    commands: Commands
    response: Response
    channels: Mapping[str, Comparison]
    assumed: tuple[str, ...]


def measured_channels(log: RigLog, rig: Rig) -> dict[str, Channel]:
    """The channels of gap.md that the log holds, missing samples left out, within the top drive's record.

    Noise and resolution are what the rig file declares. Raises InputError where there is no channel.
    """
    sensors, mwd = rig.sensors, rig.sensors.mwd
    found: dict[str, Channel] = {}
    if log.top_drive is None:
        raise InputError(f"{log.source}: holds no top_drive/joint_states; without it nothing drives the plant")
    last = log.top_drive.time[-1]

    def add(name: str, unit: str, time: Array, values: Array, sensor: Sensor | Mwd) -> None:
        keep = np.isfinite(values) & (time >= 0.0) & (time <= last)
        if keep.any():
            found[name] = Channel(
                name, time[keep], values[keep], unit, declared_noise=sensor.noise, resolution=sensor.resolution
            )

    add("surface_torque", "N m", log.top_drive.time, log.top_drive.effort, sensors.surface_torque)
    if log.standpipe_pressure is not None:
        pressure = log.standpipe_pressure
        add("standpipe_pressure", "Pa", pressure.time, pressure.value, sensors.standpipe_pressure)
    if log.draw_works is not None:
        add("hook_load", "N", log.draw_works.time, log.draw_works.effort, sensors.hook_load)
    if log.mwd_tool_face is not None:
        add("tool_face", "rad", log.mwd_tool_face.time, log.mwd_tool_face.position, mwd)
        if "tool_face" in found:
            # Its resolution is part of the noise: MWD samples are too few to tell the two apart.
            noise = math.hypot(mwd.noise, mwd.resolution / math.sqrt(12.0))
            found["tool_face"] = replace(
                found["tool_face"], period=2.0 * math.pi, declared_noise=noise, resolution=0.0, accumulates=True
            )
    if not found:
        raise InputError(f"{log.source}: holds no surface torque, standpipe pressure, hook load or MWD toolface")
    return found


def replay(
    log: RigLog,
    rig: Rig,
    elements: int = ELEMENTS,
    start: InitialState | None = None,
    modifiers: Modifiers = Modifiers(),
) -> Replay:
    """Simulate the log's run from its first sample and compare channel by channel; start: by default as the log's first
    second shows it (`start_of`). Values that are held between renewals are left out. Raises InputError.
    """
    log, repeats = mask_repeated_samples(log)
    driven = commands_from_log(log, rig)
    start = start or infer_initial_state(log, rig, driven.commands)
    channels = measured_channels(log, rig)
    faster = driven.acceleration_for(rig)
    response = require_finite(
        simulate_batch([rig], driven.commands, elements, [start], [modifiers], acceleration=faster)[0]
    )
    compared = {}
    for name, channel in channels.items():
        simulated = np.interp(channel.time, response.time, getattr(response, name))
        compared[name] = Comparison(channel, simulated, channel.residual(simulated))
    loaded = [LOADED_START_NOTE] if start.loaded else []
    assumed = (*(str(issue.text) for issue in repeats), *driven.assumptions, *loaded)
    return Replay(driven.commands, response, compared, assumed)
