"""Friction histories: closed-form limits of the model's section 2, signs, units, any motion."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipk

from slider_drilling.contact import PAPER, friction_coefficient_of_direction, friction_history
from slider_drilling.errors import InputError

LOAD = 1887.0
RADIUS = 0.0635
ISOTROPIC = replace(PAPER, asperity=replace(PAPER.asperity, major_axis=PAPER.asperity.minor_axis))
FRICTION = float(friction_coefficient_of_direction(ISOTROPIC, 0.0))
STIFF = replace(ISOTROPIC, stiffness=100.0 * PAPER.stiffness)


def settled_ratio(feed, axial, tangential, period, contact=STIFF, cycles=3, samples=40_000, signed=False):
    """Axial over Coulomb friction in the last cycle; axial(t) and tangential(t) come on top of the feed."""
    phase = np.linspace(0.0, cycles * period, cycles * samples + 1)
    history = friction_history(phase, feed * phase + axial(phase), tangential(phase), LOAD, contact, RADIUS)
    means = history.means(since=(cycles - 1) * period)
    return (-means.axial_force if signed else means.absolute_axial_force) / (FRICTION * LOAD)


def still(t):
    return 0.0 * t


@pytest.mark.parametrize("speed_ratio", [0.2, 0.9, 1.1, 3.0])
def test_stiff_longitudinal_vibration_meets_rigid_limit(speed_ratio):
    """F/Fc = (2/pi) asin(v/va) for v < va, else 1; strokes of 0.1 m, far above z_ss, as rigid means."""
    amplitude, frequency = 0.1, 0.5
    va = 2.0 * math.pi * frequency * amplitude

    def shaking(t):
        return amplitude * np.sin(2.0 * math.pi * frequency * t)

    expected = 2.0 / math.pi * math.asin(min(speed_ratio, 1.0))
    assert settled_ratio(speed_ratio * va, shaking, still, 2.0, signed=True) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(("rpm", "expected"), [(10, 0.1213), (20, 0.0699), (30, 0.0502)])
def test_stiff_torsional_vibration_meets_rigid_limit(rpm, expected):
    """At 10 m/h and 0.01 Hz: the limit knows no frequency, but a slow swing is what makes 100 times rigid."""
    v, va, frequency = 10.0 / 3600.0, rpm * math.pi / 30.0 * RADIUS, 0.01
    closed = 2.0 / math.pi * v / math.hypot(v, va) * float(ellipk(va * va / (v * v + va * va)))
    assert closed == pytest.approx(expected, abs=5e-5)

    def swinging(t):
        return va / (2.0 * math.pi * frequency) * np.sin(2.0 * math.pi * frequency * t)

    assert settled_ratio(v, still, swinging, 100.0, cycles=2) == pytest.approx(closed, rel=0.01)


@pytest.mark.parametrize("turning", [0.0, 0.3, 2.0, 50.0])
def test_constant_rotation_meets_rigid_limit(turning):
    v = 0.003
    ratio = settled_ratio(v, still, lambda t: turning * v * t, 60.0, contact=ISOTROPIC, samples=4000)
    assert ratio == pytest.approx(1.0 / math.hypot(1.0, turning), rel=1e-3)


def test_friction_opposes_motion():
    t = np.linspace(0.0, 30.0, 3001)
    for forward, clockwise in ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)):
        history = friction_history(t, forward * 0.01 * t, clockwise * 0.01 * t, LOAD, PAPER, RADIUS)
        assert math.copysign(1.0, history.axial_force[-1]) == -forward
        assert math.copysign(1.0, history.torque[-1]) == -clockwise


def test_plain_sliding_ends_at_coulomb_friction():
    t = np.linspace(0.0, 60.0, 601)
    history = friction_history(t, 0.01 * t, 0.0 * t, LOAD, PAPER, RADIUS)
    assert -history.axial_force[-1] == pytest.approx(0.33916875 * LOAD, rel=1e-6)
    assert history.friction_coefficient[-1] == pytest.approx(0.33916875, rel=1e-6)
    assert history.beta_v[-1] == pytest.approx(0.0, abs=1e-6)
    turned = friction_history(t, 0.0 * t, 0.01 * t, LOAD, PAPER, RADIUS)
    assert -turned.torque[-1] == pytest.approx(0.23202333 * LOAD * RADIUS, rel=1e-6)
    assert turned.beta_v[-1] == pytest.approx(0.5 * math.pi, abs=1e-6)


def test_orientation_rotates_the_friction_axis():
    t = np.linspace(0.0, 60.0, 601)
    turned = replace(PAPER, asperity=replace(PAPER.asperity, orientation=0.5 * math.pi))
    history = friction_history(t, 0.01 * t, 0.0 * t, LOAD, turned, RADIUS)
    assert history.friction_coefficient[-1] == pytest.approx(0.23202333, rel=1e-6)


def test_pre_sliding_starts_at_the_stiffness():
    history = friction_history([0.0, 1.0], [0.0, 1e-6], [0.0, 0.0], LOAD, PAPER, RADIUS)
    assert -history.axial_force[-1] == pytest.approx(PAPER.stiffness * 1e-6, rel=1e-4)


@given(parts=st.integers(1, 60), angle=st.floats(0.0, 6.28), length=st.floats(1e-4, 0.5))
def test_straight_move_is_independent_of_sampling(parts, angle, length):
    t = np.linspace(0.0, 1.0, parts + 1)
    x, y = length * math.cos(angle) * t, length * math.sin(angle) * t
    coarse = friction_history(t[[0, -1]], x[[0, -1]], y[[0, -1]], LOAD, PAPER, RADIUS)
    fine = friction_history(t, x, y, LOAD, PAPER, RADIUS)
    assert coarse.axial_force[-1] == pytest.approx(fine.axial_force[-1], abs=1e-4 * LOAD)
    assert coarse.torque[-1] == pytest.approx(fine.torque[-1], abs=1e-4 * LOAD * RADIUS)


def test_fast_varying_load_acts_by_harmonic_mean():
    """One contact of constant kt; the paper's radial oscillator."""
    t = np.linspace(0.0, 100.0, 200_001)
    load = LOAD * (1.0 + 0.6 * np.sin(2.0 * math.pi * 10.0 * t))
    one = friction_history(t, 0.002 * t, 0.0 * t, load, PAPER, RADIUS)
    assert -one.means(since=90.0).axial_force == pytest.approx(0.8 * 0.33916875 * LOAD, rel=1e-3)
    string = friction_history(t, 0.002 * t, 0.0 * t, load, PAPER, RADIUS, stiffness_follows_load=True)
    assert -string.means(since=90.0).axial_force == pytest.approx(0.33916875 * LOAD, rel=1e-3)


