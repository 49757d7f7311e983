"""An effect in a driller's words: sign, size and unit, and nothing else."""

from __future__ import annotations

import math

import pytest

from slider_drilling.diagnosis.catalogue import catalogue, to_user
from slider_drilling.diagnosis.effect_phrases import effect_phrase
from slider_drilling.units import FIELD


@pytest.mark.parametrize("effect", catalogue(3000.0, 400.0), ids=lambda effect: effect.name)
def test_every_effect_has_its_own_phrase(effect):
    values = to_user(effect.values(effect.scan[0]), 3000.0)
    text = str(effect_phrase(effect.name, {name.rpartition(".")[2]: value for name, value in values.items()}))
    assert text[0].isupper()
    assert "_" not in text
    assert not text.startswith(effect.name.replace("_", " ").capitalize() + " (")


@pytest.mark.parametrize(
    ("effect", "values", "expected"),
    [
        ("torque_sensor_gain", {"gain": 1.0 / 1.3558 - 1.0}, "26 % too low, as if ft lbf were read as N m"),
        ("torque_sensor_gain", {"gain": 0.3558}, "36 % too high, as if N m were read as ft lbf"),
        ("torque_sensor_gain", {"gain": -0.1}, "10 % too low"),
        ("torque_sensor_bias", {"bias": -1250.0}, "1.25 kN m too low"),
        ("motor_wear", {"torque_loss": 0.004, "extra_leak": 0.2}, "The motor loses 20 % more of its speed"),
        ("friction_drift", {"rate": -5e-4}, "falls by 3.0 % per minute"),
        ("tortuosity", {"curvature": math.radians(1.0) / 30.0}, "1.0 deg/30 m"),
        ("top_drive_backlash", {"angle": math.radians(25.0)}, "25 deg of play"),
        ("cuttings_bed", {"factor": 1.6, "top": 2411.0, "bottom": 2903.0}, "1.60 times as high between 2411 m and"),
    ],
)  # fmt: skip
def test_phrase_states_sign_size_and_unit(effect, values, expected):
    assert expected in str(effect_phrase(effect, values))


@pytest.mark.parametrize("effect", catalogue(3000.0, 400.0), ids=lambda effect: effect.name)
def test_phrase_needs_only_the_amplitude(effect):
    amplitude, value = next(iter(to_user(effect.values(effect.scan[0]), 3000.0).items()))
    if effect.name != "cuttings_bed":
        assert str(effect_phrase(effect.name, {amplitude.rpartition(".")[2]: value}))[0].isupper()


def test_phrase_is_written_in_the_readers_units():
    phrase = effect_phrase("axial_oscillation_tool", {"force": 4e3, "depth": 2591.0})
    assert str(phrase) == "Something shakes the string with 4.0 kN, 2591 m down"
    assert FIELD.convert_text(phrase) == "Something shakes the string with 0.90 klbf, 8501 ft down"
    crooked = effect_phrase("tortuosity", {"curvature": math.radians(1.2) / 30.0})
    assert str(crooked).endswith("by 1.2 deg/30 m") and FIELD.convert_text(crooked).endswith("by 1.2 deg/100 ft")
