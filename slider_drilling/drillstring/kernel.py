"""The compiled step of the string: `model.md` sections 2 to 4, in passes over flat arrays (see `layout`).

A step pushes the speeds with the forces of the present positions and strains, lets the bit cut, then moves the
string and its contacts with the new speeds (semi-implicit Euler, the leap-frog of a wave equation). The passes over
elements hold no call, branch or allocation, so the compiler turns each into packed instructions; all of it becomes one
function, which knows once that no two arrays overlap.
"""

from __future__ import annotations

import math

import numpy as np

from slider_drilling.drillstring.boundary_conditions import (
    apply_observer,
    circulate,
    cut,
    drive_top,
    pump_mud,
    sense,
    sense_torque,
    shake,
)
from slider_drilling.drillstring.fast_arithmetic import exponential, per_root, reciprocal, root
from slider_drilling.drillstring.kernel_arrays import Array, Curve, Elements, KernelState, Lanes
from slider_drilling.process.jit_cache import INLINED_JIT_OPTIONS, JIT_OPTIONS, njit

_TINY = 1e-30  # m2 or N2; a strain this small has no direction
_GONE = 1e6  # slip over the length of decay of a strain, after which nothing is left of it; its powers stay finite
_LEAST = 1e-9  # of a friction factor: one of zero leaves no length over which the strain decays


@njit(**INLINED_JIT_OPTIONS)
def stretch_out(count, position, position_above, rotation, rotation_above, stretch, twist):
    """How far each element is from the one above it, in the precision of the passes: m and rad."""
    real = stretch.dtype.type
    for j in range(count):
        stretch[j] = real(position[j] - position_above[j])
        twist[j] = real(rotation[j] - rotation_above[j])


@njit(**INLINED_JIT_OPTIONS)
def push(
    count, axial_spring, axial_spring_below, torsional_spring, torsional_spring_below, axial_push, torsional_push,
    axial_decay, torsional_decay, axial_force, side_weight, vertical_bend, lateral_bend, extra_bend, buckling, radius,
    stretch, stretch_below, twist, twist_below, strain_axial, strain_tangential, speed, rotation_speed,
):  # fmt: skip
    """Speeds one step on under springs, weight and friction; the bit's share is added by `cut`."""
    real = speed.dtype.type
    half, none = real(0.5), real(0.0)
    for j in range(count):
        above = axial_spring[j] * stretch[j]
        below = axial_spring_below[j] * stretch_below[j]
        tension = half * (above + below)
        compression = min(tension, none)
        vertical = side_weight[j] - tension * vertical_bend[j]
        lateral = tension * lateral_bend[j]
        stiffness = real(root(vertical * vertical + lateral * lateral))
        stiffness += abs(tension) * extra_bend[j] + buckling[j] * compression * compression
        force = below - above + axial_force[j] - stiffness * strain_axial[j]
        speed[j] = axial_decay[j] * speed[j] + axial_push[j] * force
        torque = torsional_spring_below[j] * twist_below[j] - torsional_spring[j] * twist[j]
        torque -= radius[j] * (stiffness * strain_tangential[j])
        rotation_speed[j] = torsional_decay[j] * rotation_speed[j] + torsional_push[j] * torque


