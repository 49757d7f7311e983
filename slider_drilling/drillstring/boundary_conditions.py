"""Boundary conditions of the compiled step: block and top drive above; bit, motor and mud below; the sensors.

Each function loops over the lanes and selects values instead of branching, so that the compiler can vectorise it.
In their arguments ``e``, ``c`` and ``s`` are the arrays of `kernel_arrays`, ``time`` and ``dt`` are s.
"""

from __future__ import annotations

import math
from typing import Any

from slider_drilling.drillstring.kernel_arrays import Array, Elements, KernelState, Lanes
from slider_drilling.process.jit_cache import INLINED_JIT_OPTIONS, njit
from slider_drilling.rig import FLOW_EXPONENT

_STILL = 0.1  # rad/s, below which a drive's own friction fades: measured speeds are rarely zero

# Without "fastmath" vectorised and scalar code round alike: a lane of a batch equals its single run bit for bit.
_LANES: dict[str, Any] = {**INLINED_JIT_OPTIONS, "fastmath": False}


@njit(**_LANES)
def move_top(lanes, time, angle, block, heaving, offset: Array, next_offset: Array, u, c: Lanes, s: KernelState):
    """Row 0 of positions and rotations: the block with its heave, and the top drive through its backlash.

    Args:
        angle, block: Top-drive angle (rad) and block position (m) now.
        heaving: Whether any block heaves.
        offset, next_offset: (lanes,) m that the blocks are lower, before and after this interval, or empty.
        u: Fraction of the interval that has passed.
    """
    for k in range(lanes):
        s.position[k] = block
    for k in range(len(offset)):
        s.position[k] += offset[k] + u * (next_offset[k] - offset[k])
    if heaving:
        for k in range(lanes):
            s.position[k] += c.heave_amplitude[k] * math.sin(c.heave_frequency[k] * time + c.heave_phase[k])
    for k in range(lanes):
        # Inside the dead zone the string turns freely. Beyond it the top spring takes what is left of the angle.
        drive = angle + s.observer_angle[k]
        ahead = drive - s.rotation[lanes + k]
        s.rotation[k] = drive - min(max(ahead, -c.backlash[k]), c.backlash[k])


@njit(**_LANES)
def push_axial_tools(lanes, time, e: Elements, c: Lanes, s: KernelState):
    """Axial speeds after the push of the axial oscillation tools."""
    for k in range(lanes):
        if c.tool_force[k] > 0.0:
            j = int(c.tool_row[k]) * lanes + k
            s.speed[j] += e.axial_push[j] * c.tool_force[k] * math.sin(c.tool_frequency[k] * time)


@njit(**_LANES)
def solve_bit(lanes, elements, dt, time, pump, torque_factor, e: Elements, c: Lanes, s: KernelState):
    """Bit, rock and motor: their loads slow the lowest element down (`model.md` section 4).

    Weight on bit is proportional to the bit's speed, with a constant that is large against mass / dt. The speed at
    the end of the step is therefore solved for (implicit). Above its pressure limit the motor stalls until the bit is
    picked up.

    Args:
        pump: Pump speed, rad/s.
        torque_factor: Multiplies the bit torque per weight.
    """
    bit, row = (elements - 1) * lanes, elements * lanes
    for k in range(lanes):
        load = s.motor_pressure[k] / c.stall_pressure[k]
        flow = pump * c.pump_displacement[k]
        motor_speed = 2.0 * math.pi * flow / c.motor_displacement[k] * (1.0 - c.leak[k] * load * load)
        free = s.speed[bit + k]
        push = e.axial_push[bit + k]
        touches = (free > 0.0) & (s.position[row + k] + dt * free >= s.hole_bottom[k])
        factor = c.formation_factor[k] if time >= c.formation_time[k] else 1.0
        slowed = free / (1.0 + push * (c.cutting_stiffness[k] * factor) * 2.0 * math.pi / motor_speed)
        cutting = slowed if (s.stalled[k] <= 0.0) & (motor_speed > 0.0) else 0.0
        speed = cutting if touches else free
        weight = (free - speed) / push if touches else 0.0
        deeper = max(s.hole_bottom[k], s.position[row + k] + dt * speed)
        s.hole_bottom[k] = deeper if touches else s.hole_bottom[k]
        s.speed[bit + k] = speed
        s.weight_on_bit[k] = weight
        demanded = torque_factor * c.bit_lever[k] * weight
        limit = c.torque_per_pressure[k] * c.stall_pressure[k]
        stalled = 0.0 if weight == 0.0 else s.stalled[k]
        stalled = 1.0 if (motor_speed > 0.0) & (demanded >= limit) else stalled
        given = demanded if motor_speed > 0.0 else 0.0
        torque = limit if stalled > 0.0 else given
        s.stalled[k] = stalled
        s.bit_torque[k] = torque
        s.motor_pressure[k] = torque / c.torque_per_pressure[k]
        s.rotation_speed[bit + k] -= e.torsional_push[bit + k] * torque


