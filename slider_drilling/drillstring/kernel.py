"""The compiled step of the string: `model.md` sections 2 to 4, in passes over flat arrays (see `layout`).

A step pushes the speeds with the forces of the present positions and strains, lets the bit cut, then moves the
string and its contacts with the new speeds (semi-implicit Euler, the leap-frog of a wave equation). The passes over
elements hold no call, branch or allocation, so the compiler turns each into packed instructions.
"""

from __future__ import annotations

import math
from typing import Any

import llvmlite.binding
from numba import njit

from slider_drilling.drillstring.layout import Array, Curve, Elements, Lanes, State

# LLVM vectorises a loop over many arrays only if it may check that they do not overlap; its default of 8 checks
# is too few for a step of the string.
llvmlite.binding.set_option("slider_drilling", "-runtime-memory-check-threshold=1000")
# Not "nnan" and "ninf": a run that blows up must show it.
COMPILE: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "fastmath": {"contract", "arcp", "nsz", "reassoc"},
    "nogil": True,
}
_TINY = 1e-30  # m2; a strain this small has no direction
_SLIPPERY = 1e-9  # the least friction factor: one of zero leaves no length over which the strain decays


@njit(**COMPILE)
def push(
    count, axial_spring, axial_spring_below, torsional_spring, torsional_spring_below, axial_push, torsional_push,
    axial_decay, torsional_decay, axial_force, side_weight, vertical_bend, lateral_bend, extra_bend, buckling, radius,
    grip, position, position_above, position_below, rotation, rotation_above, rotation_below, strain_axial,
    strain_tangential, speed, rotation_speed,
):  # fmt: skip
    """Speeds one step on under springs, weight and friction; the bit's share is added by `cut`."""
    for j in range(count):
        above = axial_spring[j] * (position[j] - position_above[j])
        below = axial_spring_below[j] * (position_below[j] - position[j])
        tension = 0.5 * (above + below)
        compression = min(tension, 0.0)
        vertical = side_weight[j] - tension * vertical_bend[j]
        lateral = tension * lateral_bend[j]
        side_force = math.sqrt(vertical * vertical + lateral * lateral)
        side_force += abs(tension) * extra_bend[j] + buckling[j] * compression * compression
        stiffness = grip[j] * side_force
        force = below - above + axial_force[j] - stiffness * strain_axial[j]
        speed[j] = axial_decay[j] * speed[j] + axial_push[j] * force
        torque = torsional_spring[j] * (rotation_above[j] - rotation[j])
        torque -= torsional_spring_below[j] * (rotation[j] - rotation_below[j])
        torque -= radius[j] * stiffness * strain_tangential[j]
        rotation_speed[j] = torsional_decay[j] * rotation_speed[j] + torsional_push[j] * torque


@njit(**COMPILE)
def friction_polynomial(
    count, dt, c0, c1, c2, c3, c4, c5, c6, axial, tangential, radius, factor, speed, rotation_speed,
    strain_axial, strain_tangential, friction,
):  # fmt: skip
    """Friction factor of each contact from the direction that its strain has at the middle of the step."""
    for j in range(count):
        along = strain_axial[j] + 0.5 * dt * speed[j]
        across = strain_tangential[j] + 0.5 * dt * radius[j] * rotation_speed[j]
        onto_axis = axial * along + tangential * across
        q = onto_axis * onto_axis / (along * along + across * across + _TINY)
        mu = c0 + q * (c1 + q * (c2 + q * (c3 + q * (c4 + q * (c5 + q * c6)))))
        friction[j] = max(factor[j] * mu, _SLIPPERY)


@njit(**COMPILE)
def friction_table(
    count, dt, table, axial, tangential, radius, factor, speed, rotation_speed, strain_axial, strain_tangential,
    friction,
):  # fmt: skip
    """As `friction_polynomial`, for asperities whose friction has a kink between two wear modes."""
    last = len(table) - 1
    for j in range(count):
        along = strain_axial[j] + 0.5 * dt * speed[j]
        across = strain_tangential[j] + 0.5 * dt * radius[j] * rotation_speed[j]
        onto_axis = axial * along + tangential * across
        place = last * (onto_axis * onto_axis / (along * along + across * across + _TINY))
        cell = min(max(int(place), 0), last - 1)
        mu = table[cell] + (place - cell) * (table[cell + 1] - table[cell])
        friction[j] = max(factor[j] * mu, _SLIPPERY)