@njit(**INLINED_JIT_OPTIONS)
def slide(
    count, dt, p, ease, axis, axis_across, radius, yielding, speed, rotation_speed, strain_axial, strain_tangential,
):  # fmt: skip
    """The contacts one step on: the paper's operator for i = 1 (eq. 11-18).

    The operator applies Dahl's law to the tangential and the axial motion in turn, each with the sign of its own
    share of the radial speed. Its limit for dt -> 0 is therefore

        M' = v - (|v_x cos psi| + |v_y sin psi|) M / z_ss,    z_ss = mu / grip,

    not ``v - |v_r| M / z_ss``: the two differ where one motion stretches the asperity and the other slackens it, by
    10 degrees of toolface on the reference logs. Over a step M decays by exp(-u), which is replaced by the inverse
    of its Taylor sum: off by u^5 / 120, 3e-6 at the u < 0.2 met in practice, never overshooting and right for
    u -> inf. The direction psi, and with it mu, is taken at mid-step. p: (8,), polynomial of 1 / mu; ease: one over
    what all friction is multiplied by now.
    """
    real = speed.dtype.type
    c0, c1, c2, c3 = real(ease * p[0]), real(ease * p[1]), real(ease * p[2]), real(ease * p[3])
    c4, c5, c6, c7 = real(ease * p[4]), real(ease * p[5]), real(ease * p[6]), real(ease * p[7])
    dt, axis, axis_across, tiny = real(dt), real(axis), real(axis_across), real(_TINY)
    one, half, sixth, last, most = real(1.0), real(0.5), real(1.0 / 6.0), real(1.0 / 24.0), real(_GONE)
    for j in range(count):
        along = dt * speed[j]
        across = radius[j] * (dt * rotation_speed[j])
        middle_axial = strain_axial[j] + half * along
        middle_tangential = strain_tangential[j] + half * across
        per_size = real(per_root(middle_axial * middle_axial + middle_tangential * middle_tangential + tiny))
        onto_axis = (axis * middle_axial + axis_across * middle_tangential) * per_size
        q = onto_axis * onto_axis
        # summed in pairs: a chain of eight would leave the processor waiting
        qq = q * q
        per_mu = ((c0 + c1 * q) + (c2 + c3 * q) * qq) + ((c4 + c5 * q) + (c6 + c7 * q) * qq) * (qq * qq)
        u = (abs(middle_axial * along) + abs(middle_tangential * across)) * (yielding[j] * per_size) * per_mu
        u = min(u, most)
        growth = (one + u * half) + (u * u) * (sixth + u * last)
        left = reciprocal(one + u * growth, real)
        strain_axial[j] = (strain_axial[j] + along * growth) * left
        strain_tangential[j] = (strain_tangential[j] + across * growth) * left


@njit(**INLINED_JIT_OPTIONS)
def slide_any(
    count, dt, per_mu_table, ease, exponent, axis, axis_across, radius, yielding, speed, rotation_speed, strain_axial,
    strain_tangential,
):  # fmt: skip
    """As `slide`, for any Dahl exponent and for asperities whose friction has a kink between two wear modes."""
    last = len(per_mu_table) - 1
    for j in range(count):
        along = dt * speed[j]
        across = radius[j] * (dt * rotation_speed[j])
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
        left = reciprocal(1.0 + u * growth, np.float64)
        strain_axial[j] = (strain_axial[j] + along * growth) * left
        strain_tangential[j] = (strain_tangential[j] + across * growth) * left


@njit(**INLINED_JIT_OPTIONS)
def move(count, dt, speed, rotation_speed, position, rotation):
    """Positions one step on with the new speeds."""
    dt = speed.dtype.type(dt)
    for j in range(count):
        position[j] += dt * speed[j]
        rotation[j] += dt * rotation_speed[j]


@njit(**INLINED_JIT_OPTIONS)
def yielded(stretch, share, exponent):
    """Part of a stretch (m) that slips: ``1 - (1 - sgn(stretch) share)^i`` of it, the base keeping its sign."""
    base = 1.0 - math.copysign(share, stretch)
    return stretch * (1.0 - math.copysign(abs(base) ** exponent, base))


@njit(**INLINED_JIT_OPTIONS)
def vary_with_speed(
    count, time, drop, per_speed, drift_rate, radius, base_yielding, speed, rotation_speed, yielding
):  # fmt: skip
    """Friction that falls with the speed of sliding (Stribeck), and drifts in time: ``1 + drop exp(-v / v_s)`` times
    ``1 + rate t``, with one division for both, and exactly as before where neither is.
    """
    real = speed.dtype.type
    time, one, least = real(time), real(1.0), real(_LEAST)
    for j in range(count):
        across = radius[j] * rotation_speed[j]
        fast = exponential(root(speed[j] * speed[j] + across * across) * per_speed[j], real)
        factor = max((fast + drop[j]) * (one + drift_rate[j] * time), least * fast)
        yielding[j] = base_yielding[j] * (one - (factor - fast) * reciprocal(factor, real))


@njit(**INLINED_JIT_OPTIONS)
def vary_with_nothing(count, base_yielding, yielding):
    """Friction as the elements have it."""
    for j in range(count):
        yielding[j] = base_yielding[j]


