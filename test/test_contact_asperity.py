"""Section 1 of the model: Challen-Oxley regimes and the effective attack angle."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slider_drilling.contact import (
    PAPER,
    WearMode,
    effective_attack_angle,
    friction_coefficient,
    friction_coefficient_of_direction,
    friction_table,
    wear_mode,
)
from slider_drilling.errors import InputError

ANGLES = np.linspace(0.005, 0.5 * math.pi - 0.005, 400)


def ploughing_limit(shear_factor: float) -> float:
    """The largest attack angle that ploughs, by bisection on the regime alone."""
    low, high = 1e-4, 0.5 * math.pi - 1e-4
    for _ in range(80):
        middle = 0.5 * (low + high)
        if wear_mode(shear_factor, middle) == WearMode.PLOUGHING:
            low = middle
        else:
            high = middle
    return low


def test_zero_shear_gives_tangent_of_attack_angle():
    assert friction_coefficient(0.0, ANGLES) == pytest.approx(np.tan(ANGLES), rel=1e-12)
    assert set(wear_mode(0.0, ANGLES)) == {WearMode.PLOUGHING, WearMode.CUTTING}


@pytest.mark.parametrize("shear_factor", [0.05, 0.1, 0.3, 0.5, 0.8])
def test_ploughing_and_wedge_meet_continuously(shear_factor):
    boundary = ploughing_limit(shear_factor)
    below, above = boundary - 1e-9, boundary + 1e-9
    assert wear_mode(shear_factor, below) == WearMode.PLOUGHING
    assert wear_mode(shear_factor, above) == WearMode.WEDGE_FORMATION
    assert friction_coefficient(shear_factor, below) == pytest.approx(
        friction_coefficient(shear_factor, above), rel=1e-7
    )


def test_ploughing_ends_at_zero_fan_angle():
    f, t = 0.2, ploughing_limit(0.2)
    fan = 0.25 * math.pi + 0.5 * math.acos(f) - t - math.asin(math.sin(t) / math.sqrt(1.0 - f))
    assert fan == pytest.approx(0.0, abs=1e-9)


@given(
    shear_factor=st.floats(0.0, 0.98),
    fraction=st.floats(0.02, 0.97),
    step=st.floats(1e-4, 0.02),
)
def test_ploughing_friction_rises_with_angle_and_with_shear(shear_factor, fraction, step):
    angle = fraction * ploughing_limit(min(shear_factor + step, 0.99))
    friction = float(friction_coefficient(shear_factor, angle))
    assert wear_mode(shear_factor, angle) == WearMode.PLOUGHING
    assert friction_coefficient(shear_factor, angle * (1.0 + step)) > friction
    assert friction_coefficient(min(shear_factor + step, 0.99), angle) > friction


@pytest.mark.parametrize("shear_factor", [0.0, 0.1, 0.4, 0.9])
def test_friction_is_one_where_cutting_begins(shear_factor):
    boundary = 0.5 * math.pi - 0.5 * math.acos(shear_factor)
    assert wear_mode(shear_factor, boundary + 1e-9) == WearMode.CUTTING
    assert friction_coefficient(shear_factor, boundary + 1e-9) == pytest.approx(1.0, abs=1e-8)
    assert friction_coefficient(shear_factor, boundary + 0.1) > 1.0


def test_paper_contact_lies_in_field_range():
    beta_v = np.array([0.0, 0.5 * math.pi])
    assert np.degrees(effective_attack_angle(PAPER.asperity, beta_v)) == pytest.approx([17.228, 11.698], abs=1e-3)
    assert friction_coefficient_of_direction(PAPER, beta_v) == pytest.approx([0.3392, 0.2320], abs=1e-4)


def test_shape_factor_one_exceeds_field_range():
    steep = replace(PAPER.asperity, shape_factor=1.0)
    assert np.degrees(effective_attack_angle(steep, [0.5 * math.pi, 0.0])) == pytest.approx([33.0, 44.2], abs=0.1)


def test_slip_direction_has_no_sign():
    beta_v = np.linspace(0.0, math.pi, 50)
    there = friction_coefficient_of_direction(PAPER, beta_v)
    assert there == pytest.approx(friction_coefficient_of_direction(PAPER, math.pi - beta_v), rel=1e-12)
    assert there == pytest.approx(friction_coefficient_of_direction(PAPER, -beta_v), rel=1e-12)


@pytest.mark.parametrize("size", [65, 257])
def test_friction_table_interpolates_at_second_order(size):
    beta_v = np.linspace(0.0, 0.5 * math.pi, 20001)
    exact = friction_coefficient_of_direction(PAPER, beta_v)

    def error(entries):
        table = friction_table(PAPER.shear_factor, PAPER.asperity, entries)
        return np.abs(np.interp(np.cos(beta_v) ** 2, np.linspace(0.0, 1.0, entries), table) - exact).max()

    assert error(size) < 2e-7 * (256 / (size - 1)) ** 2
    assert error(2 * size - 1) == pytest.approx(0.25 * error(size), rel=0.05)


def test_no_steady_wedge_names_angle_and_shear():
    assert wear_mode(0.5, 1.0) == WearMode.NO_STEADY_SOLUTION
    with pytest.raises(InputError, match=r"shear_factor = 0\.5 with attack angle = 1 rad"):
        friction_coefficient(0.5, [0.2, 1.0])


@pytest.mark.parametrize(
    ("shear_factor", "attack_angle", "message"),
    [
        (1.0, 0.3, "shear_factor = 1"),
        (-0.1, 0.3, "shear_factor = -0.1"),
        (math.nan, 0.3, "shear_factor = nan"),
        (0.1, 0.0, "attack angle = 0"),
        (0.1, 0.5 * math.pi, "attack angle = 1.57"),
        ([0.1, 0.2], [0.3, math.nan], "attack angle = nan"),
    ],
)
def test_values_outside_the_model_are_named(shear_factor, attack_angle, message):
    with pytest.raises(InputError, match=message):
        friction_coefficient(shear_factor, attack_angle)


@pytest.mark.parametrize("name", ["height", "minor_axis", "major_axis", "shape_factor"])
@pytest.mark.parametrize("value", [0.0, -1e-6, math.nan, math.inf])
def test_asperity_without_positive_axes_is_refused(name, value):
    with pytest.raises(InputError, match=f"asperity.{name}"):
        friction_table(0.1, replace(PAPER.asperity, **{name: value}))


def test_a_table_needs_two_entries():
    with pytest.raises(InputError, match="size = 1"):
        friction_table(0.1, PAPER.asperity, 1)
