"""Ranges and relations of the rig file: what no rig is, is refused by name; what some rig is, is taken and runs."""

from __future__ import annotations

import copy
import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from slider_drilling.blind.wells import DEFAULT_WELLS, WELLS
from slider_drilling.control import SlideController
from slider_drilling.diagnosis.catalogue import catalogue
from slider_drilling.diagnosis.nuisance import nuisance_parameters
from slider_drilling.diagnosis.rig_values import rig_with
from slider_drilling.drillstring import VirtualRig
from slider_drilling.drillstring.recorded_channels import Response, require_finite
from slider_drilling.drillstring.sensors import quantise
from slider_drilling.effects import Effects, FrictionDrift
from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.rig import Rig, check_duration, check_rig, load_rig, parse_rig
from slider_drilling.rig.ranges_table import ranges_markdown
from slider_drilling.schema.fields import NumberField, number_fields
from slider_drilling.slide_scenarios import SCENARIOS

CONFIG = Path(__file__).parents[1] / "config"
EXAMPLE = CONFIG / "rig.example.yaml"
TREE_OF_EXAMPLE = yaml.safe_load(EXAMPLE.read_text())
NUMBERS = {row.key: row for row in number_fields(Rig)}


def with_value(key: str, value: float) -> str:
    """The example rig with one number changed; an effect's other numbers so that it acts."""
    tree = copy.deepcopy(TREE_OF_EXAMPLE)
    acting = {"cuttings_bed": {"factor": 3.0, "top": 1000.0, "bottom": 2000.0}, "stribeck": {"drop": 0.5},
              "static_aging": {"growth": 0.5}, "axial_oscillation_tool": {"force": 1e4, "depth": 2000.0},
              "heave": {"amplitude": 0.5}}  # fmt: skip
    where, name = key.replace("[]", "").rsplit("." if "] " not in key else " ", 1)
    if key.startswith("well.survey"):
        tree["well"]["survey"][2][["depth", "inclination", "azimuth"].index(name)] = value
        return yaml.safe_dump(tree)
    node: Any = tree
    for part in where.split("."):
        node = node.setdefault(part, dict(acting.get(part, {})))
        node = node[0] if isinstance(node, list) else node
    node[name] = value
    return yaml.safe_dump(tree)


def ends(row: NumberField) -> list[float]:
    """The outermost values that a range allows."""
    limits = row.range
    low = limits.at_least if math.isfinite(limits.at_least) else math.nextafter(limits.above, math.inf)
    high = limits.at_most if math.isfinite(limits.at_most) else math.nextafter(limits.below, -math.inf)
    return [low, high]


@pytest.mark.parametrize("key", NUMBERS)
def test_every_number_refuses_values_outside_its_range(key: str) -> None:
    row = NUMBERS[key]
    low, high = ends(row)
    assert math.isfinite(low) and math.isfinite(high) and row.range.why
    assert row.default is None or low <= row.default <= high
    for outside in (low - max(abs(low), 1e-9), 2.0 * high + 1.0, -1e308, 1e308, math.nan):
        with pytest.raises(InputError) as error:
            parse_rig(with_value(key, outside), "rig.yaml")
        assert "\n" not in str(error.value)
        assert key.rsplit(".", 1)[1].split("[]")[0] in str(error.value)


