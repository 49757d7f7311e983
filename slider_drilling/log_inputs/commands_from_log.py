"""What a log's own measurements command the plant to do."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.integrate import cumulative_trapezoid

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.recorded_channels import Commands
from slider_drilling.drillstring.sample_gaps import times_in_gaps
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log.series import JointSeries
from slider_drilling.log_inputs.fill_drive_gaps import fill_drive_gaps, is_undersampled
from slider_drilling.log_inputs.fill_pump_gaps import fill_pump_gaps
from slider_drilling.log_inputs.fuse_position_and_speed import fuse_position_and_speed
from slider_drilling.log_inputs.reconstruct_block import reconstruct_block
from slider_drilling.log_inputs.reconstruct_flow import PressureSteps, flow_fraction, pressure_steps
from slider_drilling.rig import Rig, check_duration

_TURNING = 0.05  # rad/s, from which a drive turns
_FINE_S = 0.1  # between the commands where a log has them more seldom


@dataclass(frozen=True)
class LogCommands:
    """The commands, and one sentence for each thing that the log does not hold and that was assumed instead.

    block_logged: whether the log holds the block's motion; lowered: whether it is only what standpipe pressure tells of
    it; flow_steps: s at which the flow may
    have changed unseen, None where the log holds the pump.
    """

    commands: Commands
    assumptions: tuple[str, ...]
    block_logged: bool = True
    block_from_pressure: bool = False
    flow_step_times: tuple[float, ...] | None = None

    @cached_property
    def acceleration(self) -> Array:
        """(n,) rad/s2 of the top drive at the commands' times, see `drive_acceleration`."""
        from slider_drilling.log_inputs.drive_acceleration import drive_acceleration  # scipy: whoever asks for it waits

        return drive_acceleration(self.commands.time, self.commands.top_drive_speed)

    def acceleration_for(self, rig: Rig) -> Array | None:
        """The same where the rig's torque holds it, None where nothing reads it: a long log takes seconds."""
        return self.acceleration if rig.effects.torque_at_motor.inertia > 0.0 else None


def commands_from_log(log: RigLog, rig: Rig) -> LogCommands:
    """Measured top-drive angle, block position and pump speed at the top drive's sample times, and where some were lost
    at the others' and at the corners of the motion (see `with_lost_motion`); where the pump's were lost its speed
    changed when the pressure did (see `with_lost_flow`).

    Angle and speed are used together (model.md: joining a 10 Hz angle by straight lines costs 100 to 360 N m of
    surface torque). A speed that the log lacks, or has as zero throughout, is the position's slope, a position the
    speed's integral. Without drawworks the block is lowered as the standpipe pressure tells (`block_by_pressure`), and
    without that it stands still; without a pump the flow is the rig file's reference flow where the log holds a
    standpipe pressure, and zero otherwise. Raises InputError for a log without a top drive, or whose top drive has
    fewer than two usable samples, and for a rig whose friction would drift away meanwhile.
    """
    if log.top_drive is None:
        raise InputError(f"{log.source}: holds no top_drive/joint_states; without it nothing drives the plant")
    drive = _usable(log.top_drive)
    count = len(drive.time)
    if count < 2:
        raise InputError(f"{log.source}: top_drive/joint_states has {count} usable sample(s); at least two needed")
    check_duration(rig, float(drive.time[-1] - drive.time[0]), log.rig_source or log.source)
    assumed: list[str] = []
    time, angle, speed = _turned(log, drive, rig, assumed)
    pump, steps = _pump_speed(log, rig, time, assumed)
    block, block_speed, lowered = np.zeros_like(time), np.zeros_like(time), None
    works = None if log.draw_works is None else _usable(log.draw_works)
    block_logged = works is not None and len(works.time) >= 2
    if works is not None and block_logged:
        motion = _motion(works, assumed, "the block's position", "m")
        moved = Commands(works.time, *motion, *motion, np.zeros_like(works.time)).resampled(time)
        block, block_speed = moved.block_position, moved.block_speed
    elif (lowered := _lowered(log, rig, time, speed, pump)) is not None:
        assumed.append("the log holds no drawworks: the block is lowered as the standpipe pressure tells")
        block, block_speed = lowered
    else:
        assumed.append("the log holds no drawworks: the block is taken to stand still")
    commands = Commands(time, angle, speed, block, block_speed, pump)
    return LogCommands(commands, tuple(assumed), block_logged, lowered is not None, steps)


def _turned(log: RigLog, drive: JointSeries, rig: Rig, assumed: list[str]) -> tuple[Array, Array, Array]:
    """Time, angle and speed of the top drive: its samples, and where some were lost the corners of its motion and the
    times at which the block's or the pump's came. Where samples come too seldom to show how it turns round, its motion
    is sampled finely between them.
    """
    seldom, whole = is_undersampled(drive.time), np.isfinite(drive.position).any() and np.isfinite(drive.velocity).any()
    time, angle, speed = drive.time, *_motion(drive, assumed, "the top drive's angle", "rad")
    if whole or not seldom:
        time, angle, speed = fill_drive_gaps(time, angle, speed, rig.top_drive.max_acceleration)
    if seldom:
        asked = _finely(drive.time)
    else:
        others = [series.time for series in (log.draw_works, log.mud_pump) if series is not None]
        come = times_in_gaps(drive.time, np.concatenate([*others, np.empty(0)]))
        if come.size == 0:
            return time, angle, speed
        asked = np.union1d(time, come)
    still = np.zeros_like(time)
    found = Commands(time, angle, speed, still, still, still).resampled(asked)
    return found.time, found.top_drive_angle, found.top_drive_speed


