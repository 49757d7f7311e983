"""Numbers in SI's and in the field's units: exact factors, one table."""

import math

import numpy as np
import pytest

from slider_drilling.units import (
    FIELD,
    FIELD_UNITS,
    KINDS,
    SI,
    Quantity,
    format_number,
    quantities_in,
    sentence,
    split_label,
)


@pytest.mark.parametrize(
    ("value", "unit", "converted", "in_unit"),
    [
        (0.3048, "m", 1.0, "ft"),
        (4.4482216152605, "kN", 1.0, "klbf"),
        (1.3558179483314004, "N m", 1.0, "ft lbf"),
        (1.3558179483314004, "kN m", 1000.0, "ft lbf"),
        (1.0, "bar", 14.503773773020923, "psi"),
        (2 * math.pi, "rad", 1.0, "turns"),
        (90.0, "deg", 90.0, "deg"),
        (3.785411784, "L/min", 1.0, "gal/min"),
        (119.82642731689663, "kg/m3", 1.0, "lb/gal"),
        (30.48, "m/h", 100.0, "ft/h"),
        (12.0, "s", 12.0, "s"),
    ],
)
def test_field_units(value: float, unit: str, converted: float, in_unit: str) -> None:
    assert FIELD.display_unit(unit) == in_unit
    assert FIELD.convert(value, unit) == pytest.approx(converted, rel=1e-14)
    assert SI.display_unit(unit) == unit and SI.convert(value, unit) == value


def test_field_units_keep_their_kind() -> None:
    for unit, shown in FIELD_UNITS.items():
        assert [kind for kind, known in KINDS.items() if unit in known and shown in known], (unit, shown)


def test_arrays_and_labels() -> None:
    np.testing.assert_allclose(FIELD.convert(np.array([0.3048, 3.048]), "m"), [1.0, 10.0])
    assert FIELD.convert_label("surface torque, kN m") == "surface torque, ft lbf"
    assert FIELD.convert_label("E, noise floors") == SI.convert_label("E, noise floors") == "E, noise floors"
    assert split_label("hook load, kN") == ("hook load", "kN") and split_label("friction") == ("friction", "")


def test_text() -> None:
    assert SI.format(12.345, "kN m") == "12.3 kN m" and FIELD.format(12.345, "kN m") == "9105 ft lbf"
    assert SI.format(None, "m") == SI.format(math.nan, "m") == "-"
    assert SI.format_range(-4.1, 12.345, "kN") == "-4.10 to 12.3 kN"
    assert SI.format(0.5, "") == "0.500"


@pytest.mark.parametrize(
    ("value", "read"),
    [(3.33e-16, "0"), (0.0, "0"), (9.996, "10.0"), (12345.6, "12346"), (-0.01234, "-0.0123"), (1.234e-5, "1.23e-5"),
     (2.5e9, "2.50e9"), (math.nan, "-")],
)  # fmt: skip
def test_format_number(value: float, read: str) -> None:
    assert format_number(value) == read


def test_text_with_quantities_is_written_in_either_units() -> None:
    bed = sentence("2.04 times between ", Quantity(2663.0, "m"), " and ", Quantity(3213.0, "m"), "; 92 %")
    assert str(bed) == "2.04 times between 2663 m and 3213 m; 92 %"
    assert FIELD.convert_text(bed) == "2.04 times between 8737 ft and 10541 ft; 92 %"
    assert FIELD.convert_text(sentence("by ", sentence(Quantity(5.1, "m/s", 2)))) == "by 17 ft/s"
    assert FIELD.convert_text(sentence("from ", Quantity(None, "m"))) == "from -"


def test_plain_text_is_not_converted() -> None:
    assert FIELD.convert_text("well-4 m1 has 3 mud pumps at 2663 m") == "well-4 m1 has 3 mud pumps at 2663 m"


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("rocking reaches 2400 m of 3100 m", "rocking reaches 7874 ft of 10171 ft"),
        ("torque +3.1 kN m, limit 10 / 6 bar", "torque +2286 ft lbf, limit 145 psi / 87 psi"),
        ("MWD 12 s, friction factor 1.2, NC50 of 6.625 in", "MWD 12 s, friction factor 1.2, NC50 of 6.625 in"),
        ("rock: 20 to 200 MN/m; 3 mm", "rock: 20 to 200 MN/m; 0.1 in"),
    ],
)
def test_quantities_in_plain_text_are_converted(text: str, field: str) -> None:
    assert FIELD.convert_text(quantities_in(text)) == field


def test_plain_text_stays_in_si() -> None:
    text = "weight 80 kN at 2400.5 m, -0.05 bar below +12 rad/s"
    assert str(quantities_in(text)) == text
