"""Build the engine's model from logs: inputs, channels, candidates, and remarks on what the logs lack."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.diagnosis.assumed_priors import with_assumed_spreads
from slider_drilling.diagnosis.catalogue import catalogue, static_aging_with_slip_distance
from slider_drilling.diagnosis.channel_wander import channel_wander
from slider_drilling.diagnosis.drill_string import MESHES, DrillString
from slider_drilling.diagnosis.drilling_programmes import surface_channels
from slider_drilling.diagnosis.hook_load_lines import sampled_too_slowly, tool_frequencies, wave_periods
from slider_drilling.diagnosis.nuisance import nuisance_parameters, run_parameters
from slider_drilling.diagnosis.replay import measured_channels
from slider_drilling.diagnosis.rig_values import depth_probes
from slider_drilling.diagnosis.run_inputs import RunInputs, read_run_inputs
from slider_drilling.diagnosis.user_effects import UserEffect, check_user_effects, checked_effect
from slider_drilling.effects import EFFECTS
from slider_drilling.effects.drives_and_bit import AXIAL_OSCILLATION_TOOL
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Effect, LoggedRun, Parameter
from slider_drilling.log import RigLog
from slider_drilling.log_checks.channel_usable import why_unusable
from slider_drilling.log_checks.expected_levels import OFF_BOTTOM_STIFFNESS
from slider_drilling.log_inputs.reconstruct_flow import flow_reduced
from slider_drilling.rig import Rig
from slider_drilling.units import Text

# Effects that show only together in stick-slip: the drive's own torque, and friction that falls with speed and grows
# at rest.
STICK_SLIP_EFFECTS = ("torque_at_motor", "stribeck", "static_aging")


@dataclass(frozen=True)
class PreparedModel:
    """A model of the logs, and what the user must know about them."""

    model: DrillString
    remarks: tuple[Text, ...]


def build_model(logs: Sequence[RigLog], rig: Rig, user_effects: Sequence[UserEffect] = ()) -> PreparedModel:
    """Model one or several logs of one rig.

    Args:
        logs: Checked logs.
        rig: The rig file as given.
        user_effects: Effects beside the catalogue.

    Raises:
        InputError: A log holds no top-drive motion, no channel can be used, or a user's effect is not valid.
    """
    remarks: list[Text] = []
    off_bottom = all(log.draw_works is None and log.standpipe_pressure is None for log in logs)
    if off_bottom:
        rig = replace(rig, bit=replace(rig.bit, depth_of_cut_stiffness=OFF_BOTTOM_STIFFNESS))
        remarks.append("the log holds neither drawworks nor standpipe pressure: the bit is taken to be off bottom")
    inputs = [read_run_inputs(log, rig, remarks) for log in logs]
    runs = [build_run(log, rig, own, remarks) for log, own in zip(logs, inputs, strict=True)]
    channels = sorted({channel.name for run in runs for channel in run.channels})
    if not channels:
        raise InputError(f"{logs[0].source}: no channel can be used: {'; '.join(map(str, remarks))}")
    nuisance = (*nuisance_parameters(rig, channels), *with_assumed_spreads(run_parameters(channels, inputs), rig))
    lines = tool_frequencies(runs)
    effects = _catalogue(rig, runs, lines)
    users = _checked_users(user_effects, effects, nuisance, rig, inputs[0])
    torque_only = channels == ["surface_torque"]
    effects = _observable(effects, channels, off_bottom, torque_only)
    if "hook_load" not in channels:
        remarks.append("the log holds no hook load: axial_oscillation_tool is not a candidate")
    elif not lines:
        # Without its line the tool is no more than less friction, and its frequency may be any.
        effects = tuple(effect for effect in effects if effect.name != AXIAL_OSCILLATION_TOOL.name)
        shows = "the spectrum of the hook load shows no line of a vibrating tool"
        if sampled_too_slowly(runs):
            shows = "the hook load is sampled too slowly to show a vibrating tool"
        remarks.append(f"{shows}: axial_oscillation_tool is not a candidate")
    if torque_only:
        remarks.append(
            "the log holds torque alone: the string's stiffness is calibrated, and an error of the sensor's gain shows "
            "as friction"
        )
    model = DrillString(
        rig, tuple(runs), tuple(inputs), nuisance, (*effects, *(user.effect for user in user_effects)), users,
        depth_probes(rig.string.length), STICK_SLIP_EFFECTS if torque_only else (), MESHES,
    )  # fmt: skip
    return PreparedModel(model, tuple(remarks))


def model_without_logs(rig: Rig, duration: float) -> DrillString:
    """The model of a rig that no log has shown yet, for runs of so many seconds on bottom."""
    names = [channel.name for channel in surface_channels(rig)]
    nuisance = nuisance_parameters(rig, names)
    effects = catalogue(rig.string.length, duration, torque_interval=1.0 / rig.sensors.rate)
    return DrillString(rig, (), (), nuisance, tuple(effects), {}, depth_probes(rig.string.length))


def _catalogue(rig: Rig, runs: Sequence[LoggedRun], lines: Sequence[float]) -> tuple[Effect, ...]:
    """All effects, with search starts that these logs suggest; lines: frequencies of a tool, Hz."""
    duration = max(run.duration for run in runs)
    return catalogue(rig.string.length, duration, wave_periods(runs[0]), lines, _torque_interval(runs), len(runs))


def _checked_users(
    user_effects: Sequence[UserEffect], effects: Sequence[Effect], nuisance: Sequence[Parameter], rig: Rig,
    inputs: RunInputs,
) -> dict[str, UserEffect]:  # fmt: skip
    """Users' effects by name. Raises InputError for one that is not valid or whose name is taken."""
    users = [checked_effect(effect) for effect in user_effects]
    taken = [*(effect.name for effect in effects), *(parameter.name for parameter in nuisance)]
    taken += [parameter.name for effect in effects for parameter in effect.parameters]
    check_user_effects(users, taken, rig, inputs.commands)
    return {user.effect.name: user for user in users}


