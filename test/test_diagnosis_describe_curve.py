"""A residual's shape in words and as a picture."""

from __future__ import annotations

import numpy as np
import pytest

from slider_drilling.diagnosis.describe_curve import axis_labels, describe_curve
from slider_drilling.diagnosis.figures import shape
from slider_drilling.diagnosis.result import ResidualShape


@pytest.mark.parametrize(
    ("x_unit", "y_unit", "curve", "expected"),
    [
        ("s", "Pa", lambda x: -2e5 * x / 60.0, "falls by 2.0 bar per minute"),
        ("Pa", "Pa", lambda x: 0.03 * x + 1.0, "rises by 3.0 % of its value"),
        ("rad", "N m", lambda x: -1e4 * x, "falls by 0.17 kN m per deg"),
        ("m", "-", lambda x: np.where(x > 205.0, 0.4, 0.0), "steps up by 40 % between 171 m and 229 m"),
        ("m", "-", lambda x: np.exp(-(((x - 229.0) / 60.0) ** 2)), "largest, 100 %, at 229 m"),
        ("s", "N", lambda x: 0.0 * x + 4e3, "by 4.0 kN"),
    ],
)
def test_curve_is_described_with_numbers_and_units(x_unit, y_unit, curve, expected):
    x = np.linspace(0.0, 400.0, 8)
    text = str(describe_curve("reading off", x, x_unit, curve(x), y_unit))
    assert text.startswith("reading off")
    assert expected in text


@pytest.mark.parametrize(("y", "expected"), [(0.24, "by 24 %"), (-0.5, "by -50 %"), (9.0, "by a factor of 10")])
def test_shape_of_one_number_is_a_sentence(y, expected):
    disturbance = "contact that gives way"
    residual = ResidualShape("unknown", disturbance, np.zeros(1), np.array([y]), "-", "-")
    assert str(shape(residual)) == f"What the unknown looks like: {disturbance}, {expected}."


def test_drift_known_by_its_ends_is_described_by_its_rate():
    disturbance = "pressure off by an amount that drifts with time"
    text = describe_curve(disturbance, np.array([0.0, 120.0]), "s", np.array([1e4, -3.9e5]), "Pa")
    assert str(text) == f"{disturbance}: falls by 2.0 bar per minute"


def test_picture_has_the_units_of_its_description():
    time, lost = np.array([0.0, 60.0, 120.0]), np.array([0.0, 2e5, 4e5])
    drawn = shape(ResidualShape("rest", "pressure off by an amount that follows time", time, lost, "s", "Pa"))
    assert str(drawn.caption).endswith("rises by 2.0 bar per minute")
    (panel,) = drawn.panels
    assert (drawn.x_label, panel.y_label) == ("time, s", "pressure off, bar")
    np.testing.assert_allclose(panel.marks[0].y, [0.0, 2.0, 4.0])


@pytest.mark.parametrize(
    ("disturbance", "unit", "label"),
    [
        ("friction over depth", "-", "change of friction, share"), ("flow off over time", "-", "flow off, share"),
        ("block off over time", "m", "block off, m"),
        ("standpipe pressure off by an amount that drifts with time", "Pa", "standpipe pressure off, Pa"),
    ],
)  # fmt: skip
def test_axis_label_names_a_share_as_one(disturbance, unit, label):
    assert axis_labels(disturbance, "s", unit)[1] == label
