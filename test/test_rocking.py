"""The rocking trajectory: its slopes, turning points, continuity and start."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slider_drilling.control.rocking import Rocking
from slider_drilling.errors import InputError

ROCKINGS = st.builds(lambda amplitude, period, share: Rocking(amplitude, period, share * period / 6.0),
                     st.floats(0.1, 100.0), st.floats(2.0, 100.0), st.floats(0.01, 1.0))


def test_paper_case():
    rocking = Rocking(amplitude=10.0, period=10.0, rounding=0.2)
    assert rocking.speed == pytest.approx(4.0)
    assert rocking.point(0.0) == (0.0, pytest.approx(4.0))
    assert rocking.point(1.0) == (pytest.approx(4.0), pytest.approx(4.0))
    assert rocking.point(2.5) == (pytest.approx(10.0 - 0.4), pytest.approx(0.0))
    assert rocking.point(4.0) == (pytest.approx(4.0), pytest.approx(-4.0))
    assert rocking.point(7.5) == (pytest.approx(-9.6), pytest.approx(0.0))
    assert rocking.point(9.0) == (pytest.approx(-4.0), pytest.approx(4.0))


@given(ROCKINGS, st.floats(0.0, 1.0))
def test_wave_is_antisymmetric(rocking, share):
    phase = share * rocking.period
    angle, speed = rocking.point(phase)
    opposite_angle, opposite_speed = rocking.point(phase + rocking.period / 2.0)
    assert opposite_angle == pytest.approx(-angle, abs=1e-9 * rocking.amplitude)
    assert opposite_speed == pytest.approx(-speed, abs=1e-9 * rocking.acceleration * rocking.period)


@given(ROCKINGS)
def test_speed_is_slope_of_angle(rocking):
    time = np.linspace(-0.1 * rocking.period, 1.5 * rocking.period, 801)
    angle, speed = np.array([rocking.from_rest(t) for t in time]).T
    step = time[1] - time[0]
    trapezoid = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * step)])
    assert np.max(np.abs(angle - trapezoid)) < 1e-3 * rocking.amplitude + rocking.acceleration * step**2
    assert np.max(np.abs(np.diff(speed))) <= rocking.acceleration * step * (1.0 + 1e-6)
    assert np.max(angle) <= rocking.turning_angle * (1.0 + 1e-12)
    assert np.max(np.abs(speed)) <= rocking.speed * (1.0 + 1e-12)


def test_start_is_from_rest():
    rocking = Rocking(20.0, 24.0, 0.25)
    assert rocking.from_rest(0.0) == (0.0, 0.0)
    assert rocking.from_rest(-1.0) == (0.0, 0.0)


@pytest.mark.parametrize("values", [(-1.0, 10.0, 0.2), (10.0, 0.0, 0.2), (10.0, 10.0, 0.0), (10.0, 10.0, 1.7),
                                    (math.nan, 10.0, 0.2), (10.0, math.inf, 0.2)])
def test_invalid_values_are_refused(values):
    with pytest.raises(InputError, match="rocking: "):
        Rocking(*values)
