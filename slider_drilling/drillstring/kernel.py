"""The compiled time step of the string: `model.md` sections 2 to 4, in passes over the arrays of `kernel_arrays`.

The scheme is semi-implicit Euler (the leap-frog of a wave equation). A step

1. updates the speeds with the forces of the present positions and strains,
2. solves for the bit,
3. moves contacts and string with the new speeds.

The passes over elements hold no call, branch or allocation, so that the compiler can vectorise each. All functions are
inlined into `advance`: the compiler then checks only once that no two arrays overlap.

Names: ``strain`` is the deformation of a contact's asperity (m), ``per_x`` is 1 / x.
"""

from __future__ import annotations

import math

import numpy as np

from slider_drilling.drillstring.boundary_conditions import (
    apply_observer,
    move_top,
    push_axial_tools,
    solve_bit,
    update_circulating_pressure,
    update_sensed_torque,
    update_standpipe_pressure,
    write_channels,
)
from slider_drilling.drillstring.fast_arithmetic import fast_exp, fast_inverse_sqrt, fast_reciprocal, fast_sqrt
from slider_drilling.drillstring.kernel_arrays import Array, Elements, FrictionCurve, KernelState, Lanes
from slider_drilling.process.jit_cache import INLINED_JIT_OPTIONS, JIT_OPTIONS, njit

_TINY = 1e-30  # m2; a strain this small has no direction
_MAX_DECAY = 1e6  # exponent of a strain's decay in one step: nothing is left of the strain, and powers stay finite
# Share of its sliding length up to which an elasto-plastic contact does not slip (Dupont et al. 2002: below one).
_BREAK_AWAY = 0.7
_CREEP = 5e-4  # m/s around the hole, at which friction that is larger one way round is so by half
_MIN_FACTOR = 1e-9  # of friction; at zero the length over which a strain decays would be zero


@njit(**INLINED_JIT_OPTIONS)
def compute_stretch(count, position, position_above, rotation, rotation_above, stretch, twist):
    """Stretch (m) and twist (rad) of the spring above each element, in the precision of the passes."""
    real = stretch.dtype.type
    for j in range(count):
        stretch[j] = real(position[j] - position_above[j])
        twist[j] = real(rotation[j] - rotation_above[j])


@njit(**INLINED_JIT_OPTIONS)
def update_speeds(
    count, axial_spring, axial_spring_below, torsional_spring, torsional_spring_below, axial_push, torsional_push,
    axial_decay, torsional_decay, axial_force, side_weight, vertical_bend, lateral_bend, extra_bend, buckling, radius,
    stretch, stretch_below, twist, twist_below, strain_axial, strain_tangential, speed, rotation_speed,
):  # fmt: skip
    """Speeds one step later under springs, weight and friction; `solve_bit` adds the bit.

    Side force: `model.md` section 3 (Johancsik), times the contact's stiffness per load.
    """
    real = speed.dtype.type
    half, none = real(0.5), real(0.0)
    for j in range(count):
        above = axial_spring[j] * stretch[j]
        below = axial_spring_below[j] * stretch_below[j]
        tension = half * (above + below)
        compression = min(tension, none)
        vertical = side_weight[j] - tension * vertical_bend[j]
        lateral = tension * lateral_bend[j]
        stiffness = real(fast_sqrt(vertical * vertical + lateral * lateral))
        stiffness += abs(tension) * extra_bend[j] + buckling[j] * compression * compression
        force = below - above + axial_force[j] - stiffness * strain_axial[j]
        speed[j] = axial_decay[j] * speed[j] + axial_push[j] * force
        torque = torsional_spring_below[j] * twist_below[j] - torsional_spring[j] * twist[j]
        torque -= radius[j] * (stiffness * strain_tangential[j])
        rotation_speed[j] = torsional_decay[j] * rotation_speed[j] + torsional_push[j] * torque


