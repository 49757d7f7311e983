"""The commands with which a log's own measurements drive the plant."""

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
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import JointSeries
from slider_drilling.log_inputs.fill_drive_gaps import fill_drive_gaps, is_undersampled
from slider_drilling.log_inputs.fill_pump_gaps import fill_pump_gaps
from slider_drilling.log_inputs.fuse_position_and_speed import fuse_position_and_speed
from slider_drilling.log_inputs.reconstruct_block import reconstruct_block
from slider_drilling.log_inputs.reconstruct_flow import PressureSteps, flow_fraction, pressure_steps
from slider_drilling.rig import Rig, check_duration
from slider_drilling.units import Quantity, Text, sentence

_TURNING = 0.05  # rad/s, from which a drive counts as turning
_FINE_S = 0.1  # between commands, where a log's samples are farther apart


@dataclass(frozen=True)
class LogCommands:
    """Commands from a log, and what was assumed in place of what the log lacks.

    Attributes:
        commands: What drives the plant.
        assumptions: One sentence for each thing that the log lacks.
        block_logged: Whether the log holds the block's motion.
        block_from_pressure: Whether the block's motion is reconstructed from standpipe pressure.
        flow_step_times: s at which the flow may have changed; None where the log holds the pump.
    """

    commands: Commands
    assumptions: tuple[Text, ...]
    block_logged: bool = True
    block_from_pressure: bool = False
    flow_step_times: tuple[float, ...] | None = None

    @cached_property
    def acceleration(self) -> Array:
        """Acceleration of the top drive at the commands' times, rad/s2, (n,); see `drive_acceleration`."""
        from slider_drilling.log_inputs.drive_acceleration import drive_acceleration  # slow to import, rarely needed

        return drive_acceleration(self.commands.time, self.commands.top_drive_speed)

    def acceleration_for(self, rig: Rig) -> Array | None:
        """`acceleration` if the rig's torque reading depends on it, else None: a long log takes seconds."""
        return self.acceleration if rig.effects.torque_at_motor.inertia > 0.0 else None


def commands_from_log(log: RigLog, rig: Rig) -> LogCommands:
    """Measured top-drive angle, block position and pump speed at the top drive's sample times.

    Angle and speed are used together: joining a 10 Hz angle by straight lines costs 100 to 360 N m of surface torque. A
    speed that the log lacks, or holds as zero throughout, is the position's slope; a missing position is the speed's
    integral. In gaps the motion gets corners (`fill_drive_gaps`), and the pump its changes of speed
    (`fill_pump_gaps`).

    Without drawworks the block is reconstructed from standpipe pressure (`reconstruct_block`), and stands still without
    pressure. Without a pump the flow is the rig file's reference flow, as far as pressure agrees, and zero without
    pressure.

    Raises:
        InputError: For a log without a top drive or with fewer than two usable samples of it, and for a rig whose
            friction would drift to nothing meanwhile.
    """
    if log.top_drive is None:
        raise InputError(log.lack_of_top_drive("drives the plant"))
    drive = _usable(log.top_drive)
    count = len(drive.time)
    if count < 2:
        raise InputError(f"{log.source}: top_drive/joint_states has {count} usable sample(s); at least two needed")
    check_duration(rig, float(drive.time[-1] - drive.time[0]), log.rig_source or log.source)
    assumptions: list[Text] = []
    time, angle, speed = _drive_motion(log, drive, rig, assumptions)
    pump, steps = _pump_speed(log, rig, time, assumptions)
    block, block_speed, lowered = np.zeros_like(time), np.zeros_like(time), None
    works = None if log.draw_works is None else _usable(log.draw_works)
    block_logged = works is not None and len(works.time) >= 2
    if works is not None and block_logged:
        motion = _motion(works, assumptions, "the block's position", "m")
        moved = Commands(works.time, *motion, *motion, np.zeros_like(works.time)).resampled(time)
        block, block_speed = moved.block_position, moved.block_speed
    elif (lowered := _block_from_pressure(log, rig, time, speed, pump)) is not None:
        assumptions.append("the log holds no drawworks: the block's motion is reconstructed from standpipe pressure")
        block, block_speed = lowered
    else:
        assumptions.append("the log holds no drawworks: the block is assumed to stand still")
    commands = Commands(time, angle, speed, block, block_speed, pump)
    return LogCommands(commands, tuple(assumptions), block_logged, lowered is not None, steps)


def unfilled_field(series: JointSeries) -> str | None:
    """"position" or "velocity" where it is zero in every sample although the other moves: the recorder left it out."""
    known = np.isfinite(series.position) & np.isfinite(series.velocity)
    if np.count_nonzero(known) < 3:
        return None
    moves, turns = np.ptp(series.position[known]) > 0.0, np.any(series.velocity[known])
    still = not np.any(series.position[known])
    return "position" if turns and still else "velocity" if moves and not turns else None


