"""The compiled step of a foreign plant: velocity Verlet over elements, contacts, drive, bit, motor and mud.

Written apart from `slider_drilling.drillstring.kernel`, element by element and with branches: it is made to be another
program, not a fast one.
"""

from __future__ import annotations

import math

from slider_drilling.blind.foreign.structure import FrictionState
from slider_drilling.process.jit_cache import JIT_OPTIONS, njit

# Where the scalars of a state stand: s, rad, rad/s, m, N, N m, Pa, 0 or 1, Pa, N m, N m, N m, steps.
(TIME, DRIVE_ANGLE, DRIVE_SPEED, BOTTOM, WEIGHT, BIT_TORQUE, MOTOR_PRESSURE, STALLED, STANDPIPE, READ_TORQUE,
 LAGGED_TORQUE, QUILL_TORQUE, STEPS) = range(13)  # fmt: skip
SCALARS = 13
_COULOMB, _ELASTO_PLASTIC = int(FrictionState.REGULARISED_COULOMB), int(FrictionState.ELASTO_PLASTIC)
_STILL = 0.1  # rad/s, below which a drive's own friction fades
_BISECTIONS = 40
_LOOP = 0.3  # lag of the inner speed loop over that of the outer one


@njit(**JIT_OPTIONS)
def circulating_pressure(pump, factor, c, time):
    """Pa, standpipe pressure that circulation alone needs."""
    flow = max(pump * c.pump_displacement, 0.0) / c.reference_flow
    warm = 1.0 - c.warming * (1.0 - math.exp(-max(time, 0.0) / c.warming_time))
    return c.circulating_pressure * factor * warm * flow**1.8


@njit(**JIT_OPTIONS)
def _contact(j, normal, dt, v_along, v_across, friction, table, e, c, zx, zt, rest, time):
    """One contact one step on: its force per stretch, N/m; of Coulomb friction, which has no stretch, its force, N."""
    speed = math.sqrt(v_along * v_along + v_across * v_across)
    if speed > 1e-12:
        cosine = (v_along * c.axis + v_across * c.axis_across) / speed
    else:
        size = math.sqrt(zx[j] * zx[j] + zt[j] * zt[j]) + 1e-15
        cosine = (zx[j] * c.axis + zt[j] * c.axis_across) / size
    q = min(max(cosine * cosine, 0.0), 1.0) * (len(table) - 1)
    cell = min(int(q), len(table) - 2)
    mu = table[cell] + (q - cell) * (table[cell + 1] - table[cell])
    mu *= e.friction_factor[j] * friction * (1.0 + c.drift_rate * time)
    if c.stribeck_drop != 0.0:
        mu *= 1.0 + c.stribeck_drop * math.exp(-speed / c.stribeck_speed)
    if c.aging_growth != 0.0:
        if speed < c.rest_speed:
            rest[j] += dt
        else:
            rest[j] /= 1.0 + dt * speed / c.slip_distance
        mu *= 1.0 + c.aging_growth * (1.0 - math.exp(-rest[j] / c.aging_time))
    most = max(mu, 1e-9) * normal
    if c.friction_state == _COULOMB:
        return most
    zss = c.presliding * mu / 0.3  # the pre-sliding length is proportional to friction
    size = math.sqrt(zx[j] * zx[j] + zt[j] * zt[j])
    yields = 1.0
    if c.friction_state == _ELASTO_PLASTIC:
        # Dupont et al. 2002, eq. 9: smooth between break-away and steady sliding, only while the stretch grows.
        away = c.break_away * zss
        if zx[j] * v_along + zt[j] * v_across <= 0.0 or size <= away:
            yields = 0.0
        elif size < zss:
            yields = 0.5 + 0.5 * math.sin(math.pi * (size - 0.5 * (zss + away)) / (zss - away))
    u = yields * dt * speed / zss
    left = 1.0 / (1.0 + u * (1.0 + 0.5 * u))
    zx[j] = (zx[j] + dt * v_along * (1.0 + 0.5 * u)) * left
    zt[j] = (zt[j] + dt * v_across * (1.0 + 0.5 * u)) * left
    return most / zss


