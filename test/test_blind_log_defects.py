"""Incomplete sealed logs: the run is the same, the log holds what its recorder kept."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from slider_drilling.blind.cases import CasePlan, draw_cases
from slider_drilling.blind.label import Label
from slider_drilling.blind.log_defects import LOG_DEFECTS, NO_DEFECT, LogDefect
from slider_drilling.blind.manoeuvres import MANOEUVRES
from slider_drilling.blind.page import total_rows
from slider_drilling.blind.plant_law import no_effect
from slider_drilling.blind.recorder import RecorderModel, write_sealed_log
from slider_drilling.blind.reported_diagnosis import ReportedDiagnosis
from slider_drilling.blind.score import score
from slider_drilling.blind.sealed_plant import PlantPerturbation, simulate_sealed
from slider_drilling.blind.totals import count_totals
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import read_log
from slider_drilling.rig import load_rig


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Records one run with a defect."""
    rig = load_rig(installed_file("config/rig.short.yaml"))
    commands = MANOEUVRES["varied"](np.random.default_rng(1), rig, 60.0)
    response = simulate_sealed(
        rig, PlantPerturbation(elements=30), no_effect(np.random.default_rng(1), rig, 1.0), commands
    )
    folder = tmp_path_factory.mktemp("logs")

    def record(defect):
        path = folder / "log.mcap"
        write_sealed_log(path, rig, commands, response, np.random.default_rng(2), RecorderModel(defect=defect))
        return read_log(path)

    return record


def test_late_start_sets_clock_to_zero(recorded):
    whole, late = recorded(LogDefect()), recorded(LogDefect(start_share=0.25))
    assert late.top_drive.time[0] == 0.0
    kept = whole.top_drive.time >= 15.0 - 1e-6
    assert np.allclose(late.top_drive.time, whole.top_drive.time[kept] - 15.0)
    for name in ("position", "velocity", "effort"):
        assert np.array_equal(getattr(late.top_drive, name), getattr(whole.top_drive, name)[kept])
    assert np.array_equal(late.standpipe_pressure.value, whole.standpipe_pressure.value[kept])
    assert np.allclose(late.mwd_tool_face.time, whole.mwd_tool_face.time[whole.mwd_tool_face.time >= 15.0] - 15.0)


@pytest.mark.parametrize("series", ["draw_works", "mud_pump"])
def test_missing_series_leaves_the_others_unchanged(recorded, series):
    whole, lacking = recorded(LogDefect()), recorded(LogDefect(missing_series=(series,)))
    assert getattr(lacking, series) is None
    for name in {"top_drive", "draw_works", "mud_pump"} - {series}:
        assert np.array_equal(getattr(lacking, name).velocity, getattr(whole, name).velocity)


def test_one_of_ten_samples_is_kept(recorded):
    whole, seldom = recorded(LogDefect()), recorded(LogDefect(keep_every=10))
    assert np.array_equal(seldom.top_drive.effort, whole.top_drive.effort[::10])
    assert np.array_equal(seldom.top_drive.time, whole.top_drive.time[::10])


def test_held_samples_repeat_until_the_next_new_one(recorded):
    whole, held = recorded(LogDefect()), recorded(LogDefect(hold_samples=5))
    assert np.array_equal(held.top_drive.time, whole.top_drive.time)
    assert np.array_equal(held.draw_works.effort, np.repeat(whole.draw_works.effort[::5], 5))
    assert np.array_equal(held.top_drive.position, np.repeat(whole.top_drive.position[::5], 5))


def test_coarse_encoder_rounds_angle_and_speed(recorded):
    whole, coarse = recorded(LogDefect()), recorded(LogDefect(angle_resolution=math.radians(1.0), speed_resolution=0.1))
    for name, step in (("position", math.radians(1.0)), ("velocity", 0.1)):
        value, exact = getattr(coarse.top_drive, name), getattr(whole.top_drive, name)
        assert np.allclose(value / step, np.round(value / step))
        assert 0.0 < np.max(np.abs(value - exact)) <= 0.5 * step + 1e-12
    assert np.array_equal(coarse.top_drive.effort, whole.top_drive.effort)


@pytest.mark.parametrize("name", LOG_DEFECTS)
def test_each_defect_differs_from_none(name):
    defects = [LOG_DEFECTS[name](np.random.default_rng(seed)) for seed in range(20)]
    assert all(defect == LogDefect() for defect in defects) == (name == NO_DEFECT)
    for defect in defects:
        logged, shown = defect.sample_rows(1200)
        assert logged.size == shown.size >= 60 and np.all(shown <= logged) and logged[0] == shown[0]


def test_each_kind_takes_defects_in_turn():
    defects = ("late_start", "no_pump", "few_samples")
    cases = draw_cases(CasePlan(effects=("none", "heave"), log_defects=defects), 24)
    for kind in ("none", "single"):
        count = Counter(case.log_defect for case in cases if case.kind == kind)
        assert set(count) == set(defects) and max(count.values()) - min(count.values()) <= 1
    assert {case.log_defect for case in draw_cases(CasePlan(), 10)} == {NO_DEFECT}
    with pytest.raises(InputError, match="--log-defects hook: unknown; use none, late_start, no_drawworks"):
        CasePlan(log_defects=("hook",))


def test_totals_count_by_log_defect():
    def case(kind, defect, verdict, *named):
        effects = ("heave",) if kind == "single" else ()
        label = Label("log.mcap", kind, effects, (), 4.0, (4.0,), "own", "varied", 1, None, {}, {}, defect)
        nan = math.nan
        return score(
            label, ReportedDiagnosis(verdict, named, dict.fromkeys(named, ()), (), None, nan, nan, (nan, nan), {})
        )

    found = count_totals([case("single", "no_pump", "effect", "heave"), case("single", "no_pump", "parameters"),
                   case("none", "no_pump", "unknown"), case("none", NO_DEFECT, "parameters")])  # fmt: skip
    assert (found.by_log_defect["no_pump"].count, found.by_log_defect["no_pump"].total) == (1, 2)
    assert [found.false_alarms_by_log_defect[name].count for name in (NO_DEFECT, "no_pump")] == [0, 1]
    rows = dict(total_rows(found))
    assert rows["named, log defect no_pump"].startswith("1 of 2")
    assert rows["false alarms, log defect no_pump"].startswith("1 of 1")
    without = count_totals([case("none", NO_DEFECT, "parameters")])
    assert not any("log defect" in name for name, _ in total_rows(without))


@pytest.mark.parametrize(("option", "field"), [("manoeuvres", "manoeuvres"), ("log-defects", "log_defects")])
def test_empty_list_of_names_is_refused(option, field):
    with pytest.raises(InputError, match=f"--{option}: give at least one of "):
        CasePlan(**{field: ()})
