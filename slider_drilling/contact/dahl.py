"""Deformation of an asperity: Dahl's law in two dimensions (paper section 3.3.2).

M = (x, y) is the asperity's end point relative to its foot O, in m, x along the hole and y around it; r = |M|;
d = (dx, dy) is how far the pipe moves; z_ss = mu F_N / kt is the deformation at which it slides.

Paper eq. 7 and 8 together are Dahl's law along the current radius,

    dz/dr = g(sgn(dr), z / z_ss),    g(sigma, s) = (1 - sigma s)^i  with the sign of the base kept.

The paper applies it twice a step (`two_step`, eq. 11-18): to the tangential motion, then to the axial one, each with
the sign of its own part of the radial speed. For dt -> 0 this becomes the model that everything here and in the drill
string follows (`rate`):

    M' = v - lambda M,    lambda = sum over k = x, y of  (v_k k / r) (1 - g(sgn(v_k k), r / z_ss)) / r  >= 0,

and for i = 1 simply lambda = (|v_x x| + |v_y y|) / (r z_ss). The slip v - M' = lambda M is parallel to M, so beta_v
(eq. 21) is M's own direction: it needs no differences, and is known even while nothing slips.

A contact without axes would take the radial speed as a whole: the polar ODE r' = v_r g, r psi' = v_transverse
(`polar_rate`), with lambda = |v_r| / z_ss. The two agree wherever v_x x and v_y y have the same sign: in all steady
sliding, and so in every rigid limit. Where the signs differ (after a reversal, or in a vibration across a creep) the
paper's model relaxes faster. The paper's operator reproduces simulations of another program; the polar ODE misses them
by 10 degrees of toolface after five minutes.

`advance` is a step of second order. With u = lambda dt, frozen at mid-step, the solution is
M e^-u + d (1 - e^-u)/u. The inverse of the Taylor sum replaces e^-u:

    M_new = (M + d G) / (1 + u G),    G = 1 + u/2 + u^2/6 + u^3/24.

This has the same fixed point M = d/u, errs by u^5/120 (to leading order) where the pipe moves u z_ss in a step, needs
no transcendental function, never overshoots, and keeps nothing of M as u -> inf.
"""

from __future__ import annotations

import math

from numpy.typing import NDArray

from slider_drilling.process.jit_cache import njit

compiled = njit(cache=True, error_model="numpy", nogil=True)


@compiled
def signed_power(base: float, exponent: float) -> float:
    """|base|^exponent with the sign of the base."""
    if exponent == 1.0:
        return base
    return math.copysign(abs(base) ** exponent, base)


@compiled
def friction_of_direction(x: float, y: float, axis_x: float, axis_y: float, table: NDArray, fallback: float) -> float:
    """Friction coefficient for a slip along (x, y), of any length.

    Args:
        axis_x, axis_y: Unit vector of the asperity's axis e3.
        table: Friction over q = cos^2(beta_v), (k,), from `friction_table`.
        fallback: Returned where (x, y) is zero and so has no direction.
    """
    squared = x * x + y * y
    if squared == 0.0:
        return fallback
    along = x * axis_x + y * axis_y
    place = along * along / squared * (table.size - 1)
    k = min(int(place), table.size - 2)
    return table[k] + (place - k) * (table[k + 1] - table[k])


@compiled
def advance(x: float, y: float, dx: float, dy: float, sliding_length: float, exponent: float) -> tuple[float, float]:
    """Deformation M after the pipe moved by (dx, dy): one step of second order.

    Args:
        x, y, dx, dy: m.
        sliding_length: z_ss > 0, m.
        exponent: Dahl's i.
    """
    middle_x, middle_y = x + 0.5 * dx, y + 0.5 * dy
    squared = middle_x * middle_x + middle_y * middle_y
    if squared == 0.0:
        return x + dx, y + dy
    radius = math.sqrt(squared)
    along_x, along_y = dx * middle_x / radius, dy * middle_y / radius
    u = _decay(along_x, along_y, radius, sliding_length, exponent)
    if exponent != 1.0:
        # lambda depends on r too: without the half step's own decay r would have an error of first order.
        u = _decay(along_x, along_y, radius / (1.0 + 0.5 * u), sliding_length, exponent)
    growth = 1.0 + u * (1.0 / 2.0 + u * (1.0 / 6.0 + u * (1.0 / 24.0)))
    left = 1.0 / (1.0 + u * growth)
    return (x + dx * growth) * left, (y + dy * growth) * left


@compiled
def _decay(along_x: float, along_y: float, radius: float, sliding_length: float, exponent: float) -> float:
    """lambda from both axes' parts of the radial speed; u = lambda dt from their parts of a displacement."""
    decay = _decay_rate(along_x, radius, sliding_length, exponent)
    return decay + _decay_rate(along_y, radius, sliding_length, exponent)