@njit(**COMPILE)
def slide(
    count, dt, radius, grip, friction, speed, rotation_speed, position, rotation, strain_axial, strain_tangential
):
    """Positions one step on, and the contacts with them: the paper's operator for i = 1 (eq. 11-18).

    The operator applies Dahl's law to the tangential and the axial motion in turn, each with the sign of its own
    share of the radial speed. Its limit for dt -> 0 is therefore

        M' = v - (|v_x cos psi| + |v_y sin psi|) M / z_ss,    z_ss = mu / grip,

    not ``v - |v_r| M / z_ss``: the two differ where one motion stretches the asperity and the other slackens it, by
    10 degrees of tool-face on the reference logs. Over a step M decays by exp(-u), which is replaced by the inverse
    of its Taylor sum: off by u^5 / 120, 3e-6 at the u < 0.2 met in practice, never overshooting and right for
    u -> inf. The direction psi is taken at mid-step.
    """
    for j in range(count):
        along = dt * speed[j]
        turn = dt * rotation_speed[j]
        across = radius[j] * turn
        position[j] += along
        rotation[j] += turn
        middle_axial = strain_axial[j] + 0.5 * along
        middle_tangential = strain_tangential[j] + 0.5 * across
        size = math.sqrt(middle_axial * middle_axial + middle_tangential * middle_tangential + _TINY)
        u = (abs(middle_axial * along) + abs(middle_tangential * across)) * grip[j] / (size * friction[j])
        growth = 1.0 + u * (1.0 / 2.0 + u * (1.0 / 6.0 + u * (1.0 / 24.0)))
        left = 1.0 / (1.0 + u * growth)
        strain_axial[j] = (strain_axial[j] + along * growth) * left
        strain_tangential[j] = (strain_tangential[j] + across * growth) * left


@njit(**COMPILE)
def slide_any_exponent(
    count, dt, exponent, radius, grip, friction, speed, rotation_speed, position, rotation, strain_axial,
    strain_tangential,
):  # fmt: skip
    """As `slide` for any Dahl exponent i."""
    for j in range(count):
        along = dt * speed[j]
        turn = dt * rotation_speed[j]
        across = radius[j] * turn
        position[j] += along
        rotation[j] += turn
        middle_axial = strain_axial[j] + 0.5 * along
        middle_tangential = strain_tangential[j] + 0.5 * across
        size = math.sqrt(middle_axial * middle_axial + middle_tangential * middle_tangential + _TINY)
        share = size * grip[j] / friction[j]
        u = yielded(middle_axial * along / size, share, exponent) / size
        u += yielded(middle_tangential * across / size, share, exponent) / size
        growth = 1.0 + u * (1.0 / 2.0 + u * (1.0 / 6.0 + u * (1.0 / 24.0)))
        left = 1.0 / (1.0 + u * growth)
        strain_axial[j] = (strain_axial[j] + along * growth) * left
        strain_tangential[j] = (strain_tangential[j] + across * growth) * left


@njit(**COMPILE)
def yielded(stretch, share, exponent):
    """Part of a stretch (m) that slips: ``1 - (1 - sgn(stretch) share)^i`` of it, the base keeping its sign."""
    base = 1.0 - math.copysign(share, stretch)
    return stretch * (1.0 - math.copysign(abs(base) ** exponent, base))


@njit(**COMPILE)
def vary_friction(lanes, rows, dt, time, e: Elements, c: Lanes, s: State):
    """Friction factors with the effects that change them in time: Stribeck, static aging, drift."""
    for i in range(rows):
        for k in range(lanes):
            j = (i + 1) * lanes + k
            across = e.radius[j] * s.rotation_speed[j]
            slip = math.sqrt(s.speed[j] * s.speed[j] + across * across)
            rested = s.rest[j] + dt if slip < c.rest_speed[k] else s.rest[j] / (1.0 + dt * slip / c.slip_distance[k])
            s.rest[j] = rested
            factor = e.friction_factor[j] * (1.0 + c.stribeck_drop[k] * decay(slip / c.stribeck_speed[k]))
            factor *= 1.0 + c.aging_growth[k] * (1.0 - decay(rested / c.aging_time[k]))
            s.factor[j] = factor * max(1.0 + c.drift_rate[k] * time, 0.0)


@njit(**COMPILE)
def decay(x):
    """``exp(-x)`` for x >= 0 as the inverse eighth power of a Taylor sum; off by at most 5e-6."""
    y = 0.125 * x
    root = 1.0 + y * (1.0 + y * (1.0 / 2.0) * (1.0 + y * (1.0 / 3.0) * (1.0 + y * 0.25 * (1.0 + y * 0.2))))
    square = root * root
    fourth = square * square
    return 1.0 / (fourth * fourth)


