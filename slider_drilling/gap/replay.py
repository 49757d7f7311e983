"""Drive the plant with a log's commands and hold its channels against what the log measured."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring import ELEMENTS, Commands, Modifiers, Response, Start, simulate
from slider_drilling.drillstring.from_log import commands_from_log
from slider_drilling.errors import InputError
from slider_drilling.log.series import RigLog
from slider_drilling.rig import Rig

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeasuredChannel:
    """One channel of a log: time (n,) s, measured (n,) in unit; noise: what the rig file declares for its sensor."""

    name: str
    unit: str
    time: Array
    measured: Array
    noise: float
    wraps: bool = False

    def residual(self, simulated: Array) -> Array:
        """measured - simulated (n,), wrapped to (-pi, pi] for an angle."""
        difference = self.measured - simulated
        return (difference + math.pi) % (2.0 * math.pi) - math.pi if self.wraps else difference


@dataclass(frozen=True)
class Comparison:
    """A channel beside the plant's own: simulated and residual (n,) at the channel's times."""

    channel: MeasuredChannel
    simulated: Array
    residual: Array

    @property
    def rms(self) -> float:
        """Root mean square of the residual, in the channel's unit."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def rms_over_noise(self) -> float | None:
        """The same in units of the declared sensor noise; None where none is declared."""
        return self.rms / self.channel.noise if self.channel.noise > 0.0 else None


@dataclass(frozen=True)
class Replay:
    """The plant driven by a log."""

    commands: Commands
    response: Response
    channels: Mapping[str, Comparison]
    assumed: tuple[str, ...]


def measured_channels(log: RigLog, rig: Rig) -> dict[str, MeasuredChannel]:
    """The channels of gap.md that the log holds, missing samples left out, within the top drive's record.

    Raises InputError where there is none.
    """
    sensors, mwd = rig.sensors, rig.sensors.mwd
    mwd_noise = math.hypot(mwd.noise, mwd.resolution / math.sqrt(12.0))
    found: dict[str, MeasuredChannel] = {}
    if log.top_drive is None:
        raise InputError(f"{log.source}: holds no top_drive/joint_states; without it nothing drives the plant")
    last = log.top_drive.time[-1]

    def add(name: str, unit: str, time: Array, values: Array, noise: float, wraps: bool = False) -> None:
        keep = np.isfinite(values) & (time >= 0.0) & (time <= last)
        if keep.any():
            found[name] = MeasuredChannel(name, unit, time[keep], values[keep], noise, wraps)

    add("surface_torque", "N m", log.top_drive.time, log.top_drive.effort, sensors.surface_torque.noise)
    if log.standpipe_pressure is not None:
        pressure = log.standpipe_pressure
        add("standpipe_pressure", "Pa", pressure.time, pressure.value, sensors.standpipe_pressure.noise)
    if log.draw_works is not None:
        add("hook_load", "N", log.draw_works.time, log.draw_works.effort, sensors.hook_load.noise)
    if log.mwd_tool_face is not None:
        add("tool_face", "rad", log.mwd_tool_face.time, log.mwd_tool_face.position, mwd_noise, wraps=True)
    if not found:
        raise InputError(f"{log.source}: holds no surface torque, standpipe pressure, hook load or MWD tool-face")
    return found


def replay(
    log: RigLog,
    rig: Rig,
    elements: int = ELEMENTS,
    start: Start = Start(),
    modifiers: Modifiers = Modifiers(),
) -> Replay:
    """Simulate the log's run from its first sample and compare channel by channel. Raises InputError."""
    driven = commands_from_log(log, rig)
    channels = measured_channels(log, rig)
    response = simulate(rig, driven.commands, elements, start, modifiers)
    compared = {}
    for name, channel in channels.items():
        simulated = np.interp(channel.time, response.time, getattr(response, name))
        compared[name] = Comparison(channel, simulated, channel.residual(simulated))
    return Replay(driven.commands, response, compared, driven.assumed)
