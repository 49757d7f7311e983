"""The state in which a log begins: a string that hangs at rest, or one that is loaded already."""

from __future__ import annotations

import numpy as np

from slider_drilling.drillstring.initial_state import InitialState
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.recorded_channels import Commands
from slider_drilling.log.rig_log import RigLog
from slider_drilling.rig import Rig
from slider_drilling.wellbore.static_loads import static_loads

LOADED_START_NOTE = (
    "the log begins while the string is under load: its initial torque, weight on bit and drag are those of the log's "
    "first second"
)
_TURNING = 0.05  # of the drive's usual top speed
# The hook load differs from the hanging weight where it does so by this fraction of the weight, and by this many
# standard deviations of its noise.
_LOADED, _MIN_SIGMAS = 0.02, 5.0
_FIRST_S = 1.0
_REVERSALS = 2  # of the drive, after which every part of the string that they reach has slid both ways
_MAX_ROUND_TRIPS, _MAX_FRACTION = 8.0, 0.2  # of a torsional wave, for a string that only turns one way; of a log
_ELEMENTS = 100


def infer_initial_state(log: RigLog, rig: Rig, commands: Commands) -> InitialState:
    """The state in which a log's run begins, as the log's first second shows it.

    The string is loaded where its drive turns at the first sample, or where the hook load is not that of its weight.
    Then the drive's torque is the measured one, the standpipe pressure gives the weight on bit, and friction along the
    hole holds what of the string's weight is neither on the hook nor on the bit.

    Returns:
        A string that hangs at rest, unless the log shows otherwise.
    """
    speed = np.abs(commands.top_drive_speed)
    turns = float(speed[0]) > _TURNING * float(np.quantile(speed, 0.95)) > 0.0
    missing = _missing_hook_load(log, rig)
    noise = _MIN_SIGMAS * rig.sensors.hook_load.noise
    if not turns and (missing is None or abs(missing[0]) < max(noise, _LOADED * missing[1])):
        return InitialState()
    torque = None if log.top_drive is None else _first_value(log.top_drive.time, log.top_drive.effort)
    weight = _weight_on_bit(log, rig, commands)
    if weight is None:
        weight = 0.0 if missing is None else float(np.clip(missing[0], 0.0, _stall_weight(rig)))
    drag = 0.0 if missing is None else _axial_friction_share(rig, weight, *missing)
    return InitialState(
        weight_on_bit=weight, axial_friction_share=drag, surface_torque=torque if torque is not None else 0.0
    )


def initial_transient_end(rig: Rig, commands: Commands) -> float:
    """The time (s) after which the motion of the string no longer depends on the state in which the log began."""
    time, speed = commands.time, commands.top_drive_speed
    fast = np.abs(speed) > _TURNING * float(np.max(np.abs(speed), initial=0.0))
    reversals = np.flatnonzero(np.diff(np.sign(speed[fast])) != 0.0)
    round_trip = 2.0 * rig.string.length / rig.string.twist_speed
    after = float(time[fast][reversals[_REVERSALS - 1] + 1] - time[0]) if reversals.size >= _REVERSALS else 0.0
    return float(time[0] + min(max(after, _MAX_ROUND_TRIPS * round_trip), _MAX_FRACTION * (time[-1] - time[0])))


def _weight_on_bit(log: RigLog, rig: Rig, commands: Commands) -> float | None:
    """Initial weight on bit, N, from standpipe pressure above that of circulation; None without pressure or flow."""
    pressure = log.standpipe_pressure
    first = None if pressure is None else _first_value(pressure.time, pressure.value)
    pump_speed = float(commands.pump_speed[0])
    if first is None or pump_speed <= 0.0:
        return None
    needed = float(rig.circulation_at(pump_speed))
    return float(np.clip((first - needed) * rig.motor.torque_per_pressure / rig.bit.lever, 0.0, _stall_weight(rig)))


def _stall_weight(rig: Rig) -> float:
    """Weight on bit at which the motor stalls, N."""
    return rig.motor.torque_per_pressure * rig.motor.pressure_at_stall / rig.bit.lever


def _axial_friction_share(rig: Rig, weight: float, missing: float, hanging: float) -> float:
    """Fraction (-1 to 1) of the friction along the hole that holds what is missing on the hook and not on the bit.

    weight: On the bit, N; missing, hanging: See `_missing_hook_load`.
    """
    held = missing - weight
    sliding = static_loads(rig, float(np.sign(held)), weight_on_bit=weight, elements=_ELEMENTS).hook_load
    limit = abs(hanging - weight - sliding)
    return float(np.clip(held / limit, -1.0, 1.0)) if limit > 0.0 else 0.0


def _missing_hook_load(log: RigLog, rig: Rig) -> tuple[float, float] | None:
    """Hanging weight minus the first hook load, and the hanging weight, N; None without a hook load."""
    first = None if log.draw_works is None else _first_value(log.draw_works.time, log.draw_works.effort)
    if first is None:
        return None
    hanging = static_loads(rig, elements=_ELEMENTS).hook_load
    return hanging - first, hanging


def _first_value(time: Array, values: Array) -> float | None:
    """Value at the first time, by a straight line through the first second; None where nothing was measured then."""
    known = np.isfinite(values) & (time <= time[0] + _FIRST_S)
    if not known.any():
        return None
    if np.count_nonzero(known) < 3:
        return float(values[known][0])
    return float(np.polynomial.Polynomial.fit(time[known], values[known], 1)(time[0]))
