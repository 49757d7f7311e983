"""From logs to a drill-string model: commands, channels, what the log holds and what it lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.diagnosis.catalogue import SEA_WAVE_PERIODS_S, catalogue, static_aging_with_slip_distance
from slider_drilling.diagnosis.drill_string import MESHES, DrillString, depth_probes
from slider_drilling.diagnosis.nuisance import nuisance_parameters, run_parameters
from slider_drilling.diagnosis.replay import measured_channels
from slider_drilling.diagnosis.run_inputs import RunInputs, read_run_inputs
from slider_drilling.diagnosis.user_effects import UserEffect, guarded, try_effects
from slider_drilling.effects import EFFECTS
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Array, LoggedRun
from slider_drilling.gap.problem.spectral_lines import LINE_FALSE_ALARM, peak_is_significant, resample_evenly
from slider_drilling.log import RigLog
from slider_drilling.log_checks.channel_usable import why_unusable
from slider_drilling.log_checks.expected_levels import OFF_BOTTOM_STIFFNESS
from slider_drilling.log_inputs.reconstruct_flow import flow_reduced
from slider_drilling.rig import Rig

# Hz, above which neither rocking nor the sea moves a hook load; where tools vibrate.
_FAST_HZ, _TOOLS_HZ = 0.4, (5.0, 30.0)
# Spectra are taken this many times as fine as the log is long.
_PADDING = 8
# What a rotary start-up holds together: the drive's own torque, and friction that falls with speed and with the rest
# that is broken.
STICK_SLIP = ("torque_at_motor", "stribeck", "static_aging")


@dataclass(frozen=True)
class PreparedModel:
    """A model of the logs and what to tell the user about them."""

    model: DrillString
    remarks: tuple[str, ...]


def build_model(logs: Sequence[RigLog], rig: Rig, user_effects: Sequence[UserEffect] = ()) -> PreparedModel:
    """Model several logs of one rig.

    Raises InputError when a log holds no top-drive motion or no channel that can be used.
    """
    remarks: list[str] = []
    off_bottom = all(log.draw_works is None and log.standpipe_pressure is None for log in logs)
    if off_bottom:
        rig = replace(rig, bit=replace(rig.bit, depth_of_cut_stiffness=OFF_BOTTOM_STIFFNESS))
        remarks.append("neither drawworks nor standpipe pressure in the log: taken as off bottom")
    driven = [read_run_inputs(log, rig, remarks) for log in logs]
    runs = [run_of(log, rig, own, remarks) for log, own in zip(logs, driven, strict=True)]
    names = sorted({channel.name for run in runs for channel in run.channels})
    if not names:
        raise InputError(f"{logs[0].source}: no channel can be used: {'; '.join(remarks)}")
    length, duration = rig.string.length, max(run.duration for run in runs)
    effects = catalogue(length, duration, wave_periods(runs[0]), tool_frequencies(runs), _torque_interval(runs))
    nuisance = (*nuisance_parameters(rig, names), *run_parameters(names, driven))
    own = [guarded(effect) for effect in user_effects]
    taken = [*(effect.name for effect in effects), *(one.name for one in nuisance)]
    taken += [parameter.name for effect in effects for parameter in effect.parameters]
    try_effects(own, taken, rig, driven[0].commands)
    users = {user.effect.name: user for user in own}
    effects = tuple(effect for effect in effects if EFFECTS[effect.name].visible(names, off_bottom))
    if "hook_load" not in names:
        remarks.append("no hook load: axial_oscillation_tool is not looked for")
    alone = names == ["surface_torque"]
    if alone:
        effects = tuple(
            static_aging_with_slip_distance() if effect.name == "static_aging" else effect for effect in effects
        )
        remarks.append("torque alone: the string's stiffness is re-tuned, a gain of the sensor is taken for friction")
    model = DrillString(
        rig, tuple(runs), tuple(driven), nuisance,
        (*effects, *(user.effect for user in user_effects)), users, depth_probes(length),
        STICK_SLIP if alone else (), MESHES,
    )  # fmt: skip
    return PreparedModel(model, tuple(remarks))


def _torque_interval(runs: Sequence[LoggedRun]) -> float:
    """s between samples of torque, the longest of the runs'; 0 without."""
    times = [c.time for run in runs for c in run.channels if c.name == "surface_torque" and c.time.size > 1]
    return max((float(np.median(np.diff(time))) for time in times), default=0.0)


def run_of(log: RigLog, rig: Rig, driven: RunInputs, remarks: list[str]) -> LoggedRun:
    """The log's channels that can be used; those that cannot are named in the remarks."""
    commands = driven.commands
    channels = []
    for name, channel in measured_channels(log, rig).items():
        kept = channel.time >= driven.begin
        if name == "standpipe_pressure" and driven.flow_steps is not None:
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
    """The string's first torsional modes, held at the top and free at the bit: (2 k - 1) c / (4 L)."""
    first = rig.string.twist_speed / (4.0 * rig.string.length)
    return (("first torsional modes", 0.5 * first, 6.0 * first),)


def wave_periods(run: LoggedRun) -> tuple[float, ...]:
    """Periods s at which hook load (else torque) has its sharpest lines between 4 and 40 s: where heave may be."""
    frequency, power = _spectrum(run)
    inside = np.flatnonzero((frequency > 1.0 / 40.0) & (frequency < 1.0 / 4.0))
    peaks = [i for i in inside[1:-1] if power[i] >= power[i - 1] and power[i] >= power[i + 1]]
    peaks.sort(key=lambda i: -power[i])
    return tuple(float(1.0 / frequency[i]) for i in peaks[:6]) if len(peaks) >= 2 else SEA_WAVE_PERIODS_S


def tool_frequencies(runs: Sequence[LoggedRun]) -> tuple[float, ...]:
    """Frequencies Hz that an axial oscillation tool must have by the sharpest fast line of the first hook load.

    Such a tool is faster than hook loads are sampled: a line stands for every frequency that it is an alias of. Empty
    where no line stands out, so that it has any frequency or there is none.
    """
    shown = next((run for run in runs if any(channel.name == "hook_load" for channel in run.channels)), None)
    if shown is None:
        return ()
    frequency, power = _spectrum(shown)
    fast = frequency > _FAST_HZ
    if not fast.any() or not peak_is_significant(power[fast], _PADDING, LINE_FALSE_ALARM):
        return ()
    line = float(frequency[fast][np.argmax(power[fast])])
    rate = 2.0 * float(frequency[-1])
    aliases = {abs(turn * rate + sign * line) for turn in range(4) for sign in (-1.0, 1.0)}
    return tuple(sorted(hertz for hertz in aliases if _TOOLS_HZ[0] < hertz < _TOOLS_HZ[1]))


def _spectrum(run: LoggedRun) -> tuple[Array, Array]:
    """Frequencies Hz and power of the hook load (else torque) without its slow course; empty where it is too short."""
    by_name = {channel.name: channel for channel in run.channels}
    channel = by_name.get("hook_load") or by_name.get("surface_torque")
    if channel is None or channel.time.size < 400:
        return np.empty(0), np.empty(0)
    interval, time, measured = resample_evenly(channel.time, channel.measured)
    padded = _PADDING * time.size
    trend = np.polynomial.Polynomial.fit(time, measured, 5)(time)
    power = np.abs(np.fft.rfft((measured - trend) * np.hanning(time.size), padded)) ** 2
    return np.asarray(np.fft.rfftfreq(padded, interval), dtype=np.float64), np.asarray(power, dtype=np.float64)