@compiled
def advance_on_table(
    x: float,
    y: float,
    dx: float,
    dy: float,
    length_per_friction: float,
    exponent: float,
    axis_x: float,
    axis_y: float,
    table: NDArray,
) -> tuple[float, float, float]:
    """`advance` with friction that depends on the slip's direction.

    The direction is that of M at mid-step, which keeps the second order. Where M and its motion are both zero the
    friction is that of a slip along e3; nothing depends on it then.

    Args:
        length_per_friction: F_N / kt, m.
        x, y, dx, dy, exponent: As in `advance`.
        axis_x, axis_y, table: As in `friction_of_direction`.

    Returns:
        x, y and friction coefficient after the step.
    """
    friction = friction_of_direction(x + 0.5 * dx, y + 0.5 * dy, axis_x, axis_y, table, table[-1])
    x, y = advance(x, y, dx, dy, friction * length_per_friction, exponent)
    return x, y, friction


@compiled
def rate(
    x: float, y: float, speed_x: float, speed_y: float, sliding_length: float, exponent: float
) -> tuple[float, float]:
    """dM/dt (m/s) of the model; speeds of the pipe in m/s, the rest as in `advance`."""
    radius = math.sqrt(x * x + y * y)
    if radius == 0.0:
        return speed_x, speed_y
    decay = _decay(speed_x * x / radius, speed_y * y / radius, radius, sliding_length, exponent)
    return speed_x - decay * x, speed_y - decay * y


@compiled
def polar_rate(
    x: float, y: float, speed_x: float, speed_y: float, sliding_length: float, exponent: float
) -> tuple[float, float]:
    """dM/dt (m/s) of the polar ODE, for comparison; see the module's docstring."""
    radius = math.sqrt(x * x + y * y)
    if radius == 0.0:
        return speed_x, speed_y
    decay = _decay_rate((speed_x * x + speed_y * y) / radius, radius, sliding_length, exponent)
    return speed_x - decay * x, speed_y - decay * y


@compiled
def _decay_rate(radial: float, radius: float, sliding_length: float, exponent: float) -> float:
    """lambda for a radial speed; with a radial displacement instead, u = lambda dt."""
    sigma = 1.0 if radial >= 0.0 else -1.0
    return radial * (1.0 - signed_power(1.0 - sigma * radius / sliding_length, exponent)) / radius


@compiled
def along_radius(z: float, dr: float, sliding_length: float, exponent: float) -> float:
    """Dahl's law dz/dr = (1 - sgn(dr) z / z_ss)^i integrated exactly over dr (all in m), for any exponent.

    With w = 1 - sgn(dr) z/z_ss the law is dw/d|dr| = -w^i/z_ss: an exponential for i = 1, else a power. For i < 1 it
    reaches w = 0 (sliding) within a finite distance and stays there.
    """
    if dr == 0.0:
        return z
    sigma = 1.0 if dr > 0.0 else -1.0
    w = 1.0 - sigma * z / sliding_length
    distance = abs(dr) / sliding_length
    if w == 0.0:
        return z
    if exponent == 1.0:
        w *= math.exp(-distance)
    else:
        remaining = max(abs(w) ** (1.0 - exponent) - (1.0 - exponent) * distance, 0.0)
        w = math.copysign(remaining ** (1.0 / (1.0 - exponent)), w)
    return sigma * sliding_length * (1.0 - w)


@compiled
def two_step(x: float, y: float, dx: float, dy: float, sliding_length: float, exponent: float) -> tuple[float, float]:
    """The paper's operator, eq. 11-18: M after a tangential step dy, then an axial step dx. All in m.

    Eq. 12 and 16 are integrated exactly instead of by one Euler step. A z' that comes out negative (M crosses its foot
    during the step) keeps its sign, where eq. 14 and 18 print its magnitude.
    """
    x, y = _move_along_axis(x, y, 0.0, dy, sliding_length, exponent)
    return _move_along_axis(x, y, dx, 0.0, sliding_length, exponent)


@compiled
def two_step_on_table(
    x: float,
    y: float,
    dx: float,
    dy: float,
    length_per_friction: float,
    exponent: float,
    axis_x: float,
    axis_y: float,
    table: NDArray,
    friction: float,
) -> tuple[float, float, float]:
    """`two_step` with eq. 20 and 21: friction follows the direction of the step's slip.

    Args:
        friction: Coefficient that the previous step returned; this step slides at it. It stays where the slip is
            negligible (1e-12 of z_ss).

    Returns:
        x, y and friction coefficient after the step.
    """
    x1, y1 = two_step(x, y, dx, dy, friction * length_per_friction, exponent)
    slip_x, slip_y = dx - (x1 - x), dy - (y1 - y)
    if slip_x * slip_x + slip_y * slip_y > (1e-12 * friction * length_per_friction) ** 2:
        friction = friction_of_direction(slip_x, slip_y, axis_x, axis_y, table, friction)
    return x1, y1, friction


@compiled
def _move_along_axis(
    x: float, y: float, dx: float, dy: float, sliding_length: float, exponent: float
) -> tuple[float, float]:
    before = math.sqrt(x * x + y * y)
    x, y = x + dx, y + dy
    after = math.sqrt(x * x + y * y)
    if after == 0.0:
        return x, y
    scale = along_radius(before, after - before, sliding_length, exponent) / after
    return x * scale, y * scale