def _drive_motion(log: RigLog, drive: JointSeries, rig: Rig, assumptions: list[Text]) -> tuple[Array, Array, Array]:
    """Time, angle and speed of the top drive.

    In its gaps there are the corners of the motion, and the times at which block or pump have samples. An undersampled
    motion is sampled finely: its own samples do not show how it reverses.
    """
    coarse = is_undersampled(drive.time)
    both_known = np.isfinite(drive.position).any() and np.isfinite(drive.velocity).any()
    time, angle, speed = drive.time, *_motion(drive, assumptions, "the top drive's angle", "rad")
    if both_known or not coarse:
        time, angle, speed = fill_drive_gaps(time, angle, speed, rig.top_drive.max_acceleration)
    if coarse:
        wanted = _fine_times(drive.time)
    else:
        others = [series.time for series in (log.draw_works, log.mud_pump) if series is not None]
        in_gaps = times_in_gaps(drive.time, np.concatenate([*others, np.empty(0)]))
        if in_gaps.size == 0:
            return time, angle, speed
        wanted = np.union1d(time, in_gaps)
    still = np.zeros_like(time)
    motion = Commands(time, angle, speed, still, still, still).resampled(wanted)
    return motion.time, motion.top_drive_angle, motion.top_drive_speed


def _fine_times(time: Array) -> Array:
    """The times (n,), and between each two as many evenly spaced ones as make steps of at most a tenth of a second."""
    pieces = [
        np.linspace(begin, end, math.ceil((end - begin) / _FINE_S - 1e-6), endpoint=False)
        for begin, end in itertools.pairwise(time)
    ]
    return np.concatenate([*pieces, time[-1:]])


def _usable(series: JointSeries) -> JointSeries:
    """Samples with a position or a velocity, where a field that the recorder left out counts as missing."""
    if (empty := unfilled_field(series)) is not None:
        nothing: dict[str, Any] = {empty: np.full_like(series.time, np.nan)}
        series = replace(series, **nothing)
    keep = np.isfinite(series.position) | np.isfinite(series.velocity)
    arrays = (series.time, series.arrival, series.position, series.velocity, series.effort)
    return JointSeries(*(array[keep] for array in arrays))


def _motion(series: JointSeries, assumptions: list[Text], name: str, unit: str) -> tuple[Array, Array]:
    """Position and velocity (n,): each from the other where the log lacks it, both fused where they disagree."""
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
    fused, speed = fuse_position_and_speed(time, position, velocity)
    if fused is not position:
        errors = (float(np.sqrt(np.mean(square**2))) for square in (fused - position, speed - velocity))
        distance, speed_error = (Quantity(rms, of, 2) for rms, of in zip(errors, (unit, f"{unit}/s"), strict=True))
        assumptions.append(
            sentence(
                f"{name} and its speed disagree: their most likely common motion is used, ",
                distance, " and ", speed_error, " RMS away",
            )
        )
    return fused, speed


def _block_from_pressure(log: RigLog, rig: Rig, time: Array, speed: Array, pump: Array) -> tuple[Array, Array] | None:
    """Position and speed of the block, reconstructed from standpipe pressure; None without one."""
    if log.standpipe_pressure is None:
        return None
    known = np.isfinite(log.standpipe_pressure.value)
    if np.count_nonzero(known) < 2:
        return None
    pressure_time, pressure = log.standpipe_pressure.time[known], log.standpipe_pressure.value[known]
    return reconstruct_block(time, np.abs(speed) > _TURNING, pump, pressure_time, pressure, rig)


def _pump_speed(
    log: RigLog, rig: Rig, time: Array, assumptions: list[Text]
) -> tuple[Array, tuple[float, ...] | None]:
    """Pump speed (n,) rad/s, and the times (s) at which pressure steps where the log lacks the pump."""
    pressure = log.standpipe_pressure
    if log.mud_pump is not None:
        known = np.isfinite(log.mud_pump.velocity)
        if known.any():
            pump_time, speed = log.mud_pump.time[known], log.mud_pump.velocity[known]
            if pressure is not None:
                pump_time, speed = fill_pump_gaps(pump_time, speed, pressure.time, pressure.value)
            return np.interp(time, pump_time, speed), None
    if pressure is None:
        assumptions.append("the log holds neither pump nor standpipe pressure: the pump is assumed to be off")
        return np.zeros_like(time), ()
    assumption = "the log holds no pump: the flow is assumed to be the rig file's reference flow"
    known = np.isfinite(pressure.value)
    fraction = np.ones_like(time)
    steps: PressureSteps = ()
    if known.any():
        pressure_time, value = pressure.time[known], pressure.value[known]
        steps = pressure_steps(pressure_time, value, rig)
        fraction = np.interp(time, pressure_time, flow_fraction(pressure_time, value, steps, rig))
    if fraction.min() < 1.0:
        first = float(time[np.argmin(fraction > 0.5 * (1.0 + fraction.min()))])
        lowest = 100.0 * fraction.min()
        assumption += f", and down to {lowest:.0f} % of it where pressure fell, first at {first:.0f} s"
    assumptions.append(assumption)
    speed = np.asarray(fraction * rig.hydraulics.reference_flow / rig.mud_pump.displacement)
    return speed, tuple(moment for moment, _ in steps)