def _finely(time: Array) -> Array:
    """The times (n,) and evenly between each two of them as many as make steps of at most a tenth of a second."""
    pieces = [
        np.linspace(begin, end, math.ceil((end - begin) / _FINE_S - 1e-6), endpoint=False)
        for begin, end in itertools.pairwise(time)
    ]
    return np.concatenate([*pieces, time[-1:]])


def unfilled_field(series: JointSeries) -> str | None:
    """"position" or "velocity" where one is zero in every sample although the other moves: nobody filled it."""
    known = np.isfinite(series.position) & np.isfinite(series.velocity)
    if np.count_nonzero(known) < 3:
        return None
    moves, turns = np.ptp(series.position[known]) > 0.0, np.any(series.velocity[known])
    still = not np.any(series.position[known])
    return "position" if turns and still else "velocity" if moves and not turns else None


def _usable(series: JointSeries) -> JointSeries:
    """Samples with a position or a velocity, without the one that nobody filled."""
    if (empty := unfilled_field(series)) is not None:
        nothing: dict[str, Any] = {empty: np.full_like(series.time, np.nan)}
        series = replace(series, **nothing)
    keep = np.isfinite(series.position) | np.isfinite(series.velocity)
    arrays = (series.time, series.arrival, series.position, series.velocity, series.effort)
    return JointSeries(*(array[keep] for array in arrays))


def _motion(series: JointSeries, assumed: list[str], words: str, unit: str) -> tuple[Array, Array]:
    """Position and velocity (n,), each made from the other where the log lacks it, the likeliest of both where they do
    not agree.
    """
    time, position, velocity = series.time, series.position, series.velocity
    known = np.isfinite(position)
    if not known.any():
        velocity = np.interp(time, time[np.isfinite(velocity)], velocity[np.isfinite(velocity)])
        return cumulative_trapezoid(velocity, time, initial=0.0), velocity
    position = np.interp(time, time[known], position[known])
    measured = np.isfinite(velocity)
    velocity = np.where(measured, velocity, np.gradient(position, time))
    if not measured.any() or is_undersampled(time):
        return position, velocity
    likeliest, speed = fuse_position_and_speed(time, position, velocity)
    if likeliest is not position:
        off = (float(np.sqrt(np.mean(square**2))) for square in (likeliest - position, speed - velocity))
        apart = " and ".join(f"{rms:.2g} {one}" for rms, one in zip(off, (unit, f"{unit}/s"), strict=True))
        assumed.append(f"{words} and its speed do not quite agree: taken is what is likeliest given both, {apart} off")
    return likeliest, speed


def _lowered(log: RigLog, rig: Rig, time: Array, speed: Array, pump: Array) -> tuple[Array, Array] | None:
    """Position and speed of the block as the standpipe pressure tells them, None without one."""
    if log.standpipe_pressure is None:
        return None
    known = np.isfinite(log.standpipe_pressure.value)
    if np.count_nonzero(known) < 2:
        return None
    seen, pressure = log.standpipe_pressure.time[known], log.standpipe_pressure.value[known]
    return reconstruct_block(time, np.abs(speed) > _TURNING, pump, seen, pressure, rig)


def _pump_speed(
    log: RigLog, rig: Rig, time: Array, assumed: list[str]
) -> tuple[Array, tuple[float, ...] | None]:
    """(n,) rad/s, and where the log does not hold it the times at which pressure steps."""
    pressure = log.standpipe_pressure
    if log.mud_pump is not None:
        known = np.isfinite(log.mud_pump.velocity)
        if known.any():
            pumped, speed = log.mud_pump.time[known], log.mud_pump.velocity[known]
            if pressure is not None:
                pumped, speed = fill_pump_gaps(pumped, speed, pressure.time, pressure.value)
            return np.interp(time, pumped, speed), None
    if pressure is None:
        assumed.append("the log holds neither pump nor standpipe pressure: the pump is taken to be off")
        return np.zeros_like(time), ()
    assumed.append("the log holds no pump: the flow is taken to be the rig file's reference flow")
    known = np.isfinite(pressure.value)
    share = np.ones_like(time)
    steps: PressureSteps = ()
    if known.any():
        seen, value = pressure.time[known], pressure.value[known]
        steps = pressure_steps(seen, value, rig)
        share = np.interp(time, seen, flow_fraction(seen, value, steps, rig))
    if share.min() < 1.0:
        first = float(time[np.argmin(share > 0.5 * (1.0 + share.min()))])
        assumed[-1] += f", and down to {100.0 * share.min():.0f} % of it where pressure fell, first at {first:.0f} s"
    speed = np.asarray(share * rig.hydraulics.reference_flow / rig.mud_pump.displacement)
    return speed, tuple(moment for moment, _ in steps)
