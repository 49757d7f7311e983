"""The registry of effects: every follower covers every effect."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slider_drilling.blind.cases import CasePlan, draw_cases
from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS, registry_law
from slider_drilling.blind.manoeuvres import MANOEUVRES
from slider_drilling.blind.plant_law import OperatingPoint
from slider_drilling.commands.options import complete_effect
from slider_drilling.diagnosis.catalogue import catalogue, to_user
from slider_drilling.diagnosis.effect_phrases import SITES
from slider_drilling.drillstring import Commands, Response, simulate
from slider_drilling.effects import EFFECTS, SEARCH_ORDER, AngleFriction, Effects, SearchInputs, effects_with
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import Rig, check_rig, dump_rig, load_rig, parse_rig
from slider_drilling.slide_scenarios.every_effect import every_effect

LENGTH, DURATION = 3000.0, 400.0
NAMES = tuple(field.name for field in dataclasses.fields(Effects))


@pytest.fixture(scope="module")
def base() -> Rig:
    return load_rig(installed_file("config/rig.example.yaml"))


def test_registry_holds_every_section_of_the_rig_file() -> None:
    assert tuple(EFFECTS) == NAMES
    assert {definition.name for definition in SEARCH_ORDER} == set(NAMES) and len(SEARCH_ORDER) == len(NAMES)
    for name, definition in EFFECTS.items():
        assert definition.name == name
        assert getattr(Effects(), name) == definition.section()
        assert definition.site in SITES


@pytest.mark.parametrize("name", NAMES)
def test_sizes_are_valid_in_a_rig_file(base: Rig, name: str) -> None:
    for size in ("usual", "small", "large"):
        values = EFFECTS[name].sizes.values(size, base.string.length)
        changed = check_rig(dataclasses.replace(base, effects=effects_with(**{name: values})))
        assert getattr(parse_rig(dump_rig(changed)).effects, name) == getattr(changed.effects, name)
        assert changed.effects != Effects()


@pytest.fixture(scope="module")
def run(base: Rig) -> tuple[Commands, Response]:
    commands = MANOEUVRES["varied"](np.random.default_rng(1), base, 200.0)
    return commands, simulate(base, commands, 20)


@pytest.mark.parametrize("name", NAMES)
def test_usual_size_changes_what_sensors_read(base: Rig, run: tuple[Commands, Response], name: str) -> None:
    commands, neutral = run
    values = EFFECTS[name].sizes.values("usual", base.string.length)
    changed = simulate(base.with_({f"effects.{name}": values}), commands, 20)
    channels = ("surface_torque", "hook_load", "standpipe_pressure", "tool_face")
    assert any(not np.array_equal(getattr(neutral, channel), getattr(changed, channel)) for channel in channels)


@pytest.mark.parametrize("name", NAMES)
def test_random_draws_are_valid_in_a_rig_file(base: Rig, name: str) -> None:
    for seed in range(10):
        values = EFFECTS[name].draw(np.random.default_rng(seed), base.string.length, 900.0)
        drawn = effects_with(**{name: values})
        assert check_rig(dataclasses.replace(base, effects=drawn)).effects == drawn


@pytest.mark.parametrize("name", NAMES)
def test_search_ends_in_keys_of_the_rig_file(name: str) -> None:
    definition = EFFECTS[name]
    search = definition.search(SearchInputs(LENGTH, DURATION, (7.0, 9.0), (), 0.1))
    assert len(search.scan) >= 3
    keys = {field.name for field in dataclasses.fields(definition.section)}
    for point in search.scan:
        fitted = {f"{name}.{parameter.key}": value for parameter, value in zip(search.parameters, point, strict=True)}
        assert {key.removeprefix(f"{name}.") for key in to_user(fitted, LENGTH)} <= keys


def test_catalogue_and_sealed_logs_follow_the_registry() -> None:
    assert [effect.name for effect in catalogue(LENGTH, DURATION)] == [d.name for d in SEARCH_ORDER]
    assert tuple(CATALOGUE_LAWS) == NAMES
    single = {case.effects[0] for case in draw_cases(CasePlan(), 400) if case.kind == "single"}
    assert single == set(NAMES)


def test_scenarios_and_completion_follow_the_registry() -> None:
    scenarios = [scenario.name for scenario in every_effect()]
    for definition in EFFECTS.values():
        for size in ("small", "large"):
            assert sum(name.startswith(f"{definition.title}, {size}, ") for name in scenarios) == 3
    assert complete_effect(None, None, "") == list(NAMES)  # type: ignore[arg-type]


def test_effect_without_another_form_is_sealed_by_its_own_law(base: Rig) -> None:
    bed = registry_law(EFFECTS["cuttings_bed"])
    start = OperatingPoint(0.0, 0.0, 1.0, DURATION)
    usual, double, neutral = (bed(np.random.default_rng(1), base, size).values(start) for size in (1.0, 2.0, 0.0))
    assert usual["cuttings_bed.factor"] == pytest.approx(1.9) and double["cuttings_bed.factor"] == pytest.approx(2.8)
    assert neutral["cuttings_bed.factor"] == 1.0
    assert usual["cuttings_bed.top"] == double["cuttings_bed.top"] == 0.65 * base.string.length


def test_angle_friction_is_average_over_a_turn() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    for friction in (AngleFriction(0.6, 0.3), AngleFriction(0.6, 0.3, np.sin)):
        factor = friction(turn)
        assert np.mean(factor) == pytest.approx(1.0)
        assert np.ptp(factor) == pytest.approx(1.2, rel=1e-2)
    assert AngleFriction(0.6)(0.0) == 1.6 and AngleFriction(0.6, 0.0, np.sin)(0.5 * np.pi) == 1.6