@njit(**COMPILE)
def drive_top(lanes, time, angle, block, c: Lanes, s: State):
    """Row 0: the block with its heave, the top drive through its backlash."""
    for k in range(lanes):
        heave = c.heave_amplitude[k] * math.sin(c.heave_frequency[k] * time + c.heave_phase[k])
        s.position[k] = block + heave
        ahead = angle - s.rotation[k]
        if abs(ahead) > c.backlash[k]:
            s.rotation[k] = angle - math.copysign(c.backlash[k], ahead) if c.backlash[k] > 0.0 else angle


@njit(**COMPILE)
def shake(lanes, time, e: Elements, c: Lanes, s: State):
    """The push of the axial oscillation tools."""
    for k in range(lanes):
        j = int(c.tool_row[k]) * lanes + k
        s.speed[j] += e.axial_push[j] * c.tool_force[k] * math.sin(c.tool_frequency[k] * time)


@njit(**COMPILE)
def cut(lanes, bit_row, dt, time, pump, e: Elements, c: Lanes, s: State):
    """Bit, rock and motor: what the bit takes from the speeds of the lowest element (`model.md` section 4).

    Weight on bit is proportional to the bit's speed, with a constant large against mass / dt, so it is solved for
    the speed at the end of the step.
    """
    for k in range(lanes):
        j = bit_row * lanes + k
        flow = pump * c.pump_displacement[k]
        share = s.motor_pressure[k] / c.stall_pressure[k]
        motor_speed = 2.0 * math.pi * flow / c.motor_displacement[k] * (1.0 - c.leak[k] * share * share)
        free = s.speed[j]
        weight = 0.0
        if free > 0.0 and s.position[j] + dt * free >= s.bottom[k]:
            if s.stalled[k] > 0.0 or motor_speed <= 0.0:
                s.speed[j] = 0.0
            else:
                rock = c.cutting_stiffness[k] * (c.formation_factor[k] if time >= c.formation_time[k] else 1.0)
                s.speed[j] = free / (1.0 + e.axial_push[j] * rock * 2.0 * math.pi / motor_speed)
            weight = (free - s.speed[j]) / e.axial_push[j]
            s.bottom[k] = max(s.bottom[k], s.position[j] + dt * s.speed[j])
        turn_motor(k, weight, motor_speed, c, s)
        s.rotation_speed[j] -= e.torsional_push[j] * s.bit_torque[k]


@njit(**COMPILE)
def turn_motor(k, weight, motor_speed, c: Lanes, s: State):
    """Bit torque and motor pressure from the weight on bit; above its limit the motor stalls until picked up."""
    s.weight_on_bit[k] = weight
    if weight == 0.0:
        s.stalled[k] = 0.0
    wanted = c.bit_lever[k] * weight
    most = c.torque_per_pressure[k] * c.stall_pressure[k]
    if motor_speed > 0.0 and wanted >= most:
        s.stalled[k] = 1.0
    if s.stalled[k] > 0.0:
        s.bit_torque[k] = most
    else:
        s.bit_torque[k] = wanted if motor_speed > 0.0 else 0.0
    s.motor_pressure[k] = s.bit_torque[k] / c.torque_per_pressure[k]


@njit(**COMPILE)
def circulate(lanes, steps, pump, c: Lanes, s: State):
    """Standpipe pressure: circulation at this flow, the motor's pressure a sound travel time late, one lag."""
    delay = len(s.pulses) // lanes
    for k in range(lanes):
        arriving = s.motor_pressure[k]
        if delay > 0:
            slot = (steps % delay) * lanes + k
            arriving = s.pulses[slot]
            s.pulses[slot] = s.motor_pressure[k]
        flow = max(pump * c.pump_displacement[k], 0.0) / c.reference_flow[k]
        target = c.circulating_pressure[k] * flow**1.8 + arriving
        s.standpipe[k] += c.pressure_gain[k] * (target - s.standpipe[k])


@njit(**COMPILE)
def sense(lanes, bit_row, e: Elements, c: Lanes, s: State, out: Array):
    """One row of `layout.CHANNELS`, (channels, lanes)."""
    for k in range(lanes):
        top, bit = lanes + k, bit_row * lanes + k
        out[0, k] = s.sensed_torque[k] + c.torque_bias[k]
        out[1, k] = e.axial_spring[top] * (s.position[top] - s.position[k])
        out[2, k] = s.standpipe[k]
        out[3, k] = s.rotation[bit]
        out[4, k] = s.rotation_speed[bit]
        out[5, k] = s.bit_torque[k]
        out[6, k] = s.weight_on_bit[k]
        out[7, k] = s.motor_pressure[k]
        out[8, k] = s.position[bit] + s.depth_offset[k]
        out[9, k] = s.speed[bit]


