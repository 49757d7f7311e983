"""Closed-loop campaigns: random rigs, statistics, paired comparison."""

from __future__ import annotations

import dataclasses
import json
import math
import shlex
from collections import Counter
from functools import partial

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.blind.foreign.foreign_rig import ForeignRig
from slider_drilling.campaign.results import JobResult, ResultFolder
from slider_drilling.cli import group
from slider_drilling.control.controller_loader import DEFAULT_CONTROLLER
from slider_drilling.control.interface import RigCommand
from slider_drilling.effects import Effects
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.pages import page_html
from slider_drilling.rig import load_rig
from slider_drilling.slide_scenarios.campaign import (
    CampaignOptions,
    ScoredSlide,
    compare_paired,
    noise_seed,
    repeat_command,
    run_slide,
    slide_job,
    slide_of,
    summarise,
    worst,
)
from slider_drilling.slide_scenarios.campaign_page import as_json, campaign_page, comparison_sentences
from slider_drilling.slide_scenarios.drawn import draw_slide
from slider_drilling.slide_scenarios.faulty_rig import FaultyRig
from slider_drilling.slide_scenarios.score import SlideScore
from slider_drilling.units import SI
from slider_drilling.user_code import source_files

RIG = installed_file("config/rig.example.yaml")


@pytest.fixture
def brief(monkeypatch):
    """Slides of a third of the default duration."""
    made = partial(CampaignOptions, duration=300.0)
    monkeypatch.setattr("slider_drilling.slide_scenarios.campaign.CampaignOptions", made)
    return made


@pytest.fixture(scope="module")
def drawn():
    base = load_rig(RIG)
    return [draw_slide(number, 1, base) for number in range(60)]


def slide(number, error, after=100.0, within=1.0, drilled=2.0):
    score = SlideScore(error, 2 * error, within, after, 8e3, 8e3, 5e3, 1e3, 9.0, drilled)
    return ScoredSlide(number, "3 km", "", score)


def test_slide_depends_only_on_number_and_seed(drawn):
    base = load_rig(RIG)
    assert draw_slide(7, 1, base) == drawn[7]
    assert draw_slide(7, 2, base) != drawn[7] != drawn[8]
    assert noise_seed(1, 7) != noise_seed(1, 8)


def test_random_rigs_vary_every_uncertain_parameter(drawn):
    assumed, true = zip(*(scenario.rigs for scenario in drawn), strict=True)
    for what in (
        lambda rig: rig.well.friction_intervals[0].factor, lambda rig: rig.well.friction_intervals[1].factor,
        lambda rig: rig.well.survey[-1][1], lambda rig: rig.string.torsional_damping,
        lambda rig: rig.string.shear_modulus, lambda rig: rig.motor.torque_per_pressure,
        lambda rig: rig.bit.aggressiveness, lambda rig: rig.hydraulics.reference_pressure,
    ):  # fmt: skip
        off = np.log([what(real) / what(file) for file, real in zip(assumed, true, strict=True)])
        assert 1e-3 < np.std(off) < 0.6
        assert abs(np.mean(off)) < 3.5 * np.std(off) / np.sqrt(len(off))  # to neither side
    split = [real.well.friction_intervals[0].factor / real.well.friction_intervals[1].factor for real in true]
    assert np.std(np.log(split)) > 0.05  # cased and open hole are off differently
    # Known and different: noise, the MWD's period, the well itself.
    assert {rig.sensors.mwd.period for rig in assumed} == {8.0, 12.0, 20.0, 30.0}
    assert len({rig.sensors.hook_load.noise for rig in assumed}) == 60
    assert all(file.sensors == real.sensors for file, real in zip(assumed, true, strict=True))
    assert len({rig.string.length for rig in assumed}) == 60
    assert {scenario.mwd_outliers for scenario in drawn} == {0.0, 0.02, 0.05}


@pytest.mark.slow
def test_some_slides_have_unknown_effects(drawn):
    counts = Counter(0 if scenario.about == "no effect" else len(scenario.about.split(", ")) for scenario in drawn)
    assert set(counts) == {0, 1, 2}
    for scenario in drawn:
        assumed, true = scenario.rigs
        assert assumed.effects == Effects()
        changed = {name for name in vars(Effects()) if getattr(true.effects, name) != getattr(Effects(), name)}
        assert changed == (set() if scenario.about == "no effect" else set(scenario.about.split(", ")))
    base = load_rig(RIG)
    names = {name for k in range(150) for name in draw_slide(k, 3, base).about.split(", ")}
    assert len(names - {"no effect"}) >= 15


def test_slide_without_hole_ranks_worst():
    idle = slide(3, math.nan, after=10.0, drilled=0.0)
    slides = [slide(1, 5.0), slide(2, 9.0, after=None), idle, *(slide(k, 1.0) for k in range(10, 20))]
    assert [ranked.number for ranked in worst(slides)][:3] == [3, 2, 1]
    assert len(worst(slides)) == 10
    summary = summarise(slides)
    assert (summary.slides, summary.nothing_drilled, summary.set_in_time, summary.held) == (13, 1, 11, 12)
    assert summary.error[0] == 1.0 and summary.error[-1] == math.inf and summary.time_to_set[-1] == math.inf