@njit(**_LANES)
def update_circulating_pressure(lanes, pump, c: Lanes, s: KernelState):
    """Standpipe pressure of this flow with an idle motor (`model.md` section 4). pump: rad/s."""
    for k in range(lanes):
        flow = max(pump * c.pump_displacement[k], 0.0) / c.reference_flow[k]
        s.circulating_pressure[k] = c.circulating_pressure[k] * flow**FLOW_EXPONENT


@njit(**_LANES)
def update_standpipe_pressure(lanes, steps, c: Lanes, s: KernelState):
    """Circulating pressure plus the motor's, one sound travel time late, through a first-order lag.

    steps: Time steps taken so far; they index the ring buffer of motor pressures on their way up.
    """
    delay = len(s.pressure_pulses) // lanes
    if delay == 0:
        for k in range(lanes):
            s.standpipe_pressure[k] += c.pressure_gain[k] * (
                s.circulating_pressure[k] + s.motor_pressure[k] - s.standpipe_pressure[k]
            )
        return
    slot = (steps % delay) * lanes
    for k in range(lanes):
        arriving = s.pressure_pulses[slot + k]
        s.pressure_pulses[slot + k] = s.motor_pressure[k]
        s.standpipe_pressure[k] += c.pressure_gain[k] * (
            s.circulating_pressure[k] + arriving - s.standpipe_pressure[k]
        )


@njit(**_LANES)
def write_channels(lanes, elements, e: Elements, c: Lanes, s: KernelState, out: Array):
    """Write one row of `kernel_arrays.CHANNELS` into out, (channels, lanes)."""
    bit, row = (elements - 1) * lanes, elements * lanes
    for k in range(lanes):
        out[0, k] = s.sensed_torque[k] + c.torque_bias[k]
        out[1, k] = e.axial_spring[k] * (s.position[lanes + k] - s.position[k])
        out[2, k] = s.standpipe_pressure[k]
        out[3, k] = s.rotation[row + k] + s.tool_face_offset[k]
        out[4, k] = s.rotation_speed[bit + k]
        out[5, k] = s.bit_torque[k]
        out[6, k] = s.weight_on_bit[k]
        out[7, k] = s.motor_pressure[k]
        out[8, k] = s.position[row + k] + s.depth_offset[k]
        out[9, k] = s.speed[bit + k]


@njit(**_LANES)
def update_sensed_torque(lanes, speed, acceleration, e: Elements, c: Lanes, s: KernelState):
    """Torque at the quill or at the drive's motor, through the torque sensor's gain and lag.

    `write_channels` adds the sensor's bias: a lag that starts settled passes a constant unchanged.

    Args:
        speed, acceleration: Of the top drive, rad/s and rad/s2.
    """
    direction = speed / math.sqrt(speed * speed + _STILL * _STILL)
    for k in range(lanes):
        torque = e.torsional_spring[k] * (s.rotation[k] - s.rotation[lanes + k])
        torque += c.motor_inertia[k] * acceleration + c.motor_friction[k] * direction
        s.sensed_torque[k] += c.torque_gain[k] * (c.torque_scale[k] * torque - s.sensed_torque[k])


@njit(**_LANES)
def apply_observer(lanes, dt, measured, c: Lanes, s: KernelState):
    """Weak observer: the torque that was measured turns the drive a little towards the torque that is simulated.

    ``offset' = gain e / Z - offset / tau``, with Z the string's wave impedance at the top and e the error ``measured -
    sensed``, smoothed by ``e' = (measured - sensed - e) / T``. For gains from 0 to 1 this is passive, whatever T: it
    absorbs part of the waves from below and adds none.

    Args:
        measured: Surface torque, N m; NaN where none was measured.
    """
    known = not math.isnan(measured)
    for k in range(lanes):
        s.observer_angle[k] -= dt * c.observer_leak[k] * s.observer_angle[k]
        error = measured - (s.sensed_torque[k] + c.torque_bias[k]) if known else 0.0
        s.observer_error[k] += c.observer_response[k] * (error - s.observer_error[k])
        s.observer_angle[k] += dt * c.observer_gain[k] * s.observer_error[k]
