"""Motion of a block that was not logged: the standpipe pressure shows the weight on the bit that it made up for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.log_inputs.off_bottom_pressure import off_bottom_factor, pump_runs
from slider_drilling.rig import Rig

_SMOOTHING_S = 10.0  # of the pressure: weight on bit follows a block no faster
_MAX_PRESSURE_ERROR = 0.2  # of the rig file's circulating pressure
# s for which the block has one rate; the fewest and the most such stretches of a run.
_STRETCH_S, _MIN_STRETCHES, _MAX_STRETCHES = 20.0, 3, 24
_MIN_TURNING = 0.5  # of a stretch; with less rotation friction holds the weight and pressure shows no block


def reconstruct_block(
    time: Array, turning: NDArray[np.bool_], pump: Array, pressure_time: Array, pressure: Array, rig: Rig
) -> tuple[Array, Array]:
    """A block lowered at the constant rate under which the motor would give about the measured pressure.

    Pressure above that of circulation is the motor's and gives the weight on bit. The block makes up for what the bit
    drills under that weight and for the shortening of the string. Friction holds some of the motion back for a while,
    so a single one of the stretches (`rate_knots`) is wrong by more than a driller's rates differ. All therefore get
    the mean rate of those in which the drive turns, upward rates counted as 0. A fit starts here.

    Args:
        time: s, (n,).
        turning: Whether the top drive turns, (n,).
        pump: Pump speed, rad/s, (n,).
        pressure_time, pressure: Standpipe pressure, s and Pa, (m,), finite.

    Returns:
        Position m and speed m/s of the block, (n,) each.
    """
    motor, weight = rig.motor, _weight_on_bit(time, pump, pressure_time, pressure, rig)
    load = weight * rig.bit.lever / motor.torque_per_pressure / motor.max_pressure
    bit = pump * rig.mud_pump.displacement / motor.displacement * (1.0 - motor.leak * load**2)  # rev/s
    drilled = weight * bit / rig.bit.depth_of_cut_stiffness
    position = cumulative_trapezoid(drilled, time, initial=0.0) + (weight - weight[0]) / rig.string.axial_stiffness
    knots = rate_knots(time)
    rates = np.diff(np.interp(knots, time, position)) / np.diff(knots)
    stretch = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, rates.size - 1)
    samples = np.bincount(stretch, minlength=rates.size)
    usable = np.bincount(stretch, turning, rates.size) >= _MIN_TURNING * samples
    rate = float(np.mean(np.maximum(rates[usable] if usable.any() else rates, 0.0)))
    return rate * (time - time[0]), np.full_like(time, rate)


def rate_knots(time: Array) -> Array:
    """Ends (k + 1,) s of the k stretches, of equal length, in each of which such a block has one rate."""
    duration = float(time[-1] - time[0])
    count = int(np.clip(round(duration / _STRETCH_S), _MIN_STRETCHES, _MAX_STRETCHES))
    return np.linspace(time[0], time[-1], count + 1)


def _weight_on_bit(time: Array, pump: Array, pressure_time: Array, pressure: Array, rig: Rig) -> Array:
    """Weight on bit (n,) N from the motor's part of the pressure, which arrives late (mud sound, sensor lag)."""
    motor = rig.motor
    late = rig.string.length / rig.mud.sound_speed + rig.hydraulics.lag
    needed = rig.circulation_at(pump)
    measured = _moving_average(time, np.interp(time + late, pressure_time, pressure))
    running = pump_runs(needed)
    if not running.any():
        return np.zeros_like(time)
    factor = off_bottom_factor(measured[running], needed[running])
    factor = float(np.clip(factor, 1.0 - _MAX_PRESSURE_ERROR, 1.0 + _MAX_PRESSURE_ERROR))
    of_motor = np.clip(measured - factor * _moving_average(time, needed), 0.0, motor.pressure_at_stall)
    return np.where(running, of_motor, 0.0) * motor.torque_per_pressure / rig.bit.lever


def _moving_average(time: Array, values: Array) -> Array:
    """Mean (n,) over what lies within half of the smoothing time on either side."""
    total = cumulative_trapezoid(values, time, initial=0.0)
    begin, end = (np.clip(time + side * _SMOOTHING_S, time[0], time[-1]) for side in (-0.5, 0.5))
    return np.asarray((np.interp(end, time, total) - np.interp(begin, time, total)) / np.maximum(end - begin, 1e-9))