def test_comparison_uses_slides_that_both_drilled():
    first = [slide(k, 2.0 + 0.1 * k) for k in range(20)]
    second = [slide(k, 5.0 + 0.1 * k) for k in range(19)] + [slide(19, math.nan, drilled=0.0)]
    pair = compare_paired(first, second)
    assert (pair.better, pair.slides) == (19, 19)
    assert pair.probability == (pytest.approx(0.025 ** (1 / 19)), 1.0)
    assert pair.difference == pytest.approx(-3.0) and pair.interval == pytest.approx((-3.0, -3.0))
    assert compare_paired(first, []) is None
    even = compare_paired(first, first)
    assert even.better == 0 and even.difference == 0.0
    assert "by 3.0 deg on average [3.0, 3.0]" in comparison_sentences({"a": first, "b": second})[0]


def test_worst_slides_come_with_repeat_command():
    setting = CampaignOptions(RIG, seed=4, elements=60)
    slides = {DEFAULT_CONTROLLER: [slide(k, 2.0 + k) for k in range(12)],
              "fixed_rocking": [slide(k, math.inf) for k in range(12)]}
    repeat = {name: lambda number, name=name: repeat_command(number, name, setting, False) for name in slides}
    tree = as_json(slides, setting, "code", repeat)
    own = tree["controllers"][DEFAULT_CONTROLLER]
    assert [row["number"] for row in own["worst"]] == list(range(11, 1, -1))
    command = own["worst"][0]["command"]
    assert shlex.split(command)[1:] == ["closed-loop", "--slide", "11", "--seed", "4", "--elements", "60", "-o",
                                        "slide_11"]  # fmt: skip
    json.dumps(tree, allow_nan=False)
    assert command in page_html(campaign_page(slides, setting, "code", repeat), SI)