@njit(**INLINED_JIT_OPTIONS)
def vary_with_rest(
    count, dt, most, per_time, rest_speed, per_slip_distance, radius, speed, rotation_speed, rest, yielding
):  # fmt: skip
    """Friction that has grown while the contact rested: ``1 + most (1 - exp(-rest / tau))`` times that which `yielding`
    holds.
    """
    real = speed.dtype.type
    dt, one, least = real(dt), real(1.0), real(_LEAST)
    for j in range(count):
        across = radius[j] * rotation_speed[j]
        slip = real(root(speed[j] * speed[j] + across * across))
        forgotten = rest[j] * reciprocal(one + dt * slip * per_slip_distance[j], real)
        rested = rest[j] + dt if slip < rest_speed[j] else forgotten
        rest[j] = rested
        old = exponential(rested * per_time[j], real)
        factor = max(old + most[j] * (old - one), least * old)
        yielding[j] *= one - (factor - old) * reciprocal(factor, real)


@njit(**INLINED_JIT_OPTIONS)
def hermite(start, start_rate, end, end_rate, length, u):
    """Cubic through two values and slopes at 0 <= u <= 1 of an interval."""
    d = end - start
    a, b = start_rate * length - d, d - end_rate * length
    return start + u * (d + (1.0 - u) * (a * (1.0 - u) + b * u))


@njit(**JIT_OPTIONS)
def advance(
    lanes, elements, substeps, dt, by_speed, by_rest, drive: Array, lowered: Array, e: Elements, curve: Curve, c: Lanes,
    s: KernelState, out: Array,
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
    above, here = slice(0, count), slice(lanes, lanes + count)
    position, position_above, rotation, rotation_above = (
        s.position[here], s.position[above], s.rotation[here], s.rotation[above]
    )  # fmt: skip
    stretch_below, twist_below = s.stretch[here], s.twist[here]
    axial_spring_below, torsional_spring_below = e.axial_spring[here], e.torsional_spring[here]
    packed = curve.exponent == 1.0 and len(curve.polynomial) > 0
    heaving, shaken, pulled = c.heave_amplitude.any(), c.tool_force.any(), c.pull.any()
    pumped = math.nan
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
            if pump != pumped:
                pump_mud(lanes, pump, c, s)
                pumped = pump
            stretch_out(count, position, position_above, rotation, rotation_above, s.stretch, s.twist)
            push(
                count, e.axial_spring, axial_spring_below, e.torsional_spring, torsional_spring_below, e.axial_push,
                e.torsional_push, e.axial_decay, e.torsional_decay, e.axial_force, e.side_weight, e.vertical_bend,
                e.lateral_bend, e.extra_bend, e.buckling, e.radius, s.stretch, stretch_below, s.twist, twist_below,
                s.strain_axial, s.strain_tangential, s.speed, s.rotation_speed,
            )  # fmt: skip
            if shaken:
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
                    s.rotation_speed, s.strain_axial, s.strain_tangential,
                )  # fmt: skip
            else:
                slide_any(
                    count, dt, curve.table, ease, curve.exponent, curve.axial, curve.tangential, e.radius, s.yielding,
                    s.speed, s.rotation_speed, s.strain_axial, s.strain_tangential,
                )  # fmt: skip
            move(count, dt, s.speed, s.rotation_speed, position, rotation)
            angle = hermite(a[0], a[1], b[0], b[1], substeps * dt, u)
            block = hermite(a[2], a[3], b[2], b[3], substeps * dt, u)
            drive_top(lanes, time, angle, block, heaving, lowered[m], lowered[m + 1], u, c, s)
            circulate(lanes, int(s.clock[1]) + n, c, s)
            sense_torque(lanes, a[1] + u * (b[1] - a[1]), b[7], e, c, s)
            if pulled:
                apply_observer(lanes, dt, a[5] + u * (b[5] - a[5]), c, s)
        s.clock[0] += substeps * dt
        s.clock[1] += substeps
        sense(lanes, elements, e, c, s, out[first + m])


# The same for elements in single precision (see `layout.in_single`): compiled, and said to be, on its own.
advance_single = njit(**JIT_OPTIONS)(advance.py_func)
