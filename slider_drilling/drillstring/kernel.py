"""The compiled step of the string: `model.md` sections 2 to 4, in passes over flat arrays (see `layout`).

A step pushes the speeds with the forces of the present positions and strains, lets the bit cut, then moves the
string and its contacts with the new speeds (semi-implicit Euler, the leap-frog of a wave equation). The passes over
elements hold no call, branch or allocation, so the compiler turns each into packed instructions; all of it becomes one
function, which knows once that no two arrays overlap.
"""

from __future__ import annotations

import math

from slider_drilling.compiler import COMPILE, INNER, njit
from slider_drilling.drillstring.arithmetic import exponential, per_root, reciprocal, root
from slider_drilling.drillstring.layout import Array, Curve, Elements, Lanes, State

_TINY = 1e-30  # m2 or N2; a strain this small has no direction
_STILL = 0.1  # rad/s, below which a drive's own friction fades: measured speeds are rarely zero
_LEAST = 1e-9  # of a friction factor: one of zero leaves no length over which the strain decays


@njit(**INNER)
def push(
    count, axial_spring, axial_spring_below, torsional_spring, torsional_spring_below, axial_push, torsional_push,
    axial_decay, torsional_decay, axial_force, side_weight, vertical_bend, lateral_bend, extra_bend, buckling, radius,
    position, position_above, position_below, rotation, rotation_above, rotation_below, strain_axial,
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
        stiffness = root(vertical * vertical + lateral * lateral)
        stiffness += abs(tension) * extra_bend[j] + buckling[j] * compression * compression
        force = below - above + axial_force[j] - stiffness * strain_axial[j]
        speed[j] = axial_decay[j] * speed[j] + axial_push[j] * force
        torque = torsional_spring[j] * (rotation_above[j] - rotation[j])
        torque -= torsional_spring_below[j] * (rotation[j] - rotation_below[j])
        torque -= radius[j] * (stiffness * strain_tangential[j])
        rotation_speed[j] = torsional_decay[j] * rotation_speed[j] + torsional_push[j] * torque


@njit(**INNER)
def slide(
    count, dt, p, ease, axis, axis_across, radius, yielding, speed, rotation_speed, position, rotation, strain_axial,
    strain_tangential,
):  # fmt: skip
    """Positions one step on, and the contacts with them: the paper's operator for i = 1 (eq. 11-18).

    The operator applies Dahl's law to the tangential and the axial motion in turn, each with the sign of its own
    share of the radial speed. Its limit for dt -> 0 is therefore

        M' = v - (|v_x cos psi| + |v_y sin psi|) M / z_ss,    z_ss = mu / grip,

    not ``v - |v_r| M / z_ss``: the two differ where one motion stretches the asperity and the other slackens it, by
    10 degrees of tool-face on the reference logs. Over a step M decays by exp(-u), which is replaced by the inverse
    of its Taylor sum: off by u^5 / 120, 3e-6 at the u < 0.2 met in practice, never overshooting and right for
    u -> inf. The direction psi, and with it mu, is taken at mid-step. p: (8,), polynomial of 1 / mu; ease: one over
    what all friction is multiplied by now.
    """
    c0, c1, c2, c3 = ease * p[0], ease * p[1], ease * p[2], ease * p[3]
    c4, c5, c6, c7 = ease * p[4], ease * p[5], ease * p[6], ease * p[7]
    for j in range(count):
        along = dt * speed[j]
        turn = dt * rotation_speed[j]
        across = radius[j] * turn
        position[j] += along
        rotation[j] += turn
        middle_axial = strain_axial[j] + 0.5 * along
        middle_tangential = strain_tangential[j] + 0.5 * across
        per_size = per_root(middle_axial * middle_axial + middle_tangential * middle_tangential + _TINY)
        onto_axis = (axis * middle_axial + axis_across * middle_tangential) * per_size
        q = onto_axis * onto_axis
        # summed in pairs: a chain of eight would leave the processor waiting
        qq = q * q
        per_mu = ((c0 + c1 * q) + (c2 + c3 * q) * qq) + ((c4 + c5 * q) + (c6 + c7 * q) * qq) * (qq * qq)
        u = (abs(middle_axial * along) + abs(middle_tangential * across)) * (yielding[j] * per_size) * per_mu
        growth = (1.0 + u * (1.0 / 2.0)) + (u * u) * (1.0 / 6.0 + u * (1.0 / 24.0))
        left = reciprocal(1.0 + u * growth)
        strain_axial[j] = (strain_axial[j] + along * growth) * left
        strain_tangential[j] = (strain_tangential[j] + across * growth) * left


@njit(**INNER)
def slide_any(
    count, dt, per_mu_table, ease, exponent, axis, axis_across, radius, yielding, speed, rotation_speed, position,
    rotation, strain_axial, strain_tangential,
):  # fmt: skip
    """As `slide`, for any Dahl exponent and for asperities whose friction has a kink between two wear modes."""
    last = len(per_mu_table) - 1
    for j in range(count):
        along = dt * speed[j]
        turn = dt * rotation_speed[j]
        across = radius[j] * turn
        position[j] += along
        rotation[j] += turn
        middle_axial = strain_axial[j] + 0.5 * along
        middle_tangential = strain_tangential[j] + 0.5 * across
        squared = middle_axial * middle_axial + middle_tangential * middle_tangential + _TINY
        per_size = per_root(squared)
        onto_axis = (axis * middle_axial + axis_across * middle_tangential) * per_size
        place = last * (onto_axis * onto_axis)
        cell = min(max(int(place), 0), last - 1)  # what is not a number must not index
        per_mu = per_mu_table[cell] + (place - cell) * (per_mu_table[cell + 1] - per_mu_table[cell])
        per_sliding = ease * yielding[j] * per_mu
        if exponent == 1.0:
            u = (abs(middle_axial * along) + abs(middle_tangential * across)) * per_size * per_sliding
        else:
            share = squared * per_size * per_sliding
            u = yielded(middle_axial * along * per_size, share, exponent) * per_size
            u += yielded(middle_tangential * across * per_size, share, exponent) * per_size
        growth = 1.0 + u * (1.0 / 2.0 + u * (1.0 / 6.0 + u * (1.0 / 24.0)))
        left = reciprocal(1.0 + u * growth)
        strain_axial[j] = (strain_axial[j] + along * growth) * left
        strain_tangential[j] = (strain_tangential[j] + across * growth) * left


@njit(**INNER)
def yielded(stretch, share, exponent):
    """Part of a stretch (m) that slips: ``1 - (1 - sgn(stretch) share)^i`` of it, the base keeping its sign."""
    base = 1.0 - math.copysign(share, stretch)
    return stretch * (1.0 - math.copysign(abs(base) ** exponent, base))


@njit(**INNER)
def vary_with_speed(
    count, time, drop, per_speed, drift_rate, radius, base_yielding, speed, rotation_speed, yielding
):  # fmt: skip
    """Friction that falls with the speed of sliding (Stribeck), and drifts in time: ``1 + drop exp(-v / v_s)`` times
    ``1 + rate t``, with one division for both, and exactly as before where neither is.
    """
    for j in range(count):
        across = radius[j] * rotation_speed[j]
        fast = exponential(root(speed[j] * speed[j] + across * across) * per_speed[j])
        factor = max((fast + drop[j]) * (1.0 + drift_rate[j] * time), _LEAST * fast)
        yielding[j] = base_yielding[j] * (1.0 - (factor - fast) * reciprocal(factor))


@njit(**INNER)
def vary_with_nothing(count, base_yielding, yielding):
    """Friction as the elements have it."""
    for j in range(count):
        yielding[j] = base_yielding[j]


@njit(**INNER)
def vary_with_rest(
    count, dt, most, per_time, rest_speed, per_slip_distance, radius, speed, rotation_speed, rest, yielding
):  # fmt: skip
    """Friction that has grown while the contact rested: ``1 + most (1 - exp(-rest / tau))`` times that which `yielding`
    holds.
    """
    for j in range(count):
        across = radius[j] * rotation_speed[j]
        slip = root(speed[j] * speed[j] + across * across)
        forgotten = rest[j] * reciprocal(1.0 + dt * slip * per_slip_distance[j])
        rested = rest[j] + dt if slip < rest_speed[j] else forgotten
        rest[j] = rested
        old = exponential(rested * per_time[j])
        factor = max(old + most[j] * (old - 1.0), _LEAST * old)
        yielding[j] *= 1.0 - (factor - old) * reciprocal(factor)


@njit(**INNER)
def drive_top(lanes, time, angle, block, lower: Array, lower_next: Array, u, c: Lanes, s: State):
    """Row 0: the block with its heave, the top drive through its backlash.

    lower, lower_next: (lanes,) m by which the blocks are below `block` before and behind, u of the way between them; or
    nothing.
    """
    for k in range(lanes):
        s.position[k] = block
        if len(lower) > 0:
            s.position[k] += lower[k] + u * (lower_next[k] - lower[k])
        if c.heave_amplitude[k] > 0.0:
            s.position[k] += c.heave_amplitude[k] * math.sin(c.heave_frequency[k] * time + c.heave_phase[k])
        # The spring below the drive stretches by what is left of the angle once the dead zone is passed: the string
        # unwinds freely inside it, it is not held there.
        drive = angle + s.pulled[k]
        ahead = drive - s.rotation[lanes + k]
        s.rotation[k] = drive - min(max(ahead, -c.backlash[k]), c.backlash[k])


@njit(**INNER)
def shake(lanes, time, e: Elements, c: Lanes, s: State):
    """The push of the axial oscillation tools."""
    for k in range(lanes):
        if c.tool_force[k] > 0.0:
            j = int(c.tool_row[k]) * lanes + k
            s.speed[j] += e.axial_push[j] * c.tool_force[k] * math.sin(c.tool_frequency[k] * time)


@njit(**INNER)
def cut(lanes, elements, dt, time, pump, bite, e: Elements, c: Lanes, s: State):
    """Bit, rock and motor: what the bit takes from the speeds of the lowest element (`model.md` section 4).

    Weight on bit is proportional to the bit's speed, with a constant large against mass / dt, so it is solved for
    the speed at the end of the step.
    """
    for k in range(lanes):
        j, place = (elements - 1) * lanes + k, elements * lanes + k
        flow = pump * c.pump_displacement[k]
        share = s.motor_pressure[k] / c.stall_pressure[k]
        motor_speed = 2.0 * math.pi * flow / c.motor_displacement[k] * (1.0 - c.leak[k] * share * share)
        free = s.speed[j]
        weight = 0.0
        if free > 0.0 and s.position[place] + dt * free >= s.bottom[k]:
            if s.stalled[k] > 0.0 or motor_speed <= 0.0:
                s.speed[j] = 0.0
            else:
                rock = c.cutting_stiffness[k] * (c.formation_factor[k] if time >= c.formation_time[k] else 1.0)
                s.speed[j] = free / (1.0 + e.axial_push[j] * rock * 2.0 * math.pi / motor_speed)
            weight = (free - s.speed[j]) / e.axial_push[j]
            s.bottom[k] = max(s.bottom[k], s.position[place] + dt * s.speed[j])
        turn_motor(k, weight, bite, motor_speed, c, s)
        s.rotation_speed[j] -= e.torsional_push[j] * s.bit_torque[k]


@njit(**INNER)
def turn_motor(k, weight, bite, motor_speed, c: Lanes, s: State):
    """Bit torque and motor pressure from the weight on bit; above its limit the motor stalls until picked up."""
    s.weight_on_bit[k] = weight
    if weight == 0.0:
        s.stalled[k] = 0.0
    wanted = bite * c.bit_lever[k] * weight
    most = c.torque_per_pressure[k] * c.stall_pressure[k]
    if motor_speed > 0.0 and wanted >= most:
        s.stalled[k] = 1.0
    if s.stalled[k] > 0.0:
        s.bit_torque[k] = most
    else:
        s.bit_torque[k] = wanted if motor_speed > 0.0 else 0.0
    s.motor_pressure[k] = s.bit_torque[k] / c.torque_per_pressure[k]


@njit(**INNER)
def pump_mud(lanes, pump, c: Lanes, s: State):
    """Standpipe pressure that this flow needs without the motor (`model.md` section 4)."""
    for k in range(lanes):
        flow = max(pump * c.pump_displacement[k], 0.0) / c.reference_flow[k]
        s.circulation[k] = c.circulating_pressure[k] * flow**1.8


@njit(**INNER)
def circulate(lanes, steps, c: Lanes, s: State):
    """Standpipe pressure: that of circulation, and the motor's a sound travel time late, behind one lag."""
    delay = len(s.pulses) // lanes
    for k in range(lanes):
        arriving = s.motor_pressure[k]
        if delay > 0:
            slot = (steps % delay) * lanes + k
            arriving = s.pulses[slot]
            s.pulses[slot] = s.motor_pressure[k]
        s.standpipe[k] += c.pressure_gain[k] * (s.circulation[k] + arriving - s.standpipe[k])


@njit(**INNER)
def sense(lanes, elements, e: Elements, c: Lanes, s: State, out: Array):
    """One row of `layout.CHANNELS`, (channels, lanes)."""
    for k in range(lanes):
        bit, place = (elements - 1) * lanes + k, elements * lanes + k
        out[0, k] = s.sensed_torque[k] + c.torque_bias[k]
        out[1, k] = e.axial_spring[k] * (s.position[lanes + k] - s.position[k])
        out[2, k] = s.standpipe[k]
        out[3, k] = s.rotation[place] + s.tool_face_offset[k]
        out[4, k] = s.rotation_speed[bit]
        out[5, k] = s.bit_torque[k]
        out[6, k] = s.weight_on_bit[k]
        out[7, k] = s.motor_pressure[k]
        out[8, k] = s.position[place] + s.depth_offset[k]
        out[9, k] = s.speed[bit]


@njit(**INNER)
def sense_torque(lanes, speed, acceleration, e: Elements, c: Lanes, s: State):
    """What the top drive feels, or its motor gives, through the torque sensor's gain and lag.

    `sense` adds the sensor's bias: a constant passes a lag that starts settled unchanged.
    """
    for k in range(lanes):
        torque = e.torsional_spring[k] * (s.rotation[k] - s.rotation[lanes + k])
        if c.motor_inertia[k] > 0.0 or c.motor_friction[k] > 0.0:
            turning = speed / math.sqrt(speed * speed + _STILL * _STILL)
            torque += c.motor_inertia[k] * acceleration + c.motor_friction[k] * turning
        s.sensed_torque[k] += c.torque_gain[k] * (c.torque_scale[k] * torque - s.sensed_torque[k])


@njit(**INNER)
def pull(lanes, dt, measured, c: Lanes, s: State):
    """The weak observer: a torque that was measured turns the drive a little towards the one that is simulated.

    ``offset' = gain (measured - sensed) / Z - offset / tau``, Z the string's wave impedance at the top: passive for
    gains from 0 to 1, so it takes from what arrives from below and adds nothing. measured: NaN where nothing was.
    """
    for k in range(lanes):
        if c.pull[k] > 0.0:
            s.pulled[k] -= dt * c.pull_leak[k] * s.pulled[k]
            if not math.isnan(measured):
                s.pulled[k] += dt * c.pull[k] * (measured - (s.sensed_torque[k] + c.torque_bias[k]))


@njit(**INNER)
def hermite(start, start_rate, end, end_rate, length, u):
    """Cubic through two values and slopes at 0 <= u <= 1 of an interval."""
    d = end - start
    a, b = start_rate * length - d, d - end_rate * length
    return start + u * (d + (1.0 - u) * (a * (1.0 - u) + b * u))


@njit(**COMPILE)
def advance(
    lanes, elements, substeps, dt, by_speed, by_rest, drive: Array, lowered: Array, e: Elements, curve: Curve, c: Lanes,
    s: State, out: Array,
):  # fmt: skip
    """Step every lane through the intervals of ``drive`` and fill ``out`` at the end of each, and before the first one
    where ``out`` has a row more.

    by_speed, by_rest: whether friction of any lane varies so (`vary_with_speed`, `vary_with_rest`).
    drive: (m + 1, 9), rows of top-drive angle rad and speed rad/s, block position m and speed m/s, pump speed rad/s,
    the surface torque N m measured (NaN where none was, see `pull`), what all friction is multiplied by, the
    acceleration of the top drive rad/s2, and what the bit's torque per weight is multiplied by, ``substeps * dt``
    apart, the first one at the present time.
    lowered: (m + 1, lanes) m that the block of each lane is lower; (m + 1, 0) where all are as `drive` says.
    out: (m or m + 1, channels, lanes).
    """
    count = len(s.speed)
    above, here, below = slice(0, count), slice(lanes, lanes + count), slice(2 * lanes, 2 * lanes + count)
    position, position_above, position_below = s.position[here], s.position[above], s.position[below]
    rotation, rotation_above, rotation_below = s.rotation[here], s.rotation[above], s.rotation[below]
    axial_spring_below, torsional_spring_below = e.axial_spring[here], e.torsional_spring[here]
    packed = curve.exponent == 1.0 and len(curve.polynomial) > 0
    first = len(out) - (len(drive) - 1)
    if first > 0:
        sense(lanes, elements, e, c, s, out[0])
    for m in range(len(drive) - 1):
        a, b = drive[m], drive[m + 1]
        for n in range(substeps):
            u = (n + 1.0) / substeps
            time = s.clock[0] + (n + 1.0) * dt
            pump = a[4] + u * (b[4] - a[4])
            ease = 1.0 / max(a[6] + u * (b[6] - a[6]), _LEAST)
            if n == 0 or a[4] != b[4]:
                pump_mud(lanes, pump, c, s)
            push(
                count, e.axial_spring, axial_spring_below, e.torsional_spring, torsional_spring_below, e.axial_push,
                e.torsional_push, e.axial_decay, e.torsional_decay, e.axial_force, e.side_weight, e.vertical_bend,
                e.lateral_bend, e.extra_bend, e.buckling, e.radius, position, position_above, position_below,
                rotation, rotation_above, rotation_below, s.strain_axial, s.strain_tangential, s.speed,
                s.rotation_speed,
            )  # fmt: skip
            shake(lanes, time, e, c, s)
            cut(lanes, elements, dt, time, pump, a[8] + u * (b[8] - a[8]), e, c, s)
            if by_speed:
                vary_with_speed(
                    count, time, e.stribeck_drop, e.per_stribeck_speed, e.drift_rate, e.radius, e.yielding, s.speed,
                    s.rotation_speed, s.yielding,
                )  # fmt: skip
            elif by_rest:
                vary_with_nothing(count, e.yielding, s.yielding)
            if by_rest:
                vary_with_rest(
                    count, dt, e.aging_growth, e.per_aging_time, e.rest_speed, e.per_slip_distance, e.radius, s.speed,
                    s.rotation_speed, s.rest, s.yielding,
                )  # fmt: skip
            if packed:
                slide(
                    count, dt, curve.polynomial, ease, curve.axial, curve.tangential, e.radius, s.yielding, s.speed,
                    s.rotation_speed, position, rotation, s.strain_axial, s.strain_tangential,
                )  # fmt: skip
            else:
                slide_any(
                    count, dt, curve.table, ease, curve.exponent, curve.axial, curve.tangential, e.radius, s.yielding,
                    s.speed, s.rotation_speed, position, rotation, s.strain_axial, s.strain_tangential,
                )  # fmt: skip
            angle = hermite(a[0], a[1], b[0], b[1], substeps * dt, u)
            block = hermite(a[2], a[3], b[2], b[3], substeps * dt, u)
            drive_top(lanes, time, angle, block, lowered[m], lowered[m + 1], u, c, s)
            circulate(lanes, int(s.clock[1]) + n, c, s)
            sense_torque(lanes, a[1] + u * (b[1] - a[1]), b[7], e, c, s)
            pull(lanes, dt, a[5] + u * (b[5] - a[5]), c, s)
        s.clock[0] += substeps * dt
        s.clock[1] += substeps
        sense(lanes, elements, e, c, s, out[first + m])