@njit(**COMPILE)
def sense_torque(lanes, e: Elements, c: Lanes, s: State):
    """What the top drive feels, through the torque sensor's lag."""
    for k in range(lanes):
        torque = e.torsional_spring[lanes + k] * (s.rotation[k] - s.rotation[lanes + k])
        s.sensed_torque[k] += c.torque_gain[k] * (torque - s.sensed_torque[k])


@njit(**COMPILE)
def hermite(start, start_rate, end, end_rate, length, u):
    """Cubic through two values and slopes at 0 <= u <= 1 of an interval."""
    d = end - start
    a, b = start_rate * length - d, d - end_rate * length
    return start + u * (d + (1.0 - u) * (a * (1.0 - u) + b * u))


@njit(**COMPILE)
def advance(lanes, substeps, dt, varying, drive: Array, e: Elements, curve: Curve, c: Lanes, s: State, out: Array):
    """Step every lane through the intervals of ``drive`` and fill ``out`` at the end of each.

    drive: (m + 1, 5), rows of top-drive angle rad and speed rad/s, block position m and speed m/s, pump speed
    rad/s, ``substeps * dt`` apart, the first one at the present time. out: (m, channels, lanes).
    """
    count = len(s.position) - 2 * lanes
    bit_row = count // lanes
    here, up, down = slice(lanes, lanes + count), slice(0, count), slice(2 * lanes, 2 * lanes + count)
    use_table = len(curve.polynomial) == 0
    for m in range(len(drive) - 1):
        a, b = drive[m], drive[m + 1]
        for n in range(substeps):
            u = (n + 1.0) / substeps
            time = s.clock[0] + (n + 1.0) * dt
            angle = hermite(a[0], a[1], b[0], b[1], substeps * dt, u)
            block = hermite(a[2], a[3], b[2], b[3], substeps * dt, u)
            pump = a[4] + u * (b[4] - a[4])
            push(
                count, e.axial_spring[here], e.axial_spring[down], e.torsional_spring[here], e.torsional_spring[down],
                e.axial_push[here], e.torsional_push[here], e.axial_decay[here], e.torsional_decay[here],
                e.axial_force[here], e.side_weight[here], e.vertical_bend[here], e.lateral_bend[here],
                e.extra_bend[here], e.buckling[here], e.radius[here], e.grip[here], s.position[here], s.position[up],
                s.position[down], s.rotation[here], s.rotation[up], s.rotation[down], s.strain_axial[here],
                s.strain_tangential[here], s.speed[here], s.rotation_speed[here],
            )  # fmt: skip
            shake(lanes, time, e, c, s)
            cut(lanes, bit_row, dt, time, pump, e, c, s)
            if varying:
                vary_friction(lanes, bit_row, dt, time, e, c, s)
            if use_table:
                friction_table(
                    count, dt, curve.table, curve.axial, curve.tangential, e.radius[here], s.factor[here],
                    s.speed[here], s.rotation_speed[here], s.strain_axial[here], s.strain_tangential[here],
                    s.friction[here],
                )  # fmt: skip
            else:
                p = curve.polynomial
                friction_polynomial(
                    count, dt, p[0], p[1], p[2], p[3], p[4], p[5], p[6], curve.axial, curve.tangential,
                    e.radius[here], s.factor[here], s.speed[here], s.rotation_speed[here], s.strain_axial[here],
                    s.strain_tangential[here], s.friction[here],
                )  # fmt: skip
            if curve.exponent == 1.0:
                slide(
                    count, dt, e.radius[here], e.grip[here], s.friction[here], s.speed[here], s.rotation_speed[here],
                    s.position[here], s.rotation[here], s.strain_axial[here], s.strain_tangential[here],
                )  # fmt: skip
            else:
                slide_any_exponent(
                    count, dt, curve.exponent, e.radius[here], e.grip[here], s.friction[here], s.speed[here],
                    s.rotation_speed[here], s.position[here], s.rotation[here], s.strain_axial[here],
                    s.strain_tangential[here],
                )  # fmt: skip
            drive_top(lanes, time, angle, block, c, s)
            circulate(lanes, int(s.clock[1]) + n, pump, c, s)
            sense_torque(lanes, e, c, s)
        s.clock[0] += substeps * dt
        s.clock[1] += substeps
        sense(lanes, bit_row, e, c, s, out[m])
