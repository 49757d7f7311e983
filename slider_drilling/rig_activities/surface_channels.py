"""The surface channels of a log at one sample a second, as the detection of activities needs them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.log.series import Array, LogContents

Mask = NDArray[np.bool_]

MAX_HOLE = 30.0
"""s without a sample after which the recording is taken as interrupted; a 1 Hz recorder skips a few samples."""
MIN_DURATION = 60.0
"""s; a shorter log holds no activity that could be distinguished from its neighbours."""
PUMPING_SHARE = 0.2
"""Share of the usual pump speed or pressure above which the pumps run; a stopping pump passes it within seconds."""


@dataclass(frozen=True)
class SurfaceChannels:
    """What the rig floor measures, one sample a second. All arrays have shape (n,).

    Attributes:
        time: s since the log's start.
        block: How far the block is lowered, m.
        hook_load: N; NaN where the log has none.
        speed: Of the top drive, rad/s.
        turned: Angle that the top drive has turned either way since the start, rad.
        net_angle: Angle of the top drive, rad.
        torque: At surface, N m; NaN where the log has none.
        pressure: Of the standpipe, Pa; NaN where the log has none.
        pump_speed: rad/s; NaN where the log has none.
        pumping: Whether the pumps run.
        recorded: Whether the log holds samples around this time.
        is_signed: Whether the top drive's speed has a sign.
    """

    time: Array
    block: Array
    hook_load: Array
    speed: Array
    turned: Array
    net_angle: Array
    torque: Array
    pressure: Array
    pump_speed: Array
    pumping: Mask
    recorded: Mask
    is_signed: bool


def surface_channels(log: LogContents) -> SurfaceChannels:
    """The channels of a log, resampled. Raises InputError where block or top drive is missing, or the log is short."""
    works, drive = log.draw_works, log.top_drive
    if works is None or np.isfinite(works.position).sum() < 2:
        raise InputError(f"{log.source}: holds no block position; activities need it")
    if drive is None or not (np.isfinite(drive.velocity) | np.isfinite(drive.position)).any():
        raise InputError(f"{log.source}: holds no speed or angle of the top drive; activities need one of them")
    time = np.arange(0.0, min(works.time[-1], drive.time[-1]) + 1e-6)
    if len(time) < MIN_DURATION:
        raise InputError(f"{log.source}: lasts {len(time)} s; activities need at least {MIN_DURATION:.0f} s")
    speed = drive.velocity
    if not np.isfinite(speed).any():
        speed = np.gradient(drive.position, drive.time)
    step = np.diff(drive.time, prepend=drive.time[0])
    step[step > MAX_HOLE] = 0.0  # no integral over an interruption
    known = np.nan_to_num(speed)
    moved, turned = (0.5 * (rate + np.roll(rate, 1)) * step for rate in (known, np.abs(known)))
    angle = drive.position if np.isfinite(drive.position).any() else np.cumsum(moved)
    pump = np.full(1, np.nan) if log.mud_pump is None else log.mud_pump.velocity
    pump_time = np.zeros(1) if log.mud_pump is None else log.mud_pump.time
    pressure = np.full(1, np.nan) if log.standpipe_pressure is None else log.standpipe_pressure.value
    pressure_time = np.zeros(1) if log.standpipe_pressure is None else log.standpipe_pressure.time
    pump_speed, pressure = _resampled(time, pump_time, pump), _resampled(time, pressure_time, pressure)
    return SurfaceChannels(
        time=time,
        block=_resampled(time, works.time, works.position),
        hook_load=_resampled(time, works.time, works.effort),
        speed=_resampled(time, drive.time, speed),
        turned=_resampled(time, drive.time, np.cumsum(turned)),
        net_angle=_resampled(time, drive.time, angle),
        torque=_resampled(time, drive.time, drive.effort),
        pressure=pressure,
        pump_speed=pump_speed,
        pumping=_pumping(pump_speed, pressure, log.source),
        recorded=_recorded(time, works.time[np.isfinite(works.position)]),
        is_signed=bool(np.nanmin(speed) < -0.1),  # rad/s; noise of a drive at rest stays below
    )


def _resampled(time: Array, at: Array, value: Array) -> Array:
    """Linear between the samples that there are; NaN without any."""
    there = np.isfinite(value)
    return np.interp(time, at[there], value[there]) if there.any() else np.full(len(time), np.nan)


def _recorded(time: Array, at: Array) -> Mask:
    """Whether both neighbouring samples belong to the same uninterrupted stretch."""
    after = np.searchsorted(at, time).clip(1, len(at) - 1)
    return np.asarray(at[after] - at[after - 1] <= MAX_HOLE)


def _pumping(pump_speed: Array, pressure: Array, source: str) -> Mask:
    """Whether the pumps run, by their speed, else by the pressure. Raises InputError where neither is known."""
    for values in (pump_speed, pressure):
        if np.isfinite(values).any():
            usual = float(np.percentile(values, 90.0))  # pumps that run a tenth of the day or more
            return np.asarray(values > PUMPING_SHARE * max(usual, 1e-9))
    raise InputError(f"{source}: holds neither pump speed nor standpipe pressure; activities need one of them")
