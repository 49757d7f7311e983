"""What a log begins with: a string that hangs at rest, or one that was at work already."""

from __future__ import annotations

import numpy as np

from slider_drilling.drillstring.initial_state import InitialState
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.recorded_channels import Commands
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig
from slider_drilling.wellbore.static_loads import static_loads

LOADED_START_NOTE = (
    "the log begins while the string is at work: its torque, its weight on the bit and its drag are those of the first "
    "second"
)
_TURNING = 0.05  # of the speed that the drive reaches
_LOADED, _NOISES = 0.02, 5.0  # of the weight that hangs, and of the hook load's noise, by which it hangs otherwise
_FIRST_S = 1.0
_TURNS = 2  # of the drive, after which every part of the string that feels it has slid both ways
_ECHOES, _MOST = 8.0, 0.2  # round trips of a twist for a string that only turns one way; of a log


def infer_initial_state(log: RigLog, rig: Rig, commands: Commands) -> InitialState:
    """How a log's run begins, as its first second shows it; a string that hangs at rest where it shows nothing else.

    At work is a string whose drive turns at the first sample, or whose hook load is not that of its weight. Then the
    drive's torque is the one measured, the weight on the bit what standpipe pressure tells, and friction holds what of
    the string's weight is neither on the hook nor on the bit.
    """
    speed = np.abs(commands.top_drive_speed)
    turns = float(speed[0]) > _TURNING * float(np.quantile(speed, 0.95)) > 0.0
    missing = _missing(log, rig)
    noise = _NOISES * rig.sensors.hook_load.noise
    if not turns and (missing is None or abs(missing[0]) < max(noise, _LOADED * missing[1])):
        return InitialState()
    torque = None if log.top_drive is None else _first(log.top_drive.time, log.top_drive.effort)
    weight = _weight(log, rig, commands)
    if weight is None:
        weight = 0.0 if missing is None else float(np.clip(missing[0], 0.0, _most(rig)))
    drag = 0.0 if missing is None else _drag(rig, weight, *missing)
    return InitialState(
        weight_on_bit=weight, axial_friction_share=drag, surface_torque=torque if torque is not None else 0.0
    )


def _weight(log: RigLog, rig: Rig, commands: Commands) -> float | None:
    """N on the bit at the start by the standpipe pressure over that of circulation; None where there is neither."""
    pressure = log.standpipe_pressure
    first = None if pressure is None else _first(pressure.time, pressure.value)
    flow = float(commands.pump_speed[0]) * rig.mud_pump.displacement / rig.hydraulics.reference_flow
    if first is None or flow <= 0.0:
        return None
    needed = rig.circulating_pressure * flow**1.8
    return float(np.clip((first - needed) * rig.motor.torque_per_pressure / rig.bit.lever, 0.0, _most(rig)))


def _most(rig: Rig) -> float:
    """N on the bit at which the motor stalls."""
    return rig.motor.torque_per_pressure * rig.motor.max_pressure / rig.bit.lever


def _drag(rig: Rig, weight: float, missing: float, hanging: float) -> float:
    """Share of the friction along the hole that holds what N is missing on the hook and not on the bit."""
    held = missing - weight
    sliding = static_loads(rig, float(np.sign(held)), weight_on_bit=weight, elements=100).hook_load
    most = abs(hanging - weight - sliding)
    return float(np.clip(held / most, -1.0, 1.0)) if most > 0.0 else 0.0


def initial_transient_end(rig: Rig, commands: Commands) -> float:
    """The time s from which a string that was at work when its log began moves as it has been moved since."""
    time, speed = commands.time, commands.top_drive_speed
    fast = np.abs(speed) > _TURNING * float(np.max(np.abs(speed), initial=0.0))
    turns = np.flatnonzero(np.diff(np.sign(speed[fast])) != 0.0)
    echo = 2.0 * rig.string.length / rig.string.twist_speed
    known = float(time[fast][turns[_TURNS - 1] + 1] - time[0]) if turns.size >= _TURNS else 0.0
    return float(time[0] + min(max(known, _ECHOES * echo), _MOST * (time[-1] - time[0])))


def _missing(log: RigLog, rig: Rig) -> tuple[float, float] | None:
    """By how much N the hook load begins below the weight that hangs, and that weight; None without a hook load."""
    first = None if log.draw_works is None else _first(log.draw_works.time, log.draw_works.effort)
    if first is None:
        return None
    hanging = static_loads(rig, elements=100).hook_load
    return hanging - first, hanging


def _first(time: Array, values: Array) -> float | None:
    """Mean of what was measured in the first instants of a series, extrapolated to its first; None without any."""
    known = np.isfinite(values) & (time <= time[0] + _FIRST_S)
    if not known.any():
        return None
    if np.count_nonzero(known) < 3:
        return float(values[known][0])
    return float(np.polynomial.Polynomial.fit(time[known], values[known], 1)(time[0]))