def test_operator_and_scheme_agree_in_plain_sliding():
    t = np.linspace(0.0, 10.0, 20_001)
    x, y = 0.01 * t, 0.02 * t
    scheme = friction_history(t, x, y, LOAD, PAPER, RADIUS)
    operator = friction_history(t, x, y, LOAD, PAPER, RADIUS, paper_operator=True)
    assert operator.axial_force == pytest.approx(scheme.axial_force, abs=0.002 * LOAD)
    # Its first steps go around the hole before they go along it.
    assert operator.friction_coefficient[100:] == pytest.approx(scheme.friction_coefficient[100:], abs=0.002)


def test_means_separate_sign_and_magnitude():
    t = np.linspace(0.0, 4.0, 4001)
    history = friction_history(t, 0.1 * np.sin(math.pi * t), 0.0 * t, LOAD, PAPER, RADIUS)
    means = history.means(since=2.0)
    assert means.absolute_axial_force > 0.5 * 0.339 * LOAD
    assert abs(means.axial_force) < 0.01 * LOAD
    with pytest.raises(InputError, match="fewer than two samples"):
        history.means(since=3.9999)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": [0.0, 0.0, 1.0]}, "time"),
        ({"axial": [0.0, math.nan, 0.0]}, r"axial\[1\] = nan"),
        ({"tangential": [0.0, 1.0]}, "tangential has shape"),
        ({"normal_force": [1.0, 0.0, 1.0]}, r"normal_force\[1\] = 0.0 N"),
        ({"radius": 0.0}, "radius = 0.0"),
    ],
)
def test_input_that_cannot_be_used_is_named(change, message):
    sound = {"time": [0.0, 1.0, 2.0], "axial": [0.0] * 3, "tangential": [0.0] * 3, "normal_force": LOAD}
    with pytest.raises(InputError, match=message):
        friction_history(**{**sound, "contact": PAPER, "radius": RADIUS, **change})