@njit(**INLINED_JIT_OPTIONS)
def update_contacts(
    count, dt, p, per_factor, axis, axis_across, radius, per_sliding_length, other_memory, elastic_share,
    vector_share, speed, rotation_speed, strain_axial, strain_tangential,
):  # fmt: skip
    """Strains of the contacts one step later: the paper's two-step operator (eq. 11-18) for Dahl exponent 1.

    The operator applies Dahl's law to the tangential and the axial motion in turn, each with the sign of its own
    part of the radial speed. Its limit for dt -> 0 is

        M' = v - (|v_x cos psi| + |v_y sin psi|) M / z_ss,

    not ``v - |v_r| M / z_ss``. The two differ where one motion stretches the asperity and the other relaxes it, by
    10 degrees of toolface on the reference logs.

    Over a step M decays by exp(-u). The inverse of the Taylor sum of exp(u) replaces it: its error is u^5 / 120, 3e-6
    at the u < 0.2 met in practice, it never overshoots, and it is right for u -> inf. The direction psi, and with it
    mu, is taken at mid-step (second order).

    Args:
        p: Polynomial of 1 / mu in q = cos^2(beta_v), (8,).
        per_factor: 1 over the factor that multiplies all friction now.
        axis, axis_across: Components of the asperity's axis along and around the hole.
        per_sliding_length: 1 / z_ss for mu = 1, 1/m, (count,).
        other_memory: Whether any contact has one of the two shares, (count,). Elastic share: of its slip before it
            breaks away, and while it relaxes, that share is missing (Dupont et al. 2002, with a smooth step between).
            Vector share: that share of it slips by Dahl's law for one vector, ``M' = v - |v| M / z_ss``, with the
            friction of the direction of v (Velenis, Tsiotras and Canudas de Wit, Vehicle System Dynamics 43, 2005).
    """
    real = speed.dtype.type
    c0, c1, c2, c3 = real(per_factor * p[0]), real(per_factor * p[1]), real(per_factor * p[2]), real(per_factor * p[3])
    c4, c5, c6, c7 = real(per_factor * p[4]), real(per_factor * p[5]), real(per_factor * p[6]), real(per_factor * p[7])
    dt, axis, axis_across, tiny = real(dt), real(axis), real(axis_across), real(_TINY)
    one, half, sixth, last, most = real(1.0), real(0.5), real(1.0 / 6.0), real(1.0 / 24.0), real(_MAX_DECAY)
    for j in range(count):
        along = dt * speed[j]
        across = radius[j] * (dt * rotation_speed[j])
        middle_axial = strain_axial[j] + half * along
        middle_tangential = strain_tangential[j] + half * across
        squared = middle_axial * middle_axial + middle_tangential * middle_tangential + tiny
        per_size = real(fast_inverse_sqrt(squared))
        onto_axis = (axis * middle_axial + axis_across * middle_tangential) * per_size
        q = onto_axis * onto_axis
        moved = real(0.0)
        if other_memory:
            moved = along * along + across * across + tiny
            per_moved = real(fast_inverse_sqrt(moved))
            onto_axis = (axis * along + axis_across * across) * per_moved
            q += vector_share[j] * (onto_axis * onto_axis - q)
            moved *= per_moved
        # Summed in pairs (Estrin): in a chain of eight each term would wait for the one before.
        qq = q * q
        per_mu = ((c0 + c1 * q) + (c2 + c3 * q) * qq) + ((c4 + c5 * q) + (c6 + c7 * q) * qq) * (qq * qq)
        stretch, turned = middle_axial * along, middle_tangential * across
        slip = (abs(stretch) + abs(turned)) * per_size
        per_sliding = per_sliding_length[j] * per_mu
        if other_memory:
            slip += vector_share[j] * (moved - slip)
            slip *= slipping_share(squared * per_size * per_sliding, stretch + turned, elastic_share[j], real)
        u = min(slip * per_sliding, most)
        growth = (one + u * half) + (u * u) * (sixth + u * last)
        left = fast_reciprocal(one + u * growth, real)
        strain_axial[j] = (strain_axial[j] + along * growth) * left
        strain_tangential[j] = (strain_tangential[j] + across * growth) * left