@njit(**JIT_OPTIONS)
def _coulomb(j, dt, along, around, most, cut, e, c, vx, vt):
    """Regularised Coulomb friction ``most v / (|v| + creep)`` per slip speed at the end of the step, N s/m.

    Implicit, so that stiff rest is stable: with the slip that the other forces alone would give, |v'| solves
    ``|v'| + dt most / m |v'| / (|v'| + creep) = |v_free|``, a quadratic. Rock slows the bit by ``1 + cut`` along the
    hole only, so there |v'| is found by bisection.
    """
    free_along = (vx[j] + dt * along / e.mass[j]) / (1.0 + cut)
    free_across = e.radius[j] * (vt[j] + dt * around / e.inertia[j])
    per_along = dt * most / (e.mass[j] * (1.0 + cut))
    per_across = dt * most * e.radius[j] * e.radius[j] / e.inertia[j]
    squared = free_along * free_along + free_across * free_across
    free, per_speed = math.sqrt(squared), per_along
    if squared > 1e-24:
        per_speed = (free_along * free_along * per_along + free_across * free_across * per_across) / squared
    half = 0.5 * (free - c.creep_speed - per_speed)
    speed = half + math.sqrt(half * half + free * c.creep_speed)
    if cut > 0.0:
        low, high = 0.0, free
        for _ in range(_BISECTIONS):
            speed = 0.5 * (low + high)
            a = free_along / (1.0 + per_along / (speed + c.creep_speed))
            b = free_across / (1.0 + per_across / (speed + c.creep_speed))
            if a * a + b * b > speed * speed:
                low = speed
            else:
                high = speed
    return most / (speed + c.creep_speed)


@njit(**JIT_OPTIONS)
def _hermite(start, start_rate, end, end_rate, length, u):
    """Cubic through two values and slopes at 0 <= u <= 1 of an interval."""
    rise = end - start
    p, q = start_rate * length - rise, rise - end_rate * length
    return start + u * (rise + (1.0 - u) * (p * (1.0 - u) + q * u))


@njit(**JIT_OPTIONS)
def _turn_drive(a, b, u, length, dt, c, s):
    """The speed loop of the top drive: it follows the angle asked for late, and load slows it."""
    asked = _hermite(a[1], a[2], b[1], b[2], length, u)
    slowed = c.drive_droop * s[QUILL_TORQUE] * abs(a[2]) / (abs(a[2]) + _STILL)
    wanted = (asked - s[DRIVE_ANGLE]) / c.drive_lag - slowed
    s[DRIVE_SPEED] += min(dt / (_LOOP * c.drive_lag + dt), 1.0) * (wanted - s[DRIVE_SPEED])
    s[DRIVE_ANGLE] += dt * s[DRIVE_SPEED]


