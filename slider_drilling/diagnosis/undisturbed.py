"""Leaves connections and trips of the block out of what is compared: no model of a slide is good there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.drillstring import Commands
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Array
from slider_drilling.log import RigLog
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.rig import Rig

_FAST_BLOCK = 0.02  # m/s: drilling lowers the block ten times more slowly
# s over which the block's speed is averaged: a jerk is no operation; nor, averaged twice over the longer one, are heave
# and what compensates for it, which move the block fast, there and back.
_JERK_S, _WAVE_S = 2.0, 20.0
_PUMPS_OFF = 0.5  # of the usual speed
# s before and after such a time that belong to it: the bit goes back to bottom and pressure settles.
_BEFORE_S, _AFTER_S = 5.0, 60.0
LONG_CALM_S = 200.0
"""Undisturbed time that is enough for a baseline, s."""
_SHORTEST_S = 30.0  # of a log that is left
_MIN_KEPT = 0.4  # of the samples: where less would be left, nothing is left out


def without_operations(model: DrillString) -> DrillString:
    """The same model, compared only where the string drills or turns undisturbed; all of it is still simulated."""
    runs = []
    for run, inputs in zip(model.runs, model.inputs, strict=True):
        calm = calm_times(inputs.commands)
        channels = []
        for channel in run.channels:
            kept = np.interp(channel.time, inputs.commands.time, calm.astype(float)) > 0.5
            if kept.mean() < _MIN_KEPT:
                kept = np.ones_like(kept)
            channels.append(replace(channel, time=channel.time[kept], measured=channel.measured[kept]))
        runs.append(replace(run, channels=tuple(channels)))
    return replace(model, runs=tuple(runs))


def from_calm_start(log: RigLog, rig: Rig, longest: bool = False) -> RigLog:
    """The log from the end of an operation that it begins in: the state of a lifted string is not known.

    Args:
        log: A checked log.
        rig: Its rig file.
        longest: Leave out everything before the last operation too, where `LONG_CALM_S` follow it.

    Raises:
        InputError: An operation takes nearly all of the log.
    """
    commands = commands_from_log(log, rig).commands
    calm, time = calm_times(commands), commands.time
    if calm.all():
        return log
    if np.count_nonzero(calm) * float(np.median(np.diff(time))) < _SHORTEST_S:
        raise InputError(f"{log.source}: a connection or a trip of the block takes nearly all of it; give a longer log")
    disturbed = np.flatnonzero(~calm)
    begin = 0.0
    if longest and time[-1] - time[disturbed[-1]] >= LONG_CALM_S:
        begin = float(time[disturbed[-1]])
    elif not calm[0]:
        begin = float(time[np.flatnonzero(calm)[0]])
    return log if begin <= 0.0 else cut_time_window(log, begin, float(time[-1]))


def is_calm(log: RigLog, rig: Rig, begin: float, end: float) -> bool:
    """Whether no operation is in a checked log between two times, s."""
    commands = commands_from_log(log, rig).commands
    return bool(np.all(calm_times(commands)[(commands.time >= begin) & (commands.time <= end)]))


def calm_share(log: RigLog, rig: Rig) -> float:
    """Share of a checked log in which no operation is."""
    return float(np.mean(calm_times(commands_from_log(log, rig).commands)))


def calm_times(commands: Commands) -> NDArray[np.bool_]:
    """(n,) whether no operation moves the block fast or stops the pumps, by the samples of the commands."""
    usual = float(np.median(np.abs(commands.pump_speed)))
    time, speed = commands.time, commands.block_speed
    interval = float(np.median(np.diff(time)))
    far = _mean(_mean(speed, _WAVE_S / interval), _WAVE_S / interval)
    disturbed = (np.abs(_mean(speed, _JERK_S / interval)) > _FAST_BLOCK) & (np.abs(far) > _FAST_BLOCK)
    disturbed |= np.abs(commands.pump_speed) < _PUMPS_OFF * usual
    begins, ends = time[disturbed] - _BEFORE_S, time[disturbed] + _AFTER_S
    calm = np.ones(time.size, dtype=bool)
    for begin, end in _joined(begins, ends):
        calm &= (time < begin) | (time > end)
    return calm


def _joined(begins: Array, ends: Array) -> list[tuple[float, float]]:
    """Overlapping intervals as one, in their order."""
    joined: list[tuple[float, float]] = []
    for begin, end in zip(begins, ends, strict=True):
        if joined and begin <= joined[-1][1]:
            joined[-1] = joined[-1][0], float(end)
        else:
            joined.append((float(begin), float(end)))
    return joined


def _mean(values: Array, samples: float) -> Array:
    """Moving mean over about so many samples; at either end over what there is of them."""
    window = np.ones(2 * round(0.5 * samples) + 1)
    padded = len(window) // 2
    sums, counts = (np.convolve(np.pad(each, padded), window, mode="valid") for each in (values, np.ones_like(values)))
    return np.asarray(sums / counts)