@njit(**INLINED_JIT_OPTIONS)
def update_contacts_general(
    count, dt, per_mu_table, per_factor, exponent, axis, axis_across, radius, per_sliding_length, elastic_share,
    vector_share, speed, rotation_speed, strain_axial, strain_tangential,
):  # fmt: skip
    """`update_contacts` for any Dahl exponent, and for asperities whose friction has a kink between two wear modes.

    A table (1 / mu over q, linear between entries) takes the place of the polynomial.
    """
    last = len(per_mu_table) - 1
    for j in range(count):
        along = dt * speed[j]
        across = radius[j] * (dt * rotation_speed[j])
        middle_axial = strain_axial[j] + 0.5 * along
        middle_tangential = strain_tangential[j] + 0.5 * across
        squared = middle_axial * middle_axial + middle_tangential * middle_tangential + _TINY
        per_size = fast_inverse_sqrt(squared)
        onto_axis = (axis * middle_axial + axis_across * middle_tangential) * per_size
        moved = along * along + across * across + _TINY
        moved_onto_axis = (axis * along + axis_across * across) * fast_inverse_sqrt(moved)
        q = onto_axis * onto_axis
        q += vector_share[j] * (moved_onto_axis * moved_onto_axis - q)
        place = last * q
        cell = min(max(int(place), 0), last - 1)  # NaN must not index outside the table
        per_mu = per_mu_table[cell] + (place - cell) * (per_mu_table[cell + 1] - per_mu_table[cell])
        per_sliding = per_factor * per_sliding_length[j] * per_mu
        relative_strain = squared * per_size * per_sliding
        stretch, turned = middle_axial * along, middle_tangential * across
        if exponent == 1.0:
            slip = (abs(stretch) + abs(turned)) * per_size
            slip += vector_share[j] * (fast_sqrt(moved) - slip)
            u = slip * per_sliding
        else:
            u = slipped_part(stretch * per_size, relative_strain, exponent) * per_size
            u += slipped_part(turned * per_size, relative_strain, exponent) * per_size
        u *= slipping_share(relative_strain, stretch + turned, elastic_share[j], np.float64)
        growth = 1.0 + u * (1.0 / 2.0 + u * (1.0 / 6.0 + u * (1.0 / 24.0)))
        left = fast_reciprocal(1.0 + u * growth, np.float64)
        strain_axial[j] = (strain_axial[j] + along * growth) * left
        strain_tangential[j] = (strain_tangential[j] + across * growth) * left


@njit(**INLINED_JIT_OPTIONS)
def update_positions(count, dt, speed, rotation_speed, position, rotation):
    """Positions and rotations one step later, with the new speeds."""
    dt = speed.dtype.type(dt)
    for j in range(count):
        position[j] += dt * speed[j]
        rotation[j] += dt * rotation_speed[j]


@njit(**INLINED_JIT_OPTIONS)
def slipping_share(relative_strain, growing, elastic_share, real):
    """Share of Dahl's slip that is left: all of it after the contact has broken away, while its strain grows."""
    none, one, two, three, away = real(0.0), real(1.0), real(2.0), real(3.0), real(_BREAK_AWAY)
    gone = min(max((relative_strain - away) * real(1.0 / (1.0 - _BREAK_AWAY)), none), one)
    slips = gone * gone * (three - two * gone) if growing > none else none
    return one - elastic_share * (one - slips)


@njit(**INLINED_JIT_OPTIONS)
def slipped_part(stretch, relative_strain, exponent):
    """Slip (m) during a radial stretch (m): ``1 - (1 - sgn(stretch) r / z_ss)^i`` of it, the base keeping its sign."""
    base = 1.0 - math.copysign(relative_strain, stretch)
    return stretch * (1.0 - math.copysign(abs(base) ** exponent, base))