@njit(**JIT_OPTIONS)
def advance(rows, substeps, dt, e, table, c, x, vx, turn, vt, zx, zt, rest, s, pulses, out, fresh):
    """Velocity Verlet through the intervals of rows: (m, 9) time, angle, speed, block, block speed, pump, factors."""
    n = len(x)
    first = 0
    if fresh:
        _read_out(out[0], rows[0], e, c, x, vx, turn, vt, s)
        first = 1
    top = rows[0, 3] + c.heave_amplitude * math.sin(c.heave_frequency * s[TIME] + c.heave_phase)
    for m in range(len(rows) - 1):
        a, b = rows[m], rows[m + 1]
        for k in range(substeps):
            u = (k + 1.0) / substeps
            time = s[TIME] + dt
            s[TIME] = time
            s[STEPS] += 1.0
            before = s[DRIVE_SPEED]
            _turn_drive(a, b, u, substeps * dt, dt, c, s)
            gain = (s[DRIVE_SPEED] - before) / dt
            block = _hermite(a[3], a[4], b[3], b[4], substeps * dt, u)
            top = block + c.heave_amplitude * math.sin(c.heave_frequency * time + c.heave_phase)
            pump = a[5] + u * (b[5] - a[5])
            friction, bite, press = (a[6] + u * (b[6] - a[6]), a[7] + u * (b[7] - a[7]), a[8] + u * (b[8] - a[8]))
            ahead = s[DRIVE_ANGLE] - turn[0]
            quill = turn[0] + ahead - min(max(ahead, -c.half_backlash), c.half_backlash)
            # Drift half a step, kick, drift half a step.
            for j in range(n):
                x[j] += 0.5 * dt * vx[j]
                turn[j] += 0.5 * dt * vt[j]
            tension_above = e.axial_spring[0] * (x[0] - top)
            torque_above = e.torsional_spring[0] * (quill - turn[0])
            s[QUILL_TORQUE] = torque_above
            for j in range(n):
                tension_below = e.axial_spring[j + 1] * (x[j + 1] - x[j]) if j + 1 < n else 0.0
                torque_below = e.torsional_spring[j + 1] * (turn[j] - turn[j + 1]) if j + 1 < n else 0.0
                tension = 0.5 * (tension_above + tension_below)
                vertical = e.side_weight[j] - tension * e.vertical_turn[j] + e.beam_force[j]
                lateral = tension * e.lateral_turn[j]
                normal = math.sqrt(vertical * vertical + lateral * lateral) + abs(tension) * e.extra_turn[j]
                if tension < 0.0:
                    normal += e.buckling[j] * tension * tension
                radius = e.radius[j]
                grip = _contact(j, normal, dt, vx[j], radius * vt[j], friction, table, e, c, zx, zt, rest, time)
                along = tension_below - tension_above + e.axial_load[j]
                around = torque_above - torque_below
                if j == n - 1:
                    around -= s[BIT_TORQUE]
                if c.tool_force > 0.0 and j == int(c.tool_element):
                    along += c.tool_force * math.sin(c.tool_frequency * time)
                damp_x = dt * (c.axial_damping + e.viscous_drag[j] / e.mass[j])
                damp_t = dt * (c.torsional_damping + e.viscous_drag[j] * radius * radius / e.inertia[j])
                if c.friction_state == _COULOMB:
                    # Friction has the direction of the slip that is left after rock and motor have acted as well.
                    cut = _cut(dt, time, pump, e, c, x, vx, s) if j == n - 1 else 0.0
                    per_speed = _coulomb(j, dt, along, around, grip, cut, e, c, vx, vt)
                    slowed = 1.0 + damp_x + dt * per_speed / (e.mass[j] * (1.0 + cut))
                    vx[j] = (vx[j] + dt * along / e.mass[j]) / slowed
                    damp_t += dt * per_speed * radius * radius / e.inertia[j]
                    vt[j] = (vt[j] + dt * around / e.inertia[j]) / (1.0 + damp_t)
                else:
                    vx[j] = (vx[j] + dt * (along - grip * zx[j]) / e.mass[j]) / (1.0 + damp_x)
                    vt[j] = (vt[j] + dt * (around - radius * grip * zt[j]) / e.inertia[j]) / (1.0 + damp_t)
                tension_above, torque_above = tension_below, torque_below
            _drill(n, dt, time, pump, bite, e, c, x, vx, s)
            for j in range(n):
                x[j] += 0.5 * dt * vx[j]
                turn[j] += 0.5 * dt * vt[j]
            slot = int(s[STEPS]) % len(pulses)
            arriving = pulses[slot]
            pulses[slot] = s[MOTOR_PRESSURE]
            ripple = 1.0 + c.pump_ripple * math.sin(3.0 * pump * time)
            needed = circulating_pressure(pump, press, c, time) * ripple + arriving
            s[STANDPIPE] += c.pressure_share * (needed - s[STANDPIPE])
            even = s[DRIVE_SPEED] / math.sqrt(s[DRIVE_SPEED] * s[DRIVE_SPEED] + _STILL * _STILL)
            uneven = math.sin(s[DRIVE_ANGLE]) + 0.5 * math.sin(6.0 * s[DRIVE_ANGLE])
            torque = s[QUILL_TORQUE] * (1.0 + c.ripple * uneven) + c.motor_inertia * gain + c.motor_friction * even
            s[LAGGED_TORQUE] += c.torque_share * (c.torque_gain * torque - s[LAGGED_TORQUE])
            s[READ_TORQUE] += c.filter_share * (s[LAGGED_TORQUE] - s[READ_TORQUE])
        _read_out(out[first + m], b, e, c, x, vx, turn, vt, s)
        out[first + m, 1] = e.axial_spring[0] * (x[0] - top)


