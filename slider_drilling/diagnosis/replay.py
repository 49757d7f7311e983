"""Simulate a log's commands and compare channel by channel with what the log measured."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring import ELEMENTS, Commands, InitialState, Modifiers, Response, simulate_batch
from slider_drilling.drillstring.recorded_channels import require_finite
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Array, Channel
from slider_drilling.log import RigLog
from slider_drilling.log_checks.repeated_samples import mask_repeated_samples
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.log_inputs.infer_initial_state import LOADED_START_NOTE, infer_initial_state
from slider_drilling.rig import Rig, Sensor
from slider_drilling.units import Text

_UNITS = {"surface_torque": "N m", "standpipe_pressure": "Pa", "hook_load": "N"}
# rad, 15 deg: RMS error of a simulated toolface that nobody would act upon, as directional drillers steer within it.
TOOL_FACE_TOLERANCE = math.radians(15.0)


@dataclass(frozen=True)
class ChannelComparison:
    """A measured channel and its simulation.

    Attributes:
        channel: As measured.
        simulated: (n,) at the channel's times.
        residual: (n,) measured minus simulated.
    """

    channel: Channel
    simulated: Array
    residual: Array

    @property
    def rms(self) -> float:
        """Root mean square of the residual, in the channel's unit."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def rms_over_noise(self) -> float | None:
        """The same relative to the declared noise of the sensor; None if none is declared."""
        declared = self.channel.declared_noise
        return self.rms / declared if declared else None


@dataclass(frozen=True)
class Replay:
    """The simulation of a log.

    Attributes:
        commands: What drove the plant.
        response: What the plant did.
        channels: Comparison of each channel that the log holds.
        assumptions: One sentence for each thing that the log lacks.
    """

    commands: Commands
    response: Response
    channels: Mapping[str, ChannelComparison]
    assumptions: tuple[Text, ...]


def measured_channels(log: RigLog, rig: Rig) -> dict[str, Channel]:
    """The channels of the log that a diagnosis compares, by name, without missing samples.

    Only samples within the top drive's record count: it drives the simulation. Noise and resolution are those that the
    rig file declares.

    Raises:
        InputError: The log holds no top drive, or none of these channels.
    """
    channels: dict[str, Channel] = {}
    if log.top_drive is None:
        raise InputError(log.lack_of_top_drive("drives the plant"))
    last = log.top_drive.time[-1]

    def add(name: str, time: Array, values: Array) -> None:
        keep = np.isfinite(values) & (time >= 0.0) & (time <= last)
        if keep.any():
            channels[name] = channel_of(rig, name, time[keep], values[keep])

    add("surface_torque", log.top_drive.time, log.top_drive.effort)
    if log.standpipe_pressure is not None:
        add("standpipe_pressure", log.standpipe_pressure.time, log.standpipe_pressure.value)
    if log.draw_works is not None:
        add("hook_load", log.draw_works.time, log.draw_works.effort)
    if log.mwd_tool_face is not None:
        add("tool_face", log.mwd_tool_face.time, log.mwd_tool_face.position)
    if not channels:
        raise InputError(f"{log.source}: holds no surface torque, standpipe pressure, hook load or MWD toolface")
    return channels


def channel_of(rig: Rig, name: str, time: Array, values: Array) -> Channel:
    """A channel with the noise, resolution and model error of its sensor.

    Args:
        rig: The rig file, which declares noise and resolution.
        name: ``surface_torque``, ``standpipe_pressure``, ``hook_load`` or ``tool_face``.
        time: (n,) s.
        values: (n,) in the channel's SI unit.
    """
    if name == "tool_face":
        # MWD samples are too few to separate noise and resolution: both count as noise.
        mwd = rig.sensors.mwd
        noise = math.hypot(mwd.noise, mwd.resolution / math.sqrt(12.0))
        return Channel(
            name, time, values, "rad", period=2.0 * math.pi, declared_noise=noise, accumulates=True,
            tolerance=TOOL_FACE_TOLERANCE,
        )  # fmt: skip
    sensor: Sensor = getattr(rig.sensors, name)
    return Channel(
        name, time, values, _UNITS[name], declared_noise=sensor.noise, resolution=sensor.resolution,
        model_error=sensor.model_error,
    )  # fmt: skip

def replay(
    log: RigLog,
    rig: Rig,
    elements: int = ELEMENTS,
    start: InitialState | None = None,
    modifiers: Modifiers = Modifiers(),
) -> Replay:
    """Simulate a log from its first sample and compare channel by channel.

    Args:
        log: The log. Samples that only repeat the one before are left out.
        rig: Its rig file.
        elements: Elements of the string.
        start: Initial state; by default inferred from the log's first second.
        modifiers: Changes along the string.

    Raises:
        InputError: The log holds nothing to drive the plant with, or nothing to compare with.
    """
    log, repeats = mask_repeated_samples(log)
    logged = commands_from_log(log, rig)
    start = start or infer_initial_state(log, rig, logged.commands)
    channels = measured_channels(log, rig)
    acceleration = logged.acceleration_for(rig)
    response = require_finite(
        simulate_batch([rig], logged.commands, elements, [start], [modifiers], acceleration=acceleration)[0]
    )
    comparisons = {}
    for name, channel in channels.items():
        simulated = np.interp(channel.time, response.time, getattr(response, name))
        comparisons[name] = ChannelComparison(channel, simulated, channel.residual(simulated))
    loaded = [LOADED_START_NOTE] if start.loaded else []
    assumptions = (*(issue.text for issue in repeats), *logged.assumptions, *loaded)
    return Replay(logged.commands, response, comparisons, assumptions)