@njit(**INLINED_JIT_OPTIONS)
def scale_friction_with_speed(
    count, time, drop, per_speed, drift_rate, turning, radius, base, speed, rotation_speed, per_sliding_length
):  # fmt: skip
    """Friction times ``(1 + drop exp(-v / v_s)) (1 + rate t) (1 + d v_t / (|v_t| + creep))``.

    Effects `stribeck` and `friction_drift`, and friction that is larger one way round (`Modifiers`). The result is bit
    for bit the base where all are off.
    """
    real = speed.dtype.type
    time, one, least, creep = real(time), real(1.0), real(_MIN_FACTOR), real(_CREEP)
    for j in range(count):
        across = radius[j] * rotation_speed[j]
        fast = fast_exp(fast_sqrt(speed[j] * speed[j] + across * across) * per_speed[j], real)
        way_round = one + turning[j] * (across * fast_reciprocal(abs(across) + creep, real))
        factor = max((fast + drop[j]) * ((one + drift_rate[j] * time) * way_round), least * fast)
        per_sliding_length[j] = base[j] * (one - (factor - fast) * fast_reciprocal(factor, real))


@njit(**INLINED_JIT_OPTIONS)
def reset_friction(count, base, per_sliding_length):
    """Friction as the elements have it."""
    for j in range(count):
        per_sliding_length[j] = base[j]


@njit(**INLINED_JIT_OPTIONS)
def scale_friction_with_rest(
    count, dt, growth, per_time, rest_speed, per_slip_distance, radius, speed, rotation_speed, rest_time,
    per_sliding_length,
):  # fmt: skip
    """Present friction times ``1 + growth (1 - exp(-t_rest / tau))``: effect `static_aging`. Updates `rest_time`."""
    real = speed.dtype.type
    dt, one, least = real(dt), real(1.0), real(_MIN_FACTOR)
    for j in range(count):
        across = radius[j] * rotation_speed[j]
        slip = real(fast_sqrt(speed[j] * speed[j] + across * across))
        shortened = rest_time[j] * fast_reciprocal(one + dt * slip * per_slip_distance[j], real)
        rested = rest_time[j] + dt if slip < rest_speed[j] else shortened
        rest_time[j] = rested
        old = fast_exp(rested * per_time[j], real)
        factor = max(old + growth[j] * (old - one), least * old)
        per_sliding_length[j] *= one - (factor - old) * fast_reciprocal(factor, real)


@njit(**INLINED_JIT_OPTIONS)
def hermite(start, start_rate, end, end_rate, length, u):
    """Cubic through two values with their slopes, at 0 <= u <= 1 of an interval."""
    d = end - start
    a, b = start_rate * length - d, d - end_rate * length
    return start + u * (d + (1.0 - u) * (a * (1.0 - u) + b * u))


