"""The ends of the string in the compiled step: block and top drive above, bit, motor and mud below, and the sensors.

Each pass goes over the lanes and chooses instead of branching, so that it becomes packed instructions as the passes
over elements do.
"""

from __future__ import annotations

import math
from typing import Any

from slider_drilling.drillstring.kernel_arrays import Array, Elements, KernelState, Lanes
from slider_drilling.process.jit_cache import INLINED_JIT_OPTIONS, njit

_STILL = 0.1  # rad/s, below which a drive's own friction fades: measured speeds are rarely zero

# As written, in packed code and for the lanes left over alike: a lane of a batch is its single run bit for bit.
_LANES: dict[str, Any] = {**INLINED_JIT_OPTIONS, "fastmath": False}


@njit(**_LANES)
def drive_top(lanes, time, angle, block, heaving, lower: Array, lower_next: Array, u, c: Lanes, s: KernelState):
    """Row 0: the block with its heave, the top drive through its backlash.

    heaving: whether any block heaves; lower, lower_next: (lanes,) m by which the blocks are below `block` before and
    behind, u of the way between them; or nothing.
    """
    for k in range(lanes):
        s.position[k] = block
    for k in range(len(lower)):
        s.position[k] += lower[k] + u * (lower_next[k] - lower[k])
    if heaving:
        for k in range(lanes):
            s.position[k] += c.heave_amplitude[k] * math.sin(c.heave_frequency[k] * time + c.heave_phase[k])
    for k in range(lanes):
        # The spring below the drive stretches by what is left of the angle once the dead zone is passed: the string
        # unwinds freely inside it, it is not held there.
        drive = angle + s.pulled[k]
        ahead = drive - s.rotation[lanes + k]
        s.rotation[k] = drive - min(max(ahead, -c.backlash[k]), c.backlash[k])


@njit(**_LANES)
def shake(lanes, time, e: Elements, c: Lanes, s: KernelState):
    """The push of the axial oscillation tools."""
    for k in range(lanes):
        if c.tool_force[k] > 0.0:
            j = int(c.tool_row[k]) * lanes + k
            s.speed[j] += e.axial_push[j] * c.tool_force[k] * math.sin(c.tool_frequency[k] * time)


@njit(**_LANES)
def cut(lanes, elements, dt, time, pump, bite, e: Elements, c: Lanes, s: KernelState):
    """Bit, rock and motor: what the bit takes from the speeds of the lowest element (`model.md` section 4).

    Weight on bit is proportional to the bit's speed, with a constant large against mass / dt, so it is solved for
    the speed at the end of the step. Above its limit the motor stalls until it is picked up.
    """
    bit, place = (elements - 1) * lanes, elements * lanes
    for k in range(lanes):
        share = s.motor_pressure[k] / c.stall_pressure[k]
        flow = pump * c.pump_displacement[k]
        motor_speed = 2.0 * math.pi * flow / c.motor_displacement[k] * (1.0 - c.leak[k] * share * share)
        free = s.speed[bit + k]
        push = e.axial_push[bit + k]
        touches = (free > 0.0) & (s.position[place + k] + dt * free >= s.bottom[k])
        factor = c.formation_factor[k] if time >= c.formation_time[k] else 1.0
        slowed = free / (1.0 + push * (c.cutting_stiffness[k] * factor) * 2.0 * math.pi / motor_speed)
        cutting = slowed if (s.stalled[k] <= 0.0) & (motor_speed > 0.0) else 0.0
        speed = cutting if touches else free
        weight = (free - speed) / push if touches else 0.0
        deeper = max(s.bottom[k], s.position[place + k] + dt * speed)
        s.bottom[k] = deeper if touches else s.bottom[k]
        s.speed[bit + k] = speed
        s.weight_on_bit[k] = weight
        wanted = bite * c.bit_lever[k] * weight
        most = c.torque_per_pressure[k] * c.stall_pressure[k]
        stalled = 0.0 if weight == 0.0 else s.stalled[k]
        stalled = 1.0 if (motor_speed > 0.0) & (wanted >= most) else stalled
        turned = wanted if motor_speed > 0.0 else 0.0
        torque = most if stalled > 0.0 else turned
        s.stalled[k] = stalled
        s.bit_torque[k] = torque
        s.motor_pressure[k] = torque / c.torque_per_pressure[k]
        s.rotation_speed[bit + k] -= e.torsional_push[bit + k] * torque


