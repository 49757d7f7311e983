"""Units beside numbers in rig files and on the command line; assumed numbers with their spread."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from slider_drilling.api.rigs import load_rig
from slider_drilling.api.with_effect import with_effect
from slider_drilling.commands.overrides import apply_changes, parse_settings
from slider_drilling.errors import InputError
from slider_drilling.rig import Assumption, dump_rig, parse_rig
from slider_drilling.schema.quantity_text import read_quantity

EXAMPLE = (Path(__file__).parents[1] / "config" / "rig.example.yaml").read_text()


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("9.6 ppg", "kg/m3", 9.6 * 0.45359237 / 3.785411784e-3),
        ("0.28 rev/gal", "m3/rev", 3.785411784e-3 / 0.28),
        ("8.5in", "m", 0.2159),
        ("4.2 gal/stk", "m3/rad", 4.2 * 3.785411784e-3 / (2.0 * math.pi)),
        ("45000 ft-lbf", "N m", 61011.8),
        ("180 rpm", "rad/s", 6.0 * math.pi),
        ("20 %", "-", 0.2),
        ("206 GPa", "Pa", 2.06e11),
        ("1.5e3 PSI", "Pa", 1500.0 * 6894.757),
        ("21.9 lb/ft", "N/m", 319.60647),
    ],
)
def test_units_beside_numbers(text: str, unit: str, value: float) -> None:
    assert read_quantity(text, unit, "x") == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize("text", ["9.6", "ppg", "1,500 psi", "1 2 psi", "9.6 psi", "9.6 nonsense", "", "nan kg/m3"])
def test_other_texts_are_no_density(text: str) -> None:
    with pytest.raises(InputError, match="x"):
        read_quantity(text, "kg/m3", "x")


def test_rig_file_takes_units() -> None:
    text = EXAMPLE.replace("density: 1200.0, s", "density: 9.6 ppg, s").replace("0.0169", "0.28 rev/gal")
    rig = parse_rig(text.replace("bit: {diameter: 0.2159", "bit: {diameter: 8.5 in"))
    assert rig.mud.density == pytest.approx(1150.33, abs=0.01)
    assert rig.motor.displacement == pytest.approx(0.0135193, rel=1e-5)
    assert rig.bit.diameter == pytest.approx(0.2159, abs=1e-9)


@pytest.mark.parametrize(
    ("density", "question"),
    [("9.6", "is this 9.6 lb/gal, which is 1150 kg/m3"), ("1.15", "is this 1.15 g/cm3"), ("72", "is this 72 lb/ft3")],
)
def test_density_in_another_unit_is_asked(density: str, question: str) -> None:
    with pytest.raises(InputError) as error:
        parse_rig(EXAMPLE.replace("density: 1200.0, s", f"density: {density}, s"), "rig.yaml")
    assert question in str(error.value) and str(error.value).startswith("rig.yaml: mud.density = ")
    rig = parse_rig(EXAMPLE.replace("density: 1200.0, s", f"density: '{density} kg/m3', s"))
    assert rig.mud.density == float(density)
    assert parse_rig(dump_rig(rig)) == rig


def test_set_takes_units(tmp_path: Path) -> None:
    rig = load_rig(apply_changes(None, ["mud.density=9.6 ppg"], (), None, tmp_path).rig)
    assert rig.mud.density == pytest.approx(1150.33, abs=0.01)
    with pytest.raises(InputError, match=r"mud\.density = 9\.6: is this 9\.6 lb/gal"):
        apply_changes(None, ["mud.density=9.6"], (), None, tmp_path)
    assert with_effect(rig, "heave:period=0.2 min").effects.heave.period == pytest.approx(12.0)


def test_controller_settings_take_units() -> None:
    settings = parse_settings(["differential_pressure=300 psi"], None, load_rig())
    assert settings == {"differential_pressure": pytest.approx(300.0 * 6894.757, rel=1e-6)}


def test_assumed_number_keeps_spread_and_reason() -> None:
    assumed = "axial_damping: {value: 0.15, spread: 60 %, assumed: true, why: mud}"
    rig = parse_rig(EXAMPLE.replace("axial_damping: 0.15", assumed))
    assert rig.assumed == (Assumption("string.axial_damping", pytest.approx(0.09), "mud"),)
    assert rig.string.axial_damping == 0.15
    assert parse_rig(dump_rig(rig)) == rig
    assert "assumed: true" in dump_rig(rig)


def test_changed_number_is_assumed_no_longer() -> None:
    rig = parse_rig(EXAMPLE.replace("factor: 1.0}", "factor: {value: 1.0, spread: 0.2, assumed: true}}"))
    assert rig.assumed[0].key == "well.friction_intervals[1].factor"
    assert rig.with_({"mud.density": 1100.0}).assumed == rig.assumed
    assert rig.with_({"well.friction_intervals[1].factor": 0.8}).assumed == ()


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("{value: 0.15}", "axial_damping.spread = None: expected a number in 1/s"),
        ("{value: 0.15, spread: -1}", "spread = -1: must be above 0"),
        ("{value: 0.15, spread: 0.1, because: x}", "axial_damping.because: unknown key"),
        ("{value: x, spread: 0.1}", "axial_damping = 'x': expected a number"),
        ("{value: 0.15, spread: 3 psi}", "is a unit of pressure, not of frequency; use Hz"),
        ("{value: 0.15, spread: 0.1, assumed: maybe}", "assumed = 'maybe': expected true or false"),
    ],
)
def test_wrong_assumptions_are_named(entry: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        parse_rig(EXAMPLE.replace("axial_damping: 0.15", f"axial_damping: {entry}"), "rig.yaml")
    assert said in str(error.value) and "\n" not in str(error.value)
