"""What sensors show of a simulation: lag, gain, offset and delay of readings, friction of the sheaves, and where the
toolface is zero."""

from __future__ import annotations

import numpy as np

from slider_drilling.diagnosis.nuisance import TOOL_FACE_OFFSET, hook_load_reading, torque_reading
from slider_drilling.diagnosis.rig_changes import with_rig_changes
from slider_drilling.drillstring import Commands, Response
from slider_drilling.gap.model import Array, Values
from slider_drilling.rig import Rig

# Parameters that the plant does not know: they act on readings alone.
READINGS = frozenset((TOOL_FACE_OFFSET, *(each.name for each in (*hook_load_reading(), *torque_reading()))))
_NEUTRAL_READING = (("gain", 1.0), ("offset", 0.0), ("delay", 0.0))
# m/s of block speed, below which the friction of the sheaves is not fully turned round. A choice, for which no number
# was found in print: a fifth of the speed of lowering at 9 m/h, so that a block that drills has all of it.
SHEAVE_REVERSAL_SPEED = 5e-4


def direction_of_block(commands: Commands, time: Array) -> Array:
    """(n,) from -1, raised, to 1, lowered, at the times, s."""
    return np.tanh(np.interp(time, commands.time, commands.block_speed) / SHEAVE_REVERSAL_SPEED)


def read_hook_load(load: Array, moving: Array, values: Values) -> Array:
    """The hook load as it is read at the dead line.

    Args:
        load: (n,) N, at the hook.
        moving: (n,) direction of the block, see `direction_of_block`.
        values: Calibrated values of `hook_load_reading`.
    """
    values = with_rig_changes(values)
    gain, offset = values.get("hook_load_gain", 1.0), values.get("hook_load_offset", 0.0)
    return np.asarray(gain * load + offset - values.get("sheave_friction", 0.0) * moving)


def read_torque(torque: Array, time: Array, values: Values) -> Array:
    """Surface torque as it is read.

    Args:
        torque: (n,) N m, at the sensor.
        time: (n,) s.
        values: Calibrated values of `torque_reading`.
    """
    gain, offset, delay = (values.get(f"torque_{name}", neutral) for name, neutral in _NEUTRAL_READING)
    if (gain, offset, delay) == (1.0, 0.0, 0.0):
        return torque
    late = np.interp(time - delay, time, torque) if delay != 0.0 else torque
    return np.asarray(gain * late + offset)


def read_tool_face(tool_face: Array, values: Values) -> Array:
    """The toolface as the MWD reads it: from the zero of its own, rad; values: of `TOOL_FACE_OFFSET`."""
    return np.asarray(tool_face + values.get(TOOL_FACE_OFFSET, 0.0))


def sensor_lag(rig: Rig, channel: str) -> float:
    """First-order lag, s, of a surface sensor by the rig file; 0 for the toolface."""
    sensor = getattr(rig.sensors, channel, None)
    return float(sensor.lag) if sensor is not None else 0.0


def sample_channel(response: Response, channel: str, times: Array, lag: float) -> Array:
    """A channel as its sensor shows it: (n,) at the sensor's times, s, behind its first-order lag, s."""
    values = getattr(response, channel)
    if lag > 0.0:
        values = _lagged(response.time, values, lag)
    if times.size == response.time.size and np.array_equal(times, response.time):
        return np.asarray(values)
    return np.interp(times, response.time, values)


def _lagged(time: Array, values: Array, lag: float) -> Array:
    kept = np.exp(-np.diff(time) / lag)
    out = np.empty_like(values)
    out[0] = values[0]
    for index, share in enumerate(kept):
        out[index + 1] = share * out[index] + (1.0 - share) * values[index + 1]
    return out