@pytest.mark.parametrize("key", NUMBERS)
def test_outermost_accepted_values_run(key: str) -> None:
    for value in ends(NUMBERS[key]):
        try:
            rig = parse_rig(with_value(key, value))
            plant = VirtualRig(rig, 0, 30)
            controller = SlideController(rig)
        except InputError:
            continue  # a relation refuses it: the other numbers are the example's
        measured = plant.measurements
        for _ in range(30):
            measured = plant.step(controller.step(measured))
        channels = (measured.surface_torque, measured.hook_load, measured.standpipe_pressure, plant.truth.tool_face)
        assert np.all(np.isfinite(channels)), (key, value)


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("youngs_modulus: 2.06e+11", "youngs_modulus: 206.0", "youngs_modulus = 206.0: must be at least 1e+10 Pa"),
        ("hole_diameter: 0.2159", "hole_diameter: 215.9", "well.hole_diameter = 215.9: must be at most 1.5 m"),
        ("bit: {diameter: 0.2159", "bit: {diameter: 0.311", "bit.diameter = 0.311: larger than the hole"),
        ("period: 12.0", "period: 1.0e-12", "sensors.mwd.period = 1e-12: must be at least 0.5 s"),
        ("rate: 10.0", "rate: 1.0e-12", "sensors.rate = 1e-12: must be at least 0.1 Hz"),
        ("max_torque: 45000.0", "max_torque: 45.0", "must be at least 100 N m (in N m, not kN m)"),
        ("max_speed: 12.6", "max_speed: 120.0", "must be at most 50 rad/s (in rad/s: 120 rpm is 12.6)"),
        ("rate: 10.0", "rate: 12:30", "sensors.rate = '12:30': expected a number in Hz"),
        ("rate: 10.0", "rate: 010", "sensors.rate = '010': YAML reads this as text"),
        ("rate: 10.0", "rate: " + "9" * 400, "not a finite number"),
        ("rate: 10.0", "rate: " + "9" * 5000, "YAML reads this as text"),
        ("rate: 10.0", "rate: 10.0\n  rate: 20.0", ": rate: given twice; keep one"),
        ("name: drill pipe", "name: 2024-13-45", None),
        ("name: drill pipe", "name: !!python/name:os.system x", "is not supported"),
        ("torque_per_pressure: 1.6e-3", "torque_per_pressure: 1.6e-2", "a motor without losses gives"),
        ("shear_modulus: 7.92e+10", "shear_modulus: 2.1e+11", "are they swapped?"),
        ("[2400.0, 90.0, 0.0]", "[1501.0, 90.0, 0.0]", "no pipe goes round less than"),
        ("[4000.0, 90.0, 0.0]", "[4000.0, 90.0, 180.0]", "turns by 180 deg"),
        ("inner_diameter: 0.1086", "inner_diameter: 0.12699", "leaves a wall of less than 0.001 m"),
    ],
)  # fmt: skip
def test_impossible_rig_gives_one_line(right: str, wrong: str, said: str | None) -> None:
    text = EXAMPLE.read_text()
    assert right in text
    text = text.replace(right, wrong, 1)
    if said is None:
        assert parse_rig(text).string.sections[0].name == "2024-13-45"
        return
    with pytest.raises(InputError) as error:
        parse_rig(text, "rig.yaml")
    assert said in str(error.value) and len(str(error.value)) < 400 and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("effects", "said"),
    [
        ("cuttings_bed: {factor: 2.0, top: 2000.0, bottom: 1000.0}", "has no extent, top = 2000 and bottom"),
        ("cuttings_bed: {factor: 2.0, top: 4100.0, bottom: 4200.0}", "cuttings_bed.top = 4100: below the string's end"),
        ("axial_oscillation_tool: {force: 1000.0, depth: 5000.0}", "tool.depth = 5000: give where in the string"),
        ("motor_wear: {torque_loss: -50.0}", "motor_wear.torque_loss = -50.0: must be at least -1"),
    ],
)  # fmt: skip
def test_effects_outside_the_string_are_refused(effects: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        parse_rig(EXAMPLE.read_text() + f"effects: {{{effects}}}\n")
    assert said in str(error.value)


def test_friction_drifting_to_zero_is_refused() -> None:
    rig = load_rig(EXAMPLE)
    drifting = parse_rig(EXAMPLE.read_text() + "effects: {friction_drift: {rate: -0.005}}\n")
    check_duration(rig, 1e7, "rig.yaml")
    check_duration(drifting, 199.0, "rig.yaml")
    with pytest.raises(
        InputError, match=r"rig.yaml: effects.friction_drift.rate = -0.005: leaves no friction after 200"
    ):
        check_duration(drifting, 200.0, "rig.yaml")


NO_RIGS = ["[" * 3000, "{a: " * 3000, "- " * 3000, "&a [*a]", "a: &a {b: *a}", "<<: {a: 1}", "? [1]\n: 2", "'"]
NO_RIGS += ["a: !!binary x", "a: !!int x", "\x00", "a: *b", "", "3"]


@pytest.mark.parametrize("text", NO_RIGS)
def test_other_content_gives_one_line(text: str) -> None:
    with pytest.raises(InputError) as error:
        parse_rig(text, "rig.yaml")
    assert str(error.value).startswith("rig.yaml: ") and len(str(error.value)) < 600 and "\n" not in str(error.value)


def test_content_of_other_files_is_not_echoed(tmp_path: Path) -> None:
    other = tmp_path / "log.csv"
    other.write_text("0.1,2.5,3.5\n" * 250_000)
    with pytest.raises(InputError, match="longer than 1 MB, which no rig file is") as error:
        load_rig(other)
    assert len(str(error.value)) < 300
    other.write_text("0.1,2.5,3.5\n" * 1000)
    with pytest.raises(InputError) as error:
        load_rig(other)
    assert len(str(error.value)) < 300


LEAF = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=20), st.just(10**400))
TREE = st.recursive(
    LEAF, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=9), inner, max_size=4)
)


@settings(max_examples=40)
@given(st.data())
def test_any_tree_gives_rig_or_one_line(data: st.DataObject) -> None:
    tree = copy.deepcopy(TREE_OF_EXAMPLE)
    node = tree
    for _ in range(data.draw(st.integers(0, 3))):
        key = data.draw(st.sampled_from(list(node) if isinstance(node, dict) else list(range(len(node)))))
        if not isinstance(node[key], (dict, list)) or not node[key]:
            break
        node = node[key]
    key = data.draw(st.sampled_from(list(node) if isinstance(node, dict) else list(range(len(node)))))
    node[key] = data.draw(TREE)
    try:
        parse_rig(yaml.safe_dump(tree, allow_unicode=True), "rig.yaml")
    except InputError as error:
        assert str(error).startswith("rig.yaml: ")
        assert len(str(error)) < 900


