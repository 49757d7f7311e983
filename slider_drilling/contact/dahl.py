"""Deformation of an asperity: Dahl's law in two dimensions (paper section 3.3.2).

M = (x, y) is where the asperity's end point stands, in m from its foot O, x along the hole and y around it;
r = |M|; d = (dx, dy) is how far the pipe moves; z_ss = mu F_N / kt is the deformation at which it slides.

Paper eq. 7 and 8 together are Dahl's law along the current radius,

    dz/dr = g(sgn(dr), z / z_ss),    g(sigma, s) = (1 - sigma s)^i  with the sign of the base kept.

The model is the polar ODE r' = v_r g, r psi' = v_transverse (`rate`), in Cartesian terms

    M' = v - lambda M,    lambda = v_r (1 - g(sgn(v_r), r / z_ss)) / r  >= 0,    v_r = v . M / r

because M' = v - v_r rhat + r' rhat. For i = 1, lambda = |v_r| / z_ss. The slip v - M' = lambda M is
therefore parallel to M: beta_v (eq. 21) is M's own direction, with no differencing, and is known even while
nothing slips.

`two_step` is the paper's operator (eq. 11-18): the tangential step, then the axial one, each changing the
radius by Dahl's law in closed form. Its limit for dt -> 0, reached at first order, is `two_step_rate`,
where each axis relaxes by its own share of v_r:

    lambda = sum over k = x, y of  (v_k k / r) (1 - g(sgn(v_k k), r / z_ss)) / r.

That is the polar ODE wherever v_x x and v_y y have the same sign, as in all steady sliding. Where they oppose
(just after a reversal) the operator relaxes too fast, for i = 1 by (|v_x x| + |v_y y|) / |v_x x + v_y y|, and
depends on how the axes are turned, which a contact cannot.

`advance` is the scheme that everything else steps. With u = lambda dt frozen at the midpoint the ODE is
solved by M e^-u + d (1 - e^-u)/u; both factors are replaced by the (2, 2) Pade approximant of e^-u,

    M_new = (M (1 - u/2 + u^2/12) + d) / (1 + u/2 + u^2/12),

which has the same fixed point M = d/u, errs by u^5/720 (to leading order) where the pipe moves u z_ss in a
step, needs no transcendental, and cannot overshoot since 0 < numerator/denominator <= 1 for every u >= 0.
Second order in dt. Steps should stay well below u = 3, beyond which the approximant decays slower than the
exponential (it is never unstable).
"""

from __future__ import annotations

import math

from numba import njit
from numpy.typing import NDArray

compiled = njit(cache=True, error_model="numpy", nogil=True)


@compiled
def signed_power(base: float, exponent: float) -> float:
    """|base|^exponent with the sign of the base."""
    if exponent == 1.0:
        return base
    return math.copysign(abs(base) ** exponent, base)