def test_job_key_depends_on_controller_file(tmp_path, monkeypatch):
    path = tmp_path / "holds_still_in_a_campaign.py"
    path.write_text("class Still:\n    def __init__(self, rig): pass\n    def step(self, measurements): ...\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    setting = CampaignOptions(RIG)
    name = "holds_still_in_a_campaign:Still"
    key = slide_job(0, name, setting).key()
    path.write_text(path.read_text() + "# edited\n")
    assert slide_job(0, name, setting).key() != key
    with pytest.raises(InputError, match="no_such_module"):
        slide_job(0, "no_such_module:Still", setting)


STILL = "class Still:\n    def __init__(self, rig): pass\n    def step(self, measurements): ...\n"


@pytest.mark.parametrize(("module", "edited"), [
    ("still_in_a_file", "imported_late.py"),
    ("still_in_a_namespace.still", "still_in_a_namespace/still.py"),
    ("still_in_a_namespace.still", "still_in_a_namespace/laws/late.py"),
    ("still_in_a_package.still", "still_in_a_package/laws/late.py"),
])  # fmt: skip
def test_job_key_depends_on_every_file_that_controller_may_import(tmp_path, monkeypatch, module, edited):
    monkeypatch.syspath_prepend(str(tmp_path))
    for path in (tmp_path / f"{module.replace('.', '/')}.py", tmp_path / edited):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(STILL)
    if "package" in module:
        (tmp_path / edited).parents[1].joinpath("__init__.py").touch()
    key = slide_job(0, f"{module}:Still", CampaignOptions(RIG)).key()
    assert slide_job(0, f"{module}:Still", CampaignOptions(RIG)).key() == key
    (tmp_path / edited).write_text(STILL + "# edited\n")
    assert slide_job(0, f"{module}:Still", CampaignOptions(RIG)).key() != key


def test_installed_module_does_not_depend_on_its_neighbours(tmp_path, monkeypatch):
    folder = tmp_path / "site-packages"
    folder.mkdir()
    for name in ("still_installed", "of_others"):
        (folder / f"{name}.py").write_text(STILL)
    monkeypatch.syspath_prepend(str(folder))
    slide_job(0, "still_installed:Still", CampaignOptions(RIG))
    assert source_files("still_installed") == [(folder / "still_installed.py").resolve()]


def test_foreign_slide_runs_on_a_foreign_rig():
    scenario = draw_slide(3, 5, load_rig(RIG), 60.0, foreign=True)
    assert draw_slide(3, 5, load_rig(RIG), 60.0).rigs == scenario.rigs
    structure = dataclasses.replace(scenario.structure, hook_load_offset=30e3)
    rig = FaultyRig(dataclasses.replace(scenario, structure=structure), 0, 20)
    assert isinstance(rig.rig, ForeignRig)
    measured = rig.step(RigCommand(0.0, 0.0, 0.0, rig.rig.measurements.pump_speed))
    assert measured.hook_load - rig.rig.truth.hook_load > 15e3


def test_foreign_slide_is_another_job_with_its_own_command():
    jobs = [slide_job(0, DEFAULT_CONTROLLER, CampaignOptions(RIG, foreign=foreign)) for foreign in (False, True)]
    assert jobs[0].key() != jobs[1].key()
    command = repeat_command(0, DEFAULT_CONTROLLER, CampaignOptions(RIG, foreign=True, duration=1200.0), False)
    assert "--duration 1200 --foreign" in command


def test_stopped_slides_are_counted():
    slides = [slide(k, 2.0) for k in range(3)] + [dataclasses.replace(slide(3, 2.0), stops=("load_channels",))]
    assert summarise(slides).stopped == 1


def test_job_result_round_trips(tmp_path):
    tree = run_slide(slide_job(2, "no_rocking", CampaignOptions(RIG, elements=20, duration=260.0)))
    assert json.loads(json.dumps(tree, allow_nan=False)) == tree
    scored = slide_of(tree, 2)
    assert scored.number == 2 and scored.score.peak_torque_n_m > 0.0
    assert slide_of({**tree, "score": {**tree["score"], "time_to_set_s": None}}, 2).score.time_to_set_s is None


def job_tree(**changes):
    """What a job of slide 3 returns, with other figures."""
    figures = dataclasses.asdict(slide(3, 5.0).score)
    tree = {"number": 3, "well": "3 km", "about": "no effect", "stops": [], "score": figures}
    for name, value in changes.items():
        (tree if name in tree else figures)[name] = value
    return tree


@pytest.mark.parametrize(("name", "value"), [
    ("mean_abs_error_deg", "x"), ("mean_abs_error_deg", math.nan), ("mean_abs_error_deg", -5),
    ("mean_abs_error_deg", 181.0), ("mean_abs_error_deg", None), ("p95_abs_error_deg", [1.0]), ("within_15_deg", 7),
    ("time_to_set_s", -1.0), ("peak_torque_n_m", True), ("peak_torque_n_m", math.inf), ("make_up_n_m", -math.inf),
    ("rop_m_h", 10**400), ("drilled_m", {}), ("number", 2), ("number", "3"), ("number", 3.0), ("well", 1),
    ("about", None), ("stops", [[1]]), ("score", {}), ("score", []),
])  # fmt: skip
def test_result_that_no_slide_gives_is_refused_in_one_line(tmp_path, name, value):
    job = slide_job(3, "no_rocking", CampaignOptions(RIG))
    results = ResultFolder(tmp_path)
    results.write(job.key(), job, JobResult(job_tree(), 1.0, 1.0, 1))
    parse = partial(results.parse, job.key(), lambda result: slide_of(result.tree, 3))
    assert parse().error == 5.0
    path = results.path(job.key())
    path.write_text(json.dumps({**json.loads(path.read_text()), "result": job_tree(**{name: value})}))
    with pytest.raises(InputError, match=r"\.json: not a result of this job; delete it and run again$"):
        parse()


def test_slide_without_hole_has_no_error():
    tree = job_tree(mean_abs_error_deg=None, p95_abs_error_deg=None, within_15_deg=None, drilled_m=0.0)
    assert slide_of(tree, 3).error == math.inf


@pytest.mark.slow
def test_repeated_command_resumes_from_results(tmp_path, brief):
    arguments = ["closed-loop", "--campaign", "1", "--against", "no_rocking", "--elements", "20", "--jobs", "1", "-o",
                 str(tmp_path)]  # fmt: skip
    first = CliRunner().invoke(group, [*arguments, "--json"])
    assert first.exit_code == 0, first.output
    tree = json.loads((tmp_path / "closed_loop_campaign.json").read_text())
    assert list(tree["controllers"]) == [DEFAULT_CONTROLLER, "no_rocking"]
    before = sorted(path.stat().st_mtime_ns for path in (tmp_path / "results").iterdir())
    assert len(before) == 2
    assert CliRunner().invoke(group, arguments).exit_code == 0
    assert sorted(path.stat().st_mtime_ns for path in (tmp_path / "results").iterdir()) == before
    assert "give the folder" in str(CliRunner().invoke(group, ["closed-loop", "--campaign", "1"]).exception)


@pytest.mark.slow
def test_single_slide_repeats_campaign_result(tmp_path, brief):
    arguments = ["closed-loop", "--slide", "4", "--seed", "1", "--elements", "20", "--jobs", "1", "-o", str(tmp_path)]
    result = CliRunner().invoke(group, arguments)
    assert result.exit_code == 0, result.output
    again = json.loads((tmp_path / "closed_loop.json").read_text())["scenarios"][0]
    own = slide_of(run_slide(slide_job(4, DEFAULT_CONTROLLER, brief(RIG, seed=1, elements=20))), 4).score
    assert again["name"] == "slide 4"
    assert again["mean_abs_error_deg"] == pytest.approx(own.mean_abs_error_deg, abs=1e-4)