@given(st.text(max_size=200))
def test_any_text_gives_rig_or_one_line(text: str) -> None:
    with pytest.raises(InputError):
        parse_rig(text, "rig.yaml")


@pytest.mark.parametrize("path", sorted(CONFIG.glob("rig.*.yaml")), ids=lambda path: path.name)
def test_shipped_and_generated_rigs_are_valid(path: Path) -> None:
    base = load_rig(path)
    for seed in range(20):
        for well in DEFAULT_WELLS:
            check_rig(WELLS[well](np.random.default_rng(seed), base))
    for scenario in SCENARIOS:
        check_rig(scenario.assumed_rig())
        check_rig(scenario.true_rig())


def test_rigs_of_recordings_are_valid(shared_data: Path) -> None:
    for path in [*shared_data.glob("logs/labelled_*.mcap"), *shared_data.glob("field/*.mcap")]:
        check_rig(read_log(path).rig(), str(path))
    for path in shared_data.glob("field/*.rig.yaml"):
        load_rig(path)


@pytest.mark.parametrize("path", sorted(CONFIG.glob("rig.*.yaml")), ids=lambda path: path.name)
def test_fitted_rigs_can_be_read_back(path: Path) -> None:
    rig = load_rig(path)
    channels = [("surface_torque",), ("surface_torque", "hook_load", "standpipe_pressure", "tool_face")]
    for parameters in (nuisance_parameters(rig, names) for names in channels):
        for end in ("lower", "upper"):
            check_rig(rig_with(rig, {parameter.name: getattr(parameter, end) for parameter in parameters}))
    for effect in catalogue(rig.string.length, 5000.0):
        for parameter in effect.parameters:
            for end in (parameter.lower, parameter.upper):
                values = effect.values(effect.scan[0]) | {parameter.name: end}
                if parameter.name == "axial_oscillation_tool.depth":
                    values[parameter.name] = max(end, 1.0)  # at 0 m is where the file says nothing of it
                check_rig(rig_with(rig, values))


def test_too_fine_resolution_changes_nothing() -> None:
    assert quantise(1e5, 1e-320) == 1e5
    assert quantise(1e308, 1e-9) == 1e308
    assert quantise(math.inf, 1.0) == math.inf
    assert quantise(2.6, 1.0) == 3.0


# Found by test/fuzz: each number within its range, and together no string.
TOGETHER = [
    {"contact.stiffness": 8.9e8, "contact.dahl_exponent": 0.25},
    {"contact.reference_load": 1.0},
    {"well.hole_diameter": 0.652, "effects.buckling_contact.factor": 15.05, "effects.heave.amplitude": 3.0},
    {"mud.density": 3000.0, "effects.buckling_contact.factor": 20.0, "effects.heave.amplitude": 3.0},
    {"effects.stribeck.speed": 7.1, "effects.buckling_contact.factor": 4.79, "effects.heave.amplitude": 3.0},
    {"contact.reference_load": 500.0, "contact.dahl_exponent": 0.25, "string.shear_modulus": 2.0e9},
]


@pytest.mark.parametrize("changes", TOGETHER)
def test_extreme_rigs_are_refused_or_stay_finite(changes: dict[str, float]) -> None:
    try:
        plant = VirtualRig(load_rig(EXAMPLE).with_(changes), 0, 20)
        controller = SlideController(plant.rig)
        for _ in range(30):
            plant.step(controller.step(plant.measurements))
    except InputError as error:
        assert "\n" not in str(error)
        return
    assert np.isfinite(plant.truth.surface_torque) and np.isfinite(plant.truth.tool_face)


def test_non_finite_run_is_reported() -> None:
    columns = [np.linspace(0.0, 1.0, 11) for _ in fields(Response)]
    require_finite(Response(*columns))
    columns[3] = np.where(columns[0] > 0.45, np.nan, columns[3])
    with pytest.raises(InputError, match=r"no finite numbers from 0\.5 s on: the rig file's numbers"):
        require_finite(Response(*columns))


def test_documentation_table_holds_every_number() -> None:
    table = ranges_markdown()
    assert table.count("\n") == len(NUMBERS) + 2
    assert "| `string.youngs_modulus` | Pa | at least 1e+10, at most 5e+11 |" in table


def test_check_rig_checks_rigs_made_in_code() -> None:
    rig = load_rig(EXAMPLE)
    wrong = replace(rig, mud=replace(rig.mud, density=-5.0))
    with pytest.raises(InputError, match=r"rig: mud.density = -5.0: must be at least 1 kg/m3"):
        check_rig(wrong)
    with pytest.raises(InputError, match=r"friction_drift.rate = 1\.0: must be at most"):
        check_rig(replace(rig, effects=Effects(friction_drift=FrictionDrift(1.0))))
