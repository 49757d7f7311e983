"""Build the engine's model from logs: inputs, channels, candidates, and remarks on what the logs lack."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.diagnosis.assumed_priors import with_assumed_spreads
from slider_drilling.diagnosis.catalogue import SEA_WAVE_PERIODS_S, catalogue, static_aging_with_slip_distance
from slider_drilling.diagnosis.drill_string import MESHES, DrillString, depth_probes
from slider_drilling.diagnosis.nuisance import nuisance_parameters, run_parameters
from slider_drilling.diagnosis.replay import measured_channels
from slider_drilling.diagnosis.run_inputs import RunInputs, read_run_inputs
from slider_drilling.diagnosis.user_effects import UserEffect, check_user_effects, checked_effect
from slider_drilling.effects import EFFECTS
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Array, Effect, LoggedRun, Parameter
from slider_drilling.gap.problem.spectral_lines import LINE_FALSE_ALARM, peak_is_significant, resample_evenly
from slider_drilling.log import RigLog
from slider_drilling.log_checks.channel_usable import why_unusable
from slider_drilling.log_checks.expected_levels import OFF_BOTTOM_STIFFNESS
from slider_drilling.log_inputs.reconstruct_flow import flow_reduced
from slider_drilling.rig import Rig
from slider_drilling.units import Text

# Hz. Above this neither rocking nor the sea moves a hook load; vibrating tools are within the range.
_FAST_HZ, _TOOLS_HZ = 0.4, (5.0, 30.0)
# Spectra are padded to this many times the log's length, for a finer grid of frequencies.
_PADDING = 8
_MIN_SPECTRUM = 400  # samples
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
    effects = _catalogue(rig, runs)
    users = _checked_users(user_effects, effects, nuisance, rig, inputs[0])
    torque_only = channels == ["surface_torque"]
    effects = _observable(effects, channels, off_bottom, torque_only)
    if "hook_load" not in channels:
        remarks.append("the log holds no hook load: axial_oscillation_tool is not a candidate")
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


def _catalogue(rig: Rig, runs: Sequence[LoggedRun]) -> tuple[Effect, ...]:
    """All effects, with search starts that these logs suggest."""
    duration = max(run.duration for run in runs)
    return catalogue(rig.string.length, duration, wave_periods(runs[0]), tool_frequencies(runs), _torque_interval(runs))


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
        why = why_unusable(channel)
        if why is None:
            channels.append(channel)
        else:
            remarks.append(f"{log.source}: {name} is left out: {why}")
    return LoggedRun(
        log.source, commands.time, commands.top_drive_angle, tuple(channels), string_bands(rig),
        "the top drive's angle", "rad",
    )  # fmt: skip


def string_bands(rig: Rig) -> tuple[tuple[str, float, float], ...]:
    """Band, Hz, of the first torsional modes, fixed at the top and free at the bit: (2 k - 1) c / (4 L)."""
    first = rig.string.twist_speed / (4.0 * rig.string.length)
    return (("first torsional modes", 0.5 * first, 6.0 * first),)


def wave_periods(run: LoggedRun) -> tuple[float, ...]:
    """Periods, s, of the highest spectral peaks of hook load (else torque) between 4 and 40 s: where heave may be."""
    frequency, power = _spectrum(run)
    inside = np.flatnonzero((frequency > 1.0 / 40.0) & (frequency < 1.0 / 4.0))
    peaks = [i for i in inside[1:-1] if power[i] >= power[i - 1] and power[i] >= power[i + 1]]
    peaks.sort(key=lambda i: -power[i])
    return tuple(float(1.0 / frequency[i]) for i in peaks[:6]) if len(peaks) >= 2 else SEA_WAVE_PERIODS_S


def tool_frequencies(runs: Sequence[LoggedRun]) -> tuple[float, ...]:
    """Frequencies, Hz, that an axial oscillation tool may have by the strongest fast line of the first hook load.

    Hook loads are sampled more slowly than such a tool vibrates, so the line may be an alias: all frequencies that it
    can stand for are returned. Empty if no line is significant.
    """
    with_hook_load = next((run for run in runs if any(channel.name == "hook_load" for channel in run.channels)), None)
    if with_hook_load is None:
        return ()
    frequency, power = _spectrum(with_hook_load)
    fast = frequency > _FAST_HZ
    if not fast.any() or not peak_is_significant(power[fast], _PADDING, LINE_FALSE_ALARM):
        return ()
    line = float(frequency[fast][np.argmax(power[fast])])
    rate = 2.0 * float(frequency[-1])
    aliases = {abs(multiple * rate + sign * line) for multiple in range(4) for sign in (-1.0, 1.0)}
    return tuple(sorted(alias for alias in aliases if _TOOLS_HZ[0] < alias < _TOOLS_HZ[1]))


def _spectrum(run: LoggedRun) -> tuple[Array, Array]:
    """Frequencies, Hz, and power of the detrended hook load (else torque); empty if the record is too short."""
    by_name = {channel.name: channel for channel in run.channels}
    channel = by_name.get("hook_load") or by_name.get("surface_torque")
    if channel is None or channel.time.size < _MIN_SPECTRUM:
        return np.empty(0), np.empty(0)
    interval, time, measured = resample_evenly(channel.time, channel.measured)
    padded = _PADDING * time.size
    trend = np.polynomial.Polynomial.fit(time, measured, 5)(time)
    power = np.abs(np.fft.rfft((measured - trend) * np.hanning(time.size), padded)) ** 2
    return np.asarray(np.fft.rfftfreq(padded, interval), dtype=np.float64), np.asarray(power, dtype=np.float64)
