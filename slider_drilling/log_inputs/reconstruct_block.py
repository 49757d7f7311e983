"""How a block was lowered that nobody logged: the standpipe pressure saw the weight on the bit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.rig import Rig

_SMOOTH_S = 10.0  # over which pressure is averaged: weight on a bit follows a block no faster
_OFF_BOTTOM = 0.02  # share of a log in which its bit is taken to carry no weight
_TUNED = 0.2  # by which the file's circulating pressure may be off
# s that a block is taken to have one rate; the fewest and the most such stretches of a run.
_STRETCH_S, _FEWEST, _MOST = 20.0, 3, 24
_TURNING = 0.5  # of a stretch: where the drive turns less friction keeps the weight, and pressure tells of no block


def reconstruct_block(
    time: Array, turning: NDArray[np.bool_], pump: Array, seen: Array, pressure: Array, rig: Rig
) -> tuple[Array, Array]:
    """Position m and speed m/s (n,) of a block under which the motor would give about the pressure that was measured.

    time, turning, pump: (n,) s, whether the top drive turns, rad/s; seen, pressure: (m,), s, Pa at the standpipe,
    finite. Pressure above that of circulation is the motor's, and gives the weight on the bit; the block makes up for
    what the bit drills under it and for what the string is shortened by. Friction holds some of that back for a while,
    and gives it later: what pressure tells of one of the `stretches` is off by more than a driller's rates differ, so
    that all have the mean, of those in which the drive turns and none taken to be raised. This is where a fit begins.
    """
    motor, weight = rig.motor, _weight(time, pump, seen, pressure, rig)
    share = weight * rig.bit.lever / motor.torque_per_pressure / motor.max_pressure
    bit = pump * rig.mud_pump.displacement / motor.displacement * (1.0 - motor.leak * share**2)  # rev/s
    drilled = weight * bit / rig.bit.depth_of_cut_stiffness
    position = cumulative_trapezoid(drilled, time, initial=0.0) + (weight - weight[0]) / rig.string.axial_stiffness
    knots = rate_knots(time)
    rates = np.diff(np.interp(knots, time, position)) / np.diff(knots)
    within = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, rates.size - 1)
    told = np.bincount(within, turning, rates.size) >= _TURNING * np.bincount(within, minlength=rates.size)
    rate = float(np.mean(np.maximum(rates[told] if told.any() else rates, 0.0)))
    return rate * (time - time[0]), np.full_like(time, rate)


def rate_knots(time: Array) -> Array:
    """(k + 1,) s: the ends of the k stretches, of equal length, in each of which such a block has one rate."""
    duration = float(time[-1] - time[0])
    count = int(np.clip(round(duration / _STRETCH_S), _FEWEST, _MOST))
    return np.linspace(time[0], time[-1], count + 1)


def _weight(time: Array, pump: Array, seen: Array, pressure: Array, rig: Rig) -> Array:
    """(n,) N on the bit by the motor's share of the pressure, its sound and its sensor's lag being late."""
    hydraulics, motor = rig.hydraulics, rig.motor
    late = rig.string.length / rig.mud.sound_speed + hydraulics.lag
    flow = np.maximum(pump * rig.mud_pump.displacement, 0.0) / hydraulics.reference_flow
    needed = rig.circulating_pressure * flow**1.8
    measured = _averaged(time, np.interp(time + late, seen, pressure))
    running = needed > 0.5 * float(needed.max(initial=0.0))
    if not running.any():
        return np.zeros_like(time)
    tuned = float(np.quantile(measured[running] / needed[running], _OFF_BOTTOM))
    tuned = float(np.clip(tuned, 1.0 - _TUNED, 1.0 + _TUNED))
    of_motor = np.clip(measured - tuned * _averaged(time, needed), 0.0, motor.max_pressure)
    return np.where(running, of_motor, 0.0) * motor.torque_per_pressure / rig.bit.lever


def _averaged(time: Array, values: Array) -> Array:
    """(n,) mean over what lies within half of the smoothing time."""
    total = cumulative_trapezoid(values, time, initial=0.0)
    begin, end = (np.clip(time + side * _SMOOTH_S, time[0], time[-1]) for side in (-0.5, 0.5))
    return np.asarray((np.interp(end, time, total) - np.interp(begin, time, total)) / np.maximum(end - begin, 1e-9))