def _observable(
    effects: Sequence[Effect], channels: Sequence[str], off_bottom: bool, torque_only: bool
) -> tuple[Effect, ...]:
    """The effects that these channels can show."""
    observable = tuple(effect for effect in effects if EFFECTS[effect.name].visible(channels, off_bottom))
    if not torque_only:
        return observable
    # In stick-slip the slip over which a rest is forgotten matters, so it is freed too.
    aging = static_aging_with_slip_distance()
    return tuple(aging if effect.name == aging.name else effect for effect in observable)


def _torque_interval(runs: Sequence[LoggedRun]) -> float:
    """s between samples of torque, the longest of the runs; 0 without torque."""
    times = [c.time for run in runs for c in run.channels if c.name == "surface_torque" and c.time.size > 1]
    return max((float(np.median(np.diff(time))) for time in times), default=0.0)


def build_run(log: RigLog, rig: Rig, inputs: RunInputs, remarks: list[Text]) -> LoggedRun:
    """A log as a run of the engine.

    Args:
        log: The checked log.
        rig: Its rig file.
        inputs: What drove the rig.
        remarks: Gets one sentence for each channel that cannot be used.
    """
    commands = inputs.commands
    channels = []
    for name, channel in measured_channels(log, rig).items():
        kept = channel.time >= inputs.compared_from
        if name == "standpipe_pressure" and inputs.flow_step_times is not None:
            kept &= ~flow_reduced(channel.time, channel.measured, rig)
        channel = replace(channel, time=channel.time[kept], measured=channel.measured[kept])
        channel = replace(channel, wander=channel_wander(channel, rig, commands))
        why = why_unusable(channel)
        if why is None:
            channels.append(channel)
        else:
            remarks.append(f"{log.source}: {name} is left out: {why}")
    return LoggedRun(
        log.source, commands.time, commands.top_drive_angle, tuple(channels), string_bands(rig),
        "the top drive's angle", "rad", "rocking",
    )  # fmt: skip


def string_bands(rig: Rig) -> tuple[tuple[str, float, float], ...]:
    """Band, Hz, of the first torsional modes, fixed at the top and free at the bit: (2 k - 1) c / (4 L)."""
    first = rig.string.twist_speed / (4.0 * rig.string.length)
    return (("first torsional modes", 0.5 * first, 6.0 * first),)
