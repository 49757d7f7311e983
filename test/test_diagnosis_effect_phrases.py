"""An effect's values and an unknown's shape as a driller says them: sign, size and unit, and nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slider_drilling.diagnosis import sentences
from slider_drilling.diagnosis.catalogue import catalogue, to_user
from slider_drilling.diagnosis.describe_curve import describe_curve
from slider_drilling.diagnosis.effect_phrases import effect_phrase
from slider_drilling.diagnosis.figures import shape
from slider_drilling.diagnosis.result import FittedParameter, RankedEffect, ResidualShape


@pytest.mark.parametrize("effect", catalogue(3000.0, 400.0), ids=lambda effect: effect.name)
def test_every_effect_has_words_of_its_own(effect):
    told = to_user(effect.values(effect.scan[0]), 3000.0)
    text = effect_phrase(effect.name, {name.rpartition(".")[2]: value for name, value in told.items()})
    assert text[0].isupper()
    assert "_" not in text
    assert not text.startswith(effect.name.replace("_", " ").capitalize() + " (")


@pytest.mark.parametrize(
    ("effect", "values", "says"),
    [
        ("torque_sensor_gain", {"gain": 1.0 / 1.3558 - 1.0}, "26 % too low, as if ft lbf were read as N m"),
        ("torque_sensor_gain", {"gain": 0.3558}, "36 % too high, as if N m were read as ft lbf"),
        ("torque_sensor_gain", {"gain": -0.1}, "10 % too low"),
        ("torque_sensor_bias", {"bias": -1250.0}, "1.25 kN m too low"),
        ("motor_wear", {"torque_loss": 0.004, "extra_leak": 0.2}, "The motor loses 20 % more of its speed"),
        ("friction_drift", {"rate": -5e-4}, "falls by 3.0 % a minute"),
        ("tortuosity", {"curvature": math.radians(1.0) / 30.0}, "1.0 deg per 30 m"),
        ("top_drive_backlash", {"angle": math.radians(25.0)}, "25 deg of play"),
        ("cuttings_bed", {"factor": 1.6, "top": 2411.0, "bottom": 2903.0}, "1.60 times as high between 2411 and"),
    ],
)  # fmt: skip
def test_phrases_state_sign_size_and_unit(effect, values, says):
    assert says in effect_phrase(effect, values)


@pytest.mark.parametrize("effect", catalogue(3000.0, 400.0), ids=lambda effect: effect.name)
def test_what_a_log_does_not_tell_of_an_effect_is_left_out_of_its_words(effect):
    told = to_user(effect.values(effect.scan[0]), 3000.0)
    amplitude = next(iter(told))
    fitted = {
        name: FittedParameter(value, "-", 0.0, None if name == amplitude else (0.0, 10.0))
        for name, value in told.items()
    }
    named = RankedEffect(effect.name, effect.site, True, True, (), None, None, fitted, ())
    text = sentences._named(named)
    assert text[0].isupper()
    if effect.name != "cuttings_bed":
        assert text == effect_phrase(effect.name, {amplitude.rpartition(".")[2]: told[amplitude]})


@pytest.mark.parametrize(
    ("x_unit", "y_unit", "curve", "says"),
    [
        ("s", "Pa", lambda x: -2e5 * x / 60.0, "falls by 2.0 bar a minute"),
        ("Pa", "Pa", lambda x: 0.03 * x + 1.0, "rises by 3.0 % of itself"),
        ("rad", "N m", lambda x: -1e4 * x, "falls by 0.17 kN m per deg"),
        ("m", "-", lambda x: np.where(x > 205.0, 0.4, 0.0), "steps up by 40 % between 171 m and 229 m"),
        ("m", "-", lambda x: np.exp(-(((x - 229.0) / 60.0) ** 2)), "most, 100 %, at 229 m"),
        ("s", "N", lambda x: 0.0 * x + 4e3, "by 4.0 kN"),
    ],
)
def test_the_shape_of_an_unknown_is_told_with_its_numbers_and_units(x_unit, y_unit, curve, says):
    x = np.linspace(0.0, 400.0, 8)
    told = describe_curve("reading off", x, x_unit, curve(x), y_unit)
    assert told.startswith("reading off")
    assert says in told


@pytest.mark.parametrize(("y", "says"), [(0.24, "by 24 %"), (-0.5, "by -50 %"), (9.0, "by a factor of 10")])
def test_a_shape_of_one_number_is_a_sentence_and_no_empty_picture(y, says):
    told = describe_curve("contact that gives way", np.zeros(1), "-", np.array([y]), "-")
    assert told == f"contact that gives way, {says}"
    shown = shape(
        ResidualShape("unknown", told, "all of it, -", "contact that gives way, -", np.zeros(1), np.array([y]))
    )
    assert shown == f"What the unknown looks like: {told}."


def test_a_drift_known_by_its_ends_is_told_by_its_rate():
    words = "pressure off by an amount that drifts with time"
    told = describe_curve(words, np.array([0.0, 120.0]), "s", np.array([1e4, -3.9e5]), "Pa")
    assert told == f"{words}: falls by 2.0 bar a minute"


def test_the_picture_of_a_shape_has_the_units_of_its_words():
    time, lost = np.array([0.0, 60.0, 120.0]), np.array([0.0, 2e5, 4e5])
    told = describe_curve("pressure off by an amount that follows time", time, "s", lost, "Pa")
    assert told.endswith("rises by 2.0 bar a minute")
    drawn = shape(ResidualShape("rest", told, "time, s", "pressure off, Pa", time, lost))
    (panel,) = drawn.panels
    assert (drawn.x_label, panel.y_label) == ("time, s", "pressure off, bar")
    np.testing.assert_allclose(panel.marks[0].y, [0.0, 2.0, 4.0])
