"""The effects block of a rig file is as documented, and every effect has an extent."""

import dataclasses
import re
from pathlib import Path

import pytest
import yaml

from slider_drilling.diagnosis.catalogue import catalogue, to_user
from slider_drilling.effects import EFFECTS, Effects
from slider_drilling.errors import InputError
from slider_drilling.rig import dump_rig, load_rig, parse_rig
from slider_drilling.schema.fields import Range

EXAMPLE = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")


def allowed(limits: Range) -> str:
    signs = {"at_least": ">=", "above": ">", "at_most": "<=", "below": "<"}
    stated = {name: getattr(limits, name) for name in signs if getattr(limits, name) != getattr(Range(), name)}
    return ", ".join(f"{signs[name]} {value:g}" for name, value in stated.items()) or "any"


def in_the_program() -> dict[str, tuple[str, str, str]]:
    rows = {}
    for effect in dataclasses.fields(Effects):
        for parameter in dataclasses.fields(getattr(Effects(), effect.name)):
            limits = parameter.metadata["range"]
            rows[f"{effect.name}.{parameter.name}"] = limits.unit, f"{parameter.default:g}", allowed(limits)
    return rows


def test_effects_page_states_unit_default_and_range(repository):
    page = (repository / "docs" / "reference" / "effects.md").read_text()
    rows = re.findall(r"^\| `(\w+\.\w+)` \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", page, re.MULTILINE)
    stated = {name: tuple(cell.strip() for cell in cells) for name, *cells in rows}
    assert len(rows) == len(stated)
    assert stated == in_the_program()
    for effect in dataclasses.fields(Effects):
        assert re.search(rf"^\* `{effect.name}`: ", page, re.MULTILINE), effect.name


def test_effects_page_states_the_smallest_change_with_a_name(repository):
    page = (repository / "docs" / "reference" / "effects.md").read_text()
    stated = re.findall(r"^\| `(\w+\.\w+)` \| ([^|]+) \| ([^|]+) \|$", page, re.MULTILINE)
    assert stated == [
        (f"{name}.{key}", in_the_program()[f"{name}.{key}"][0], f"{size:.3g}")
        for name, effect in EFFECTS.items() for key, size in effect.sizes.material.items()
    ]  # fmt: skip


def test_effects_block_of_the_page_is_valid(repository):
    page = repository / "docs" / "reference" / "effects.md"
    (block,) = re.findall(r"```yaml\n(.*?)```", page.read_text(), re.DOTALL)
    given = yaml.safe_load(block)["effects"]
    rig = parse_rig(dump_rig(EXAMPLE) + block)
    for effect, parameters in given.items():
        for name, value in parameters.items():
            assert getattr(getattr(rig.effects, effect), name) == value


@pytest.mark.parametrize(
    ("block", "says"),
    [
        ("cuttings_bed: {factor: 1.5}", "has no extent, top = 0 and bottom = 0 m"),
        ("cuttings_bed: {factor: 1.5, top: 2000.0}", "has no extent"),
        ("cuttings_bed: {factor: 0.5, top: 2000.0, bottom: 1500.0}", "has no extent"),
        ("cuttings_bed: {factor: 1.5, top: 9000.0, bottom: 9500.0}", "below the string's end"),
        ("axial_oscillation_tool: {force: 8000.0}", "where in the string"),
        ("axial_oscillation_tool: {force: 8000.0, depth: 9000.0}", "depth = 9000.*at most 4000 m"),
    ],
)
def test_effect_without_extent_is_refused(block, says):
    with pytest.raises(InputError, match=f"own.yaml: effects.*{says}"):
        parse_rig(f"{dump_rig(EXAMPLE)}effects: {{{block}}}\n", "own.yaml")


@pytest.mark.parametrize("block", ["cuttings_bed: {factor: 1.0}", "axial_oscillation_tool: {force: 0.0}"])
def test_neutral_effect_needs_no_extent(block):
    assert parse_rig(f"{dump_rig(EXAMPLE)}effects: {{{block}}}\n").effects == Effects()


@pytest.mark.parametrize("middle", [0.0, 40.0, 1500.0, 3000.0])
@pytest.mark.parametrize("excess", [-450.0, 0.0, 216.0, 3000.0])
def test_fitted_bed_is_valid_in_a_rig_file(middle, excess):
    bed = to_user({"cuttings_bed.excess": excess, "cuttings_bed.middle": middle, "cuttings_bed.length": 90.0}, 3000.0)
    assert 0.0 <= bed["cuttings_bed.top"] < bed["cuttings_bed.bottom"] <= 3000.0
    assert bed["cuttings_bed.factor"] == pytest.approx(min(max(1.0 + excess / 90.0, 0.2), 20.0))
    assert not [name for name in bed if name.rpartition(".")[2] in ("excess", "middle", "length")]


def test_lag_below_half_a_sample_is_nonphysical():
    (lag,) = [e for e in catalogue(3000.0, 400.0, torque_interval=0.1) if e.name == "torque_sensor_lag"]
    assert not lag.is_physical({"torque_sensor_lag.lag": 0.016})
    assert lag.is_physical({"torque_sensor_lag.lag": 0.1})
    assert "time stamps" in lag.nonphysical
