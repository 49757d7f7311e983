"""Drives, sensors and MWD of many rigs, compiled: the arithmetic of `VirtualRig` and `FaultyRig`, sample by sample.

Drives and sensors compile the very functions that `VirtualRig` calls. Random numbers are drawn beforehand, in the order
in which `VirtualRig` and `FaultyRig` draw them, so that the same seed gives the same readings.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slider_drilling.angles import wrap_angle
from slider_drilling.drillstring.drives import next_top_drive_speed
from slider_drilling.drillstring.kernel_arrays import CHANNELS, Array
from slider_drilling.drillstring.sensors import quantise
from slider_drilling.process.jit_cache import njit
from slider_drilling.training.plant_rows import EXACT, copy_values

TORQUE, HOOK_LOAD, PRESSURE = 0, 1, 2  # columns of readings, and of the channels
ANGLE, SPEED = 3, 4  # columns of readings
READINGS = 5
TOOL_FACE, WEIGHT_ON_BIT, BIT_DEPTH = (CHANNELS.index(name) for name in ("tool_face", "weight_on_bit", "bit_depth"))
_ROUND_OFF = 1e-9  # s, by which a sample may seem late

_next_speed = njit(**EXACT)(next_top_drive_speed)
_quantise = njit(**EXACT)(quantise)
_wrap_angle = njit(**EXACT)(wrap_angle)


class InstrumentSettings(NamedTuple):
    """Of each drawn rig.

    Attributes:
        limits: (rigs, 3) of the top drive: acceleration rad/s2, speed rad/s, torque N m.
        sensors: (rigs, 3, 3) noise, gain of the lag, resolution, of torque, hook load and pressure.
        mwd: (rigs, 6) period s, latency s, noise rad, resolution rad, shares of samples that are lost and wrong.
    """

    limits: Array
    sensors: Array
    mwd: Array


class InstrumentRecords(NamedTuple):
    """What changes, of each slot.

    Attributes:
        rig: (slots,) number of the drawn rig.
        samples: (slots,) samples of the sensors since the start.
        commanded: (slots,) top-drive angle that is commanded, rad.
        drives: (slots, 5) angle rad, speed rad/s, block position m, its speed m/s, pump speed rad/s.
        rows: (slots, 2, 9) commands of the plant, before and after this sample.
        truth: (slots, channels) `kernel_arrays.CHANNELS`, now.
        lagged: (slots, 3) what the sensors' lags have reached.
        readings: (slots, 5) torque N m, hook load N, pressure Pa, top-drive angle rad and speed rad/s.
        taken: (slots,) MWD samples measured downhole.
        transit: (slots, depth, 3) measured s, arrives s, toolface rad, of samples on their way up.
        waiting: (slots,) how many these are.
        last_mwd: (slots, 3) the last sample received; its times are NaN before the first.
        received: (slots,) samples received since the step began.
        normals: (slots, size) standard normal numbers.
        normals_used: (slots,).
        uniforms: (slots, size, 3) numbers from 0 to 1 for each MWD sample: lost, wrong, angle.
        uniforms_used: (slots,).
    """

    rig: NDArray[np.int64]
    samples: NDArray[np.int64]
    commanded: Array
    drives: Array
    rows: Array
    truth: Array
    lagged: Array
    readings: Array
    taken: Array
    transit: Array
    waiting: Array
    last_mwd: Array
    received: Array
    normals: Array
    normals_used: Array
    uniforms: Array
    uniforms_used: Array


@njit(**EXACT)
def next_normal(i, s):
    """The next standard normal number of slot i."""
    value = s.normals[i, s.normals_used[i]]
    s.normals_used[i] += 1
    return value


@njit(**EXACT)
def follow_commands(i, k, interval, absolute, command, s, p):
    """Drives one sample later, and the plant's row for it.

    Args:
        i, k: Slot and rig.
        interval: s.
        absolute: Whether the command gives the angle too; else the angle follows from the speed.
        command: (4,) top-drive angle rad and speed rad/s, block speed m/s, pump speed rad/s.
        s: `InstrumentRecords`.
        p: `InstrumentSettings`.
    """
    s.samples[i] += 1
    s.commanded[i] = command[0] if absolute else s.commanded[i] + command[1] * interval
    drives, limits, before, row = s.drives[i], p.limits[k], s.rows[i, 0], s.rows[i, 1]
    copy_values(row, before)
    speed = _next_speed(drives[0], drives[1], s.commanded[i], command[1], s.truth[i, TORQUE], limits[0], limits[1],
                        limits[2], interval)  # fmt: skip
    drives[0] = drives[0] + 0.5 * (drives[1] + speed) * interval
    drives[1] = speed
    drives[2] = drives[2] + 0.5 * (drives[3] + command[2]) * interval
    drives[3] = command[2]
    drives[4] = command[3]
    copy_values(drives, row[:5])
    row[7] = (row[1] - before[1]) / interval


@njit(**EXACT)
def read_mwd(i, k, interval, was, now, s, p):
    """MWD samples that are measured and that arrive in the sample that ends now; was, now: unwrapped toolface, rad."""
    settings, time, before = p.mwd[k], s.samples[i] * interval, (s.samples[i] - 1) * interval
    while (s.taken[i] + 1) * settings[0] <= time + _ROUND_OFF:
        s.taken[i] += 1
        at = s.taken[i] * settings[0]
        noisy = was + (at - before) / (time - before) * (now - was) + next_normal(i, s) * settings[2]
        sample = s.transit[i, s.waiting[i]]
        sample[0], sample[1] = at, at + settings[1]
        sample[2] = _wrap_angle(_quantise(_wrap_angle(noisy), settings[3]))
        s.waiting[i] += 1
    arrived = 0
    while arrived < s.waiting[i] and s.transit[i, arrived, 1] <= time + _ROUND_OFF:
        _receive(i, s.transit[i, arrived], settings, s)
        arrived += 1
    if arrived > 0:
        for left in range(s.waiting[i] - arrived):
            copy_values(s.transit[i, left + arrived], s.transit[i, left])
        s.waiting[i] -= arrived


@njit(**EXACT)
def _receive(i, sample, settings, s):
    """Lose a sample, replace its angle by a wrong one, or take it."""
    chance = s.uniforms[i, s.uniforms_used[i]]
    s.uniforms_used[i] += 1
    if chance[0] < settings[4]:
        return
    copy_values(sample, s.last_mwd[i])
    if chance[1] < settings[5]:
        s.last_mwd[i, 2] = math.pi * (2.0 * chance[2] - 1.0)
    s.received[i] += 1


@njit(**EXACT)
def read_surface(i, k, fresh, torque, hook_load, pressure, s, p):
    """Readings of torque N m, hook load N and pressure Pa; `fresh` starts the lags in their steady state."""
    for column, true in enumerate((torque, hook_load, pressure)):
        noise, gain, resolution = p.sensors[k, column, 0], p.sensors[k, column, 1], p.sensors[k, column, 2]
        random = next_normal(i, s) * noise
        old = s.lagged[i, column]
        s.lagged[i, column] = true if fresh else old + gain * (true - old)
        s.readings[i, column] = _quantise(s.lagged[i, column] + random, resolution)