@njit(**_LANES)
def pump_mud(lanes, pump, c: Lanes, s: KernelState):
    """Standpipe pressure that this flow needs without the motor (`model.md` section 4)."""
    for k in range(lanes):
        flow = max(pump * c.pump_displacement[k], 0.0) / c.reference_flow[k]
        s.circulation[k] = c.circulating_pressure[k] * flow**1.8


@njit(**_LANES)
def circulate(lanes, steps, c: Lanes, s: KernelState):
    """Standpipe pressure: that of circulation, and the motor's a sound travel time late, behind one lag."""
    delay = len(s.pulses) // lanes
    if delay == 0:
        for k in range(lanes):
            s.standpipe[k] += c.pressure_gain[k] * (s.circulation[k] + s.motor_pressure[k] - s.standpipe[k])
        return
    slot = (steps % delay) * lanes
    for k in range(lanes):
        arriving = s.pulses[slot + k]
        s.pulses[slot + k] = s.motor_pressure[k]
        s.standpipe[k] += c.pressure_gain[k] * (s.circulation[k] + arriving - s.standpipe[k])


@njit(**_LANES)
def sense(lanes, elements, e: Elements, c: Lanes, s: KernelState, out: Array):
    """One row of `layout.CHANNELS`, (channels, lanes)."""
    bit, place = (elements - 1) * lanes, elements * lanes
    for k in range(lanes):
        out[0, k] = s.sensed_torque[k] + c.torque_bias[k]
        out[1, k] = e.axial_spring[k] * (s.position[lanes + k] - s.position[k])
        out[2, k] = s.standpipe[k]
        out[3, k] = s.rotation[place + k] + s.tool_face_offset[k]
        out[4, k] = s.rotation_speed[bit + k]
        out[5, k] = s.bit_torque[k]
        out[6, k] = s.weight_on_bit[k]
        out[7, k] = s.motor_pressure[k]
        out[8, k] = s.position[place + k] + s.depth_offset[k]
        out[9, k] = s.speed[bit + k]


@njit(**_LANES)
def sense_torque(lanes, speed, acceleration, e: Elements, c: Lanes, s: KernelState):
    """What the top drive feels, or its motor gives, through the torque sensor's gain and lag.

    `sense` adds the sensor's bias: a constant passes a lag that starts settled unchanged.
    """
    turning = speed / math.sqrt(speed * speed + _STILL * _STILL)
    for k in range(lanes):
        torque = e.torsional_spring[k] * (s.rotation[k] - s.rotation[lanes + k])
        torque += c.motor_inertia[k] * acceleration + c.motor_friction[k] * turning
        s.sensed_torque[k] += c.torque_gain[k] * (c.torque_scale[k] * torque - s.sensed_torque[k])


@njit(**_LANES)
def apply_observer(lanes, dt, measured, c: Lanes, s: KernelState):
    """The weak observer: a torque that was measured turns the drive a little towards the one that is simulated.

    ``offset' = gain (measured - sensed) / Z - offset / tau``, Z the string's wave impedance at the top: passive for
    gains from 0 to 1, so it takes from what arrives from below and adds nothing. measured: NaN where nothing was.
    """
    for k in range(lanes):
        s.pulled[k] -= dt * c.pull_leak[k] * s.pulled[k]
    if not math.isnan(measured):
        for k in range(lanes):
            s.pulled[k] += dt * c.pull[k] * (measured - (s.sensed_torque[k] + c.torque_bias[k]))
