"""Section 2 of the model: the two-step operator, its limit, and the scheme that everything steps."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numba import njit
from scipy.integrate import quad

from slider_drilling.contact import PAPER, friction_table
from slider_drilling.contact.dahl import (
    advance,
    advance_on_table,
    along_radius,
    friction_of_direction,
    polar_rate,
    rate,
    signed_power,
    two_step,
)

LENGTH = 0.4
START = (0.05, 0.1)
PER_FRICTION = 1.3
EXPONENTS = [0.5, 1.0, 1.5, 2.0]
TABLE = friction_table(PAPER.shear_factor, PAPER.asperity)
MODEL, POLAR, ON_TABLE, OPERATOR = 0, 1, 2, 3


@njit
def position(t, together):
    if together:
        return 0.5 * t + 0.4 / 3.0 * math.sin(3.0 * t), t - 0.18 * math.cos(5.0 * t)
    return 0.5 * t + 0.3 * math.sin(3.0 * t), 1.5 * math.cos(2.0 * t + 0.3)


@njit
def slope(law, t, x, y, together, exponent, table):
    if together:
        vx, vy = 0.5 + 0.4 * math.cos(3.0 * t), 1.0 + 0.9 * math.sin(5.0 * t)
    else:
        vx, vy = 0.5 + 0.9 * math.cos(3.0 * t), -3.0 * math.sin(2.0 * t + 0.3)
    if law == POLAR:
        return polar_rate(x, y, vx, vy, LENGTH, exponent)
    length = LENGTH
    if law == ON_TABLE:
        length = PER_FRICTION * friction_of_direction(x, y, 1.0, 0.0, table, table[-1])
    return rate(x, y, vx, vy, length, exponent)


@njit
def limit(law, duration, together, exponent, table):
    """The law by classical Runge-Kutta with steps far below any tested one."""
    x, y = START
    steps = 400_000
    h = duration / steps
    for k in range(steps):
        t = k * h
        a, b = slope(law, t, x, y, together, exponent, table)
        c, d = slope(law, t + 0.5 * h, x + 0.5 * h * a, y + 0.5 * h * b, together, exponent, table)
        e, f = slope(law, t + 0.5 * h, x + 0.5 * h * c, y + 0.5 * h * d, together, exponent, table)
        g, i = slope(law, t + h, x + h * e, y + h * f, together, exponent, table)
        x += h / 6.0 * (a + 2.0 * c + 2.0 * e + g)
        y += h / 6.0 * (b + 2.0 * d + 2.0 * f + i)
    return x, y


@njit
def stepped(law, duration, together, exponent, steps, table):
    x, y = START
    for k in range(steps):
        x0, y0 = position(k * duration / steps, together)
        x1, y1 = position((k + 1) * duration / steps, together)
        if law == OPERATOR:
            x, y = two_step(x, y, x1 - x0, y1 - y0, LENGTH, exponent)
        elif law == MODEL:
            x, y = advance(x, y, x1 - x0, y1 - y0, LENGTH, exponent)
        else:
            x, y, _ = advance_on_table(x, y, x1 - x0, y1 - y0, PER_FRICTION, exponent, 1.0, 0.0, table)
    return x, y


def order(scheme, law, duration=1.1, together=False, exponent=1.0, coarse=500):
    exact = limit(law, duration, together, exponent, TABLE)
    errors = [math.dist(stepped(scheme, duration, together, exponent, coarse * k, TABLE), exact) for k in (1, 4)]
    return math.log(errors[0] / errors[1], 4.0), errors[1]


@pytest.mark.parametrize("duration", [1.1, 4.0])
@pytest.mark.parametrize("exponent", EXPONENTS)
def test_operator_converges_at_first_order(exponent, duration):
    measured, error = order(OPERATOR, MODEL, duration, exponent=exponent)
    assert measured == pytest.approx(1.0, abs=0.05)
    assert error < 4e-3 * LENGTH * duration


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_operator_meets_polar_ode_where_axes_agree(exponent):
    measured, error = order(OPERATOR, POLAR, 1.5, together=True, exponent=exponent)
    assert measured == pytest.approx(1.0, abs=0.05)
    assert error < 4e-3 * LENGTH


def test_operator_misses_polar_ode_where_axes_oppose():
    """What the splitting costs: the error stops falling near 1e-3 of z_ss, however short the step."""
    measured, error = order(OPERATOR, POLAR, 1.1, coarse=4000)
    assert measured < 0.1
    assert 5e-4 * LENGTH < error < 1e-3 * LENGTH


@given(
    angle=st.floats(0.0, 2.0 * math.pi),
    heading=st.floats(0.0, 2.0 * math.pi),
    radius=st.floats(0.01, 1.2),
    exponent=st.sampled_from(EXPONENTS),
)
def test_model_equals_polar_ode_where_axes_agree(angle, heading, radius, exponent):
    x, y = radius * LENGTH * math.cos(angle), radius * LENGTH * math.sin(angle)
    vx, vy = math.cos(heading), math.sin(heading)
    polar = np.array(polar_rate(x, y, vx, vy, LENGTH, exponent))
    model = np.array(rate(x, y, vx, vy, LENGTH, exponent))
    if vx * x >= 0.0 and vy * y >= 0.0:
        assert model == pytest.approx(polar, abs=1e-9)
    elif exponent == 1.0:
        # The axes oppose: each relaxes on its own, never by less than both together.
        loss, model_loss = ((np.array([vx, vy]) - rate_) @ (x, y) for rate_ in (polar, model))
        assert model_loss >= loss - 1e-12


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_scheme_converges_at_second_order(exponent):
    measured, error = order(MODEL, MODEL, exponent=exponent)
    # i = 1/2 slides after a finite distance, where its rate has a kink that costs half an order.
    assert measured == pytest.approx(2.0, abs=0.1) if exponent != 0.5 else measured > 1.3
    assert error < 1e-4 * LENGTH


def test_scheme_keeps_second_order_with_anisotropic_friction():
    measured, _ = order(ON_TABLE, ON_TABLE)
    assert measured == pytest.approx(2.0, abs=0.1)


@given(
    along=st.floats(-1.2, 1.2),
    travel=st.floats(1e-6, 1.0),
    heading=st.floats(0.0, 2.0 * math.pi),
)
def test_straight_step_error_is_of_fifth_order(along, travel, heading):
    """M along the motion, not crossing its foot: the law is linear and only the approximant is inexact."""
    x, exact = along * LENGTH, along * LENGTH * math.exp(-travel) + LENGTH * (1.0 - math.exp(-travel))
    assume(x * (x + travel * LENGTH) >= 0.0)
    c, s = math.cos(heading), math.sin(heading)
    stepped_x, stepped_y = advance(x * c, x * s, travel * LENGTH * c, travel * LENGTH * s, LENGTH, 1.0)
    error = math.hypot(stepped_x - exact * c, stepped_y - exact * s)
    assert error <= 2.2 * LENGTH * (travel**5 / 115.0 + 1e-14)


@given(
    radius=st.floats(0.0, 1.0),
    angle=st.floats(0.0, 2.0 * math.pi),
    travel=st.floats(1e-3, 1e3),
)
def test_straight_step_never_overshoots(radius, angle, travel):
    start = radius * LENGTH * math.copysign(1.0, math.cos(angle))
    x, _ = advance(start, 0.0, travel * LENGTH, 0.0, LENGTH, 1.0)
    assert x <= LENGTH * (1.0 + 1e-12)
    assert x >= -LENGTH


@given(
    radius=st.floats(0.01, 1.0),
    angle=st.floats(0.0, 2.0 * math.pi),
    travel=st.floats(1e-4, 0.05),
    heading=st.floats(0.0, 2.0 * math.pi),
)
def test_slip_is_parallel_to_the_deformation(radius, angle, travel, heading):
    x, y = radius * LENGTH * math.cos(angle), radius * LENGTH * math.sin(angle)
    dx, dy = travel * LENGTH * math.cos(heading), travel * LENGTH * math.sin(heading)
    x1, y1 = advance(x, y, dx, dy, LENGTH, 1.0)
    slip = dx - (x1 - x), dy - (y1 - y)
    middle = 0.5 * (x + x1), 0.5 * (y + y1)
    # Exactly so in the limit; in one step up to u/6 of the deformation's own change.
    assert abs(slip[0] * middle[1] - slip[1] * middle[0]) <= (
        math.hypot(*slip) * (travel * LENGTH) * travel / 5.0 + 1e-12 * LENGTH**2
    )
    assert slip[0] * middle[0] + slip[1] * middle[1] >= -1e-15


@njit
def many_small_steps_along_radius(z, dr, exponent):
    sigma = math.copysign(1.0, dr)
    h = dr / 200_000
    for _ in range(200_000):
        middle = z + 0.5 * h * signed_power(1.0 - sigma * z / LENGTH, exponent)
        z += h * signed_power(1.0 - sigma * middle / LENGTH, exponent)
    return z


@pytest.mark.parametrize("exponent", [0.3, *EXPONENTS, 3.0])
@pytest.mark.parametrize("start", [-0.9, 0.0, 0.4, 1.3])
@pytest.mark.parametrize("dr", [-0.11, 0.02, 0.9])
def test_closed_form_solves_dahls_law(exponent, start, dr):
    exact = many_small_steps_along_radius(start * LENGTH, dr, exponent)
    assert along_radius(start * LENGTH, dr, LENGTH, exponent) == pytest.approx(exact, abs=2e-6)


def test_closed_form_is_additive():
    whole = along_radius(0.1, 0.7, LENGTH, 1.0)
    halfway = along_radius(0.1, 0.3, LENGTH, 1.0)
    assert along_radius(halfway, 0.4, LENGTH, 1.0) == pytest.approx(whole, rel=1e-13)


@njit
def work_and_stored_energy(path, length, exponent):
    """Work (per unit stiffness) done on a contact along a path, and what it stores in the end."""
    x, y, work = 0.0, 0.0, 0.0
    for k in range(len(path) - 1):
        dx, dy = path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1]
        x1, y1 = advance(x, y, dx, dy, length, exponent)
        work += 0.5 * ((x + x1) * dx + (y + y1) * dy)
        x, y = x1, y1
    return work, 0.5 * (x * x + y * y)


@given(
    amplitudes=st.lists(st.tuples(*[st.floats(-1.0, 1.0)] * 4), min_size=1, max_size=5),
    scale=st.floats(0.01, 20.0),
    exponent=st.sampled_from(EXPONENTS),
)
def test_no_closed_path_gains_energy(amplitudes, scale, exponent):
    t = np.linspace(0.0, 2.0 * math.pi, 4001)
    path = np.zeros((t.size, 2))
    for k, (a, b, c, d) in enumerate(amplitudes, start=1):
        path[:, 0] += scale * LENGTH * (a * np.sin(k * t) + b * (np.cos(k * t) - 1.0)) / k
        path[:, 1] += scale * LENGTH * (c * np.sin(k * t) + d * (np.cos(k * t) - 1.0)) / k
    work, stored = work_and_stored_energy(path, LENGTH, exponent)
    assert work >= stored - 1e-6 * (stored + LENGTH**2 * scale**2 * 1e-3)


@njit
def coasting_energy(speed_x, speed_y, stiffness, length, exponent, table, steps, dt):
    """Kinetic and stored energy of 1 kg on one contact, unforced (velocity Verlet), at every step."""
    x = y = 0.0
    energy = np.empty(steps)
    for k in range(steps):
        half_x, half_y = speed_x - 0.5 * dt * stiffness * x, speed_y - 0.5 * dt * stiffness * y
        x, y, _ = advance_on_table(x, y, half_x * dt, half_y * dt, length, exponent, 1.0, 0.0, table)
        speed_x, speed_y = half_x - 0.5 * dt * stiffness * x, half_y - 0.5 * dt * stiffness * y
        energy[k] = 0.5 * (speed_x**2 + speed_y**2) + 0.5 * stiffness * (x * x + y * y)
    return energy


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("heading", [0.0, 0.6, 1.4])
def test_an_unforced_contact_only_dissipates(exponent, heading):
    energy = coasting_energy(math.cos(heading), math.sin(heading), 100.0, 0.2, exponent, TABLE, 60000, 5e-4)
    # Verlet itself trades (omega dt)^2 of the energy back and forth; over a period (0.63 s) it may only fall.
    period = 1256
    peaks = energy[: energy.size // period * period].reshape(-1, period).max(axis=1)
    assert np.all(np.diff(peaks) < 0.0)
    assert np.diff(energy).max() < 1e-5 * energy[0]
    assert energy[-1] < (0.02 if exponent == 1.0 else 0.35) * energy[0]


def test_friction_without_direction_keeps_last_value():
    assert friction_of_direction(0.0, 0.0, 1.0, 0.0, TABLE, 0.123) == 0.123
    assert friction_of_direction(2.0, 0.0, 1.0, 0.0, TABLE, 0.123) == TABLE[-1]
    assert friction_of_direction(0.0, -2.0, 1.0, 0.0, TABLE, 0.123) == TABLE[0]


def test_contact_at_rest_stays_undeformed():
    assert advance(0.0, 0.0, 0.0, 0.0, LENGTH, 1.0) == (0.0, 0.0)
    assert two_step(0.0, 0.0, 0.0, 0.0, LENGTH, 1.0) == (0.0, 0.0)
    assert rate(0.0, 0.0, 0.2, 0.1, LENGTH, 1.0) == (0.2, 0.1)
    assert polar_rate(0.0, 0.0, 0.2, 0.1, LENGTH, 1.0) == (0.2, 0.1)


@njit
def steady_loop_work(amplitude, cycles=20, steps=20_000):
    """Work per unit stiffness over the last of some cycles of amplitude sin(t) along one axis."""
    x = y = work = 0.0
    for k in range(cycles * steps):
        t0, t1 = 2.0 * math.pi * k / steps, 2.0 * math.pi * (k + 1) / steps
        dx = amplitude * (math.sin(t1) - math.sin(t0))
        x1, y = advance(x, y, dx, 0.0, LENGTH, 1.0)
        if k >= (cycles - 1) * steps:
            work += 0.5 * (x + x1) * dx
        x = x1
    return work


def test_dahl_loop_dissipates_its_closed_form():
    """i = 1, steady strokes of +-A: the loop's area from the exponential branches, by quadrature."""
    amplitude = 0.3
    work = steady_loop_work(amplitude)
    turn = LENGTH * math.tanh(amplitude / LENGTH)
    area = 2.0 * quad(lambda r: LENGTH - (LENGTH + turn) * math.exp(-r / LENGTH), 0.0, 2.0 * amplitude)[0]
    assert work == pytest.approx(area, rel=1e-4)