@njit(**JIT_OPTIONS)
def advance(
    lanes, elements, substeps, dt, speed_dependent, rest_dependent, drive: Array, block_offset: Array, e: Elements,
    curve: FrictionCurve, c: Lanes, s: KernelState, out: Array,
):  # fmt: skip
    """Step every lane through the intervals of ``drive``, and write the channels at the end of each.

    Args:
        lanes, elements: Runs side by side, and elements of each.
        substeps, dt: Steps per interval, and their length in s.
        speed_dependent, rest_dependent: Whether friction of any lane varies with speed or time
            (`scale_friction_with_speed`), or with rest (`scale_friction_with_rest`).
        drive: (m + 1, 9), one row each ``substeps * dt``, the first at the present time: top-drive angle rad and speed
            rad/s, block position m and speed m/s, pump speed rad/s, measured surface torque N m (NaN where unknown,
            see `apply_observer`), factor of all friction, top-drive acceleration rad/s2, factor of the bit's torque.
        block_offset: (m + 1, lanes) m that each lane's block is lower than in ``drive``; (m + 1, 0) where none is.
        e, curve, c: Constants.
        s: State, which is changed.
        out: (m, channels, lanes), or (m + 1, ...) to hold the channels before the first interval too.
    """
    count = len(s.speed)
    above, here = slice(0, count), slice(lanes, lanes + count)
    position, position_above, rotation, rotation_above = (
        s.position[here], s.position[above], s.rotation[here], s.rotation[above]
    )  # fmt: skip
    stretch_below, twist_below = s.stretch[here], s.twist[here]
    axial_spring_below, torsional_spring_below = e.axial_spring[here], e.torsional_spring[here]
    vectorised = curve.exponent == 1.0 and len(curve.polynomial) > 0
    heaving, tools_on, observed = c.heave_amplitude.any(), c.tool_force.any(), c.observer_gain.any()
    other_memory = e.elastic_share.any() or e.vector_share.any()
    last_pump = math.nan
    first = len(out) - (len(drive) - 1)
    if first > 0:
        write_channels(lanes, elements, e, c, s, out[0])
    for m in range(len(drive) - 1):
        a, b = drive[m], drive[m + 1]
        for n in range(substeps):
            u = (n + 1.0) / substeps
            time = s.clock[0] + (n + 1.0) * dt
            pump = a[4] + u * (b[4] - a[4])
            per_factor = 1.0 / max(a[6] + u * (b[6] - a[6]), _MIN_FACTOR)
            if pump != last_pump:
                update_circulating_pressure(lanes, pump, c, s)
                last_pump = pump
            compute_stretch(count, position, position_above, rotation, rotation_above, s.stretch, s.twist)
            update_speeds(
                count, e.axial_spring, axial_spring_below, e.torsional_spring, torsional_spring_below, e.axial_push,
                e.torsional_push, e.axial_decay, e.torsional_decay, e.axial_force, e.side_weight, e.vertical_bend,
                e.lateral_bend, e.extra_bend, e.buckling, e.radius, s.stretch, stretch_below, s.twist, twist_below,
                s.strain_axial, s.strain_tangential, s.speed, s.rotation_speed,
            )  # fmt: skip
            if tools_on:
                push_axial_tools(lanes, time, e, c, s)
            solve_bit(lanes, elements, dt, time, pump, a[8] + u * (b[8] - a[8]), e, c, s)
            if speed_dependent:
                scale_friction_with_speed(
                    count, time, e.stribeck_drop, e.per_stribeck_speed, e.drift_rate, e.turning_difference, e.radius,
                    e.per_sliding_length, s.speed, s.rotation_speed, s.per_sliding_length,
                )  # fmt: skip
            elif rest_dependent:
                reset_friction(count, e.per_sliding_length, s.per_sliding_length)
            if rest_dependent:
                scale_friction_with_rest(
                    count, dt, e.aging_growth, e.per_aging_time, e.rest_speed, e.per_slip_distance, e.radius, s.speed,
                    s.rotation_speed, s.rest_time, s.per_sliding_length,
                )  # fmt: skip
            if vectorised:
                update_contacts(
                    count, dt, curve.polynomial, per_factor, curve.axial, curve.tangential, e.radius,
                    s.per_sliding_length, other_memory, e.elastic_share, e.vector_share, s.speed, s.rotation_speed,
                    s.strain_axial, s.strain_tangential,
                )  # fmt: skip
            else:
                update_contacts_general(
                    count, dt, curve.table, per_factor, curve.exponent, curve.axial, curve.tangential, e.radius,
                    s.per_sliding_length, e.elastic_share, e.vector_share, s.speed, s.rotation_speed, s.strain_axial,
                    s.strain_tangential,
                )  # fmt: skip
            update_positions(count, dt, s.speed, s.rotation_speed, position, rotation)
            angle = hermite(a[0], a[1], b[0], b[1], substeps * dt, u)
            block = hermite(a[2], a[3], b[2], b[3], substeps * dt, u)
            move_top(lanes, time, angle, block, heaving, block_offset[m], block_offset[m + 1], u, c, s)
            update_standpipe_pressure(lanes, int(s.clock[1]) + n, c, s)
            update_sensed_torque(lanes, a[1] + u * (b[1] - a[1]), b[7], e, c, s)
            if observed:
                apply_observer(lanes, dt, a[5] + u * (b[5] - a[5]), c, s)
        s.clock[0] += substeps * dt
        s.clock[1] += substeps
        write_channels(lanes, elements, e, c, s, out[first + m])


# The same function compiled for elements in single precision (see `kernel_arrays.to_single_precision`). It is a
# dispatcher of its own so that its compilation is announced separately.
advance_single = njit(**JIT_OPTIONS)(advance.py_func)