@compiled
def friction_of_direction(x: float, y: float, axis_x: float, axis_y: float, table: NDArray, fallback: float) -> float:
    """Friction coefficient for a slip along (x, y), any length, from a table over q = cos^2(beta_v).

    (axis_x, axis_y): unit vector of the asperity's axis e3; table: (k,), as `friction_table` makes it;
    fallback: returned where (x, y) is zero and so has no direction.
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
    """Deformation M after the pipe moved by (dx, dy): one step of the polar ODE, second order.

    x, y, dx, dy, sliding_length (z_ss > 0): m; exponent: Dahl's i.
    """
    middle_x, middle_y = x + 0.5 * dx, y + 0.5 * dy
    squared = middle_x * middle_x + middle_y * middle_y
    if squared == 0.0:
        return x + dx, y + dy
    if exponent == 1.0:
        u = abs(dx * middle_x + dy * middle_y) / (math.sqrt(squared) * sliding_length)
    else:
        projection = dx * middle_x + dy * middle_y
        u = _decay_of_any_exponent(projection, math.sqrt(squared), sliding_length, exponent)
    twelfth = u * u / 12.0
    shrink = 1.0 - 0.5 * u + twelfth
    grow = 1.0 / (1.0 + 0.5 * u + twelfth)
    return (x * shrink + dx) * grow, (y * shrink + dy) * grow


@compiled
def _decay_of_any_exponent(projection: float, radius: float, sliding_length: float, exponent: float) -> float:
    """u = lambda dt for i != 1, where lambda depends on r too.

    M + d/2 leaves out the half step's own decay, a first-order error in r; the second pass takes it off.
    """
    radial = projection / radius
    u = _decay_rate(radial, radius, sliding_length, exponent)
    return _decay_rate(radial, radius / (1.0 + 0.5 * u), sliding_length, exponent)


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
    """`advance` with friction that depends on the slip's direction: (x, y, friction) after the step.

    length_per_friction: F_N / kt, m; the rest as in `advance` and `friction_of_direction`. The direction is
    that of M at mid-step, which keeps the second order. Where M and its motion are both zero the friction
    returned is that of a slip along e3; nothing depends on it then.
    """
    friction = friction_of_direction(x + 0.5 * dx, y + 0.5 * dy, axis_x, axis_y, table, table[-1])
    x, y = advance(x, y, dx, dy, friction * length_per_friction, exponent)
    return x, y, friction


@compiled
def rate(
    x: float, y: float, speed_x: float, speed_y: float, sliding_length: float, exponent: float
) -> tuple[float, float]:
    """dM/dt (m/s) of the polar ODE; speeds of the pipe in m/s, the rest as in `advance`."""
    radius = math.sqrt(x * x + y * y)
    if radius == 0.0:
        return speed_x, speed_y
    decay = _decay_rate((speed_x * x + speed_y * y) / radius, radius, sliding_length, exponent)
    return speed_x - decay * x, speed_y - decay * y


@compiled
def two_step_rate(
    x: float, y: float, speed_x: float, speed_y: float, sliding_length: float, exponent: float
) -> tuple[float, float]:
    """dM/dt (m/s) that `two_step` tends to for dt -> 0; speeds of the pipe in m/s, the rest as in `advance`.

    The paper's splitting, not a contact: see the module's docstring.
    """
    radius = math.sqrt(x * x + y * y)
    if radius == 0.0:
        return speed_x, speed_y
    decay = _decay_rate(speed_x * x / radius, radius, sliding_length, exponent)
    decay += _decay_rate(speed_y * y / radius, radius, sliding_length, exponent)
    return speed_x - decay * x, speed_y - decay * y


@compiled
def _decay_rate(radial: float, radius: float, sliding_length: float, exponent: float) -> float:
    """lambda for a radial speed; with a radial displacement instead, u = lambda dt."""
    sigma = 1.0 if radial >= 0.0 else -1.0
    return radial * (1.0 - signed_power(1.0 - sigma * radius / sliding_length, exponent)) / radius


@compiled
def along_radius(z: float, dr: float, sliding_length: float, exponent: float) -> float:
    """Dahl's law dz/dr = (1 - sgn(dr) z / z_ss)^i integrated exactly over dr (all in m), for any exponent.

    With w = 1 - sgn(dr) z/z_ss the law is dw/d|dr| = -w^i/z_ss: an exponential for i = 1, a power otherwise.
    For i < 1 it reaches w = 0, sliding, within a finite distance and stays there.
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

    Eq. 12 and 16 are integrated exactly instead of by one Euler step. A z' that comes out negative (M crosses
    its foot during the step) keeps its sign, where eq. 14 and 18 print its magnitude.
    """
    x, y = _moved_along(x, y, 0.0, dy, sliding_length, exponent)
    return _moved_along(x, y, dx, 0.0, sliding_length, exponent)


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
    """`two_step` with eq. 20 and 21: (x, y, friction) after the step, friction being that of the step's slip.

    friction: what the step before returned, which this step slides at. Where the slip is negligible (1e-12 of
    z_ss) it stays.
    """
    x1, y1 = two_step(x, y, dx, dy, friction * length_per_friction, exponent)
    slip_x, slip_y = dx - (x1 - x), dy - (y1 - y)
    if slip_x * slip_x + slip_y * slip_y > (1e-12 * friction * length_per_friction) ** 2:
        friction = friction_of_direction(slip_x, slip_y, axis_x, axis_y, table, friction)
    return x1, y1, friction


@compiled
def _moved_along(
    x: float, y: float, dx: float, dy: float, sliding_length: float, exponent: float
) -> tuple[float, float]:
    before = math.sqrt(x * x + y * y)
    x, y = x + dx, y + dy
    after = math.sqrt(x * x + y * y)
    if after == 0.0:
        return x, y
    scale = along_radius(before, after - before, sliding_length, exponent) / after
    return x * scale, y * scale
