"""The rig file: what is read is what is written, and a mistake is named by file, key and value."""

from __future__ import annotations

from pathlib import Path

import pytest

from slider_drilling.errors import InputError
from slider_drilling.rig import dump_rig, load_rig, parse_rig

EXAMPLE = Path(__file__).parents[1] / "config" / "rig.example.yaml"


def test_written_rig_reads_back_unchanged():
    rig = load_rig(EXAMPLE)
    assert parse_rig(dump_rig(rig)) == rig


def test_effect_survives_the_round_trip():
    text = EXAMPLE.read_text() + "effects: {stribeck: {drop: 0.3, speed: 0.05}}\n"
    rig = parse_rig(text)
    assert rig.effects.stribeck.drop == 0.3
    assert parse_rig(dump_rig(rig)) == rig


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("density: 1200.0", "densitty: 1200.0", "mud.densitty: unknown key; did you mean density?"),
        ("shear_factor: 0.1", "shear_factor: 1.0", "contact.shear_factor = 1.0: must be below 1"),
        ("youngs_modulus: 2.06e+11", "youngs_modulus: 2.06e11", "string.youngs_modulus = '2.06e11'"),
        ("inner_diameter: 0.1086", "inner_diameter: 0.2", "string.sections[0].inner_diameter = 0.2"),
        ("[4000.0, 90.0, 0.0]", "[3000.0, 90.0, 0.0]", "the string reaches 4000 m"),
        ("[4000.0, 90.0, 0.0]", "[3999.9998, 90.0, 0.0]", "ends at 3999.9998 m, the string reaches 4000 m"),
        ("rate: 10.0", "rate: .nan", "sensors.rate = nan: not a finite number"),
        ("rate: 10.0", "rate: fast", "sensors.rate = 'fast': expected a number in Hz"),
        ("{to: 4000.0, factor: 1.0}", "{to: 2000.0, factor: 1.0}", "well.friction_intervals[1].to"),
        ("hole_diameter: 0.2159", "hole_diameter: 0.15", "string.sections[1].outer_diameter = 0.165"),
        ("schema: slider_drilling/rig/1", "schema: other/2", "schema = 'other/2'"),
        ("mud: {", "mud: 3 #", "mud = 3: expected keys and values"),
    ],
)
def test_mistake_is_named_in_one_line(right, wrong, said):
    text = EXAMPLE.read_text()
    assert right in text
    with pytest.raises(InputError) as error:
        parse_rig(text.replace(right, wrong, 1), "rig.yaml")
    assert str(error.value).startswith("rig.yaml: ")
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match="no such rig file"):
        load_rig(tmp_path / "absent.yaml")


def test_asperity_without_steady_sliding_is_refused() -> None:
    from slider_drilling.rig import dump_rig

    rough = dump_rig(load_rig(EXAMPLE)).replace("shear_factor: 0.1", "shear_factor: 0.99")
    with pytest.raises(InputError, match=r"mine\.yaml: contact\.shear_factor = 0\.99: with attack angles up to "):
        parse_rig(rough, "mine.yaml")