@njit(**JIT_OPTIONS)
def _motor_speed(pump, c, s):
    """rad/s, of the bit against its housing."""
    share = s[MOTOR_PRESSURE] / c.stall_pressure
    return 2.0 * math.pi * pump * c.pump_displacement / c.motor_displacement * (1.0 - c.leak * share * share)


@njit(**JIT_OPTIONS)
def _cut(dt, time, pump, e, c, x, vx, s):
    """Factor by which the rock slows the bit within a step, less one: 0 off bottom and for a motor that stands."""
    j, motor = len(x) - 1, _motor_speed(pump, c, s)
    if motor <= 0.0 or s[STALLED] > 0.0 or vx[j] <= 0.0 or x[j] + dt * vx[j] < s[BOTTOM]:
        return 0.0
    factor = c.formation_factor if time >= c.formation_time else 1.0
    return dt / e.mass[j] * c.cutting_stiffness * factor * 2.0 * math.pi / motor


@njit(**JIT_OPTIONS)
def _drill(n, dt, time, pump, bite, e, c, x, vx, s):
    """Bit, rock and motor (`model.md` section 4): weight from depth of cut, implicit in the bit's speed."""
    j = n - 1
    motor = _motor_speed(pump, c, s)
    push = dt / e.mass[j]
    factor = c.formation_factor if time >= c.formation_time else 1.0
    s[WEIGHT] = 0.0
    if vx[j] > 0.0 and x[j] + dt * vx[j] >= s[BOTTOM]:
        fast = vx[j]
        if s[STALLED] > 0.0 or motor <= 0.0:
            vx[j] = 0.0
        else:
            vx[j] = fast / (1.0 + push * c.cutting_stiffness * factor * 2.0 * math.pi / motor)
        s[WEIGHT] = (fast - vx[j]) / push
        s[BOTTOM] = max(s[BOTTOM], x[j] + dt * vx[j])
    wanted = bite * c.bit_lever * s[WEIGHT]
    most = c.torque_per_pressure * c.stall_pressure
    if s[WEIGHT] == 0.0:
        s[STALLED] = 0.0
    elif motor > 0.0 and wanted >= most:
        s[STALLED] = 1.0
    s[BIT_TORQUE] = most if s[STALLED] > 0.0 else (wanted if motor > 0.0 else 0.0)
    s[MOTOR_PRESSURE] = s[BIT_TORQUE] / c.torque_per_pressure


@njit(**JIT_OPTIONS)
def _read_out(row, at, e, c, x, vx, turn, vt, s):
    """One row of the channels; hook load is set by the caller, who knows where the block is."""
    n = len(x)
    row[0] = s[READ_TORQUE] + c.torque_bias
    row[1] = e.axial_spring[0] * (x[0] - at[3])
    row[2] = s[STANDPIPE]
    row[3] = turn[n - 1] + c.tool_face_offset
    row[4] = vt[n - 1]
    row[5], row[6], row[7] = s[BIT_TORQUE], s[WEIGHT], s[MOTOR_PRESSURE]
    row[8] = x[n - 1] + c.depth_offset
    row[9] = vx[n - 1]
    row[10], row[11] = s[DRIVE_ANGLE], s[DRIVE_SPEED]
