"""Test programmes of a rig: numbers to programmes, plans before and after a log, page, JSON, and wrong input."""

import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import click
import numpy as np
import pytest
from click.testing import CliRunner
from short_well import short_rig

import slider_drilling as sd
from slider_drilling.api.plan_test import FILES, logs_of, plan_test
from slider_drilling.blind.recorder import write_sealed_log
from slider_drilling.commands.plan_test import command
from slider_drilling.diagnosis.catalogue import catalogue, of_run
from slider_drilling.diagnosis.earlier_answer import EarlierAnswer, read_earlier_answer
from slider_drilling.diagnosis.programme_numbers import programme_of, programme_variables
from slider_drilling.diagnosis.programme_words import programme_in_words
from slider_drilling.drillstring import simulate
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.gap.experiment_design.knowledge import Explanation
from slider_drilling.log import read_log
from slider_drilling.pages import page_html
from slider_drilling.programmes import Programme, Rest, Step, dump_programme, open_loop_commands, parse_programme
from slider_drilling.programmes.limits import StepLimits
from slider_drilling.programmes.progress import ProgrammeState
from slider_drilling.rig import dump_rig
from slider_drilling.test_planning.drilling_plan import PlanTestOptions, plan_after, plan_before_logs
from slider_drilling.test_planning.plan_json import plan_json
from slider_drilling.test_planning.plan_page import plan_page
from slider_drilling.units import FIELD

OPTIONS = PlanTestOptions(minutes=1.5, evaluations=4)


@pytest.fixture(scope="module")
def plan():
    return plan_before_logs(short_rig(), OPTIONS)


def test_every_point_is_a_programme_in_time():
    rig, random = short_rig(), np.random.default_rng(5)
    variables = programme_variables(rig)
    for _ in range(30):
        design = {each.name: float(random.uniform(each.lower, each.upper)) for each in variables}
        duration = float(random.uniform(60.0, 400.0))
        programme = programme_of(design, rig, duration)
        assert parse_programme(dump_programme(programme)) == programme
        steps = programme_in_words(programme, rig)
        assert steps[-1].begin + steps[-1].duration <= duration + 1e-6
        commands = open_loop_commands(programme, rig)
        # The block comes back from every pick-up: it only feeds the bit otherwise.
        assert commands.block_position[-1] >= 0.0
        assert np.max(np.abs(commands.top_drive_speed)) <= 0.6 * rig.top_drive.max_speed + 0.06


def test_plan_shows_more_than_routine_rocking(plan):
    prospect = plan.plan.planned.prospect
    assert prospect.loss < plan.plan.baseline.loss
    assert {each.name for each in prospect.effects} == {effect.name for effect in plan.plan.knowledge.effects}


def test_plan_stays_within_its_limits(plan):
    used = plan.programmes.limits.use(plan.response)
    assert max(used.values()) <= plan.plan.planned.limit_use <= 0.9


def test_routine_rocking_beyond_the_limits_is_called_so(plan):
    """Beside a test within tight limits it may show more, and is no choice."""
    name, routine = next(iter(plan.plan.fixed.items()))
    for use, expected in ((0.5, False), (3.0, True)):
        fixed = {**plan.plan.fixed, name: replace(routine, limit_use=use)}
        headline = plan_page(replace(plan, plan=replace(plan.plan, fixed=fixed))).headline
        assert ("uses more of a limit than a test may" in headline.text) is expected


def test_controller_runs_the_plan_to_its_end(plan):
    run = sd.simulate(plan.rig, programme=plan.programme, elements=30)
    assert run.progress.state is ProgrammeState.DONE, run.progress.reason


def test_guard_counts_weight_that_friction_holds(plan):
    manoeuvre = plan.plan.planned.manoeuvre
    lowering = plan.programmes.commands(manoeuvre).block_speed
    counted = plan.programmes.limits.use_by_guard(plan.response, lowering, plan.rig)
    assert counted["weight on bit"] > plan.programmes.limits.use(plan.response)["weight on bit"]
    assert max(counted.values()) <= plan.plan.planned.limit_use


def test_tighter_torque_limit_is_kept():
    limits = StepLimits(right_torque=7e3, left_torque=7e3)
    tight = plan_before_logs(short_rig(), replace(OPTIONS, limits=limits))
    assert np.max(np.abs(tight.response.surface_torque)) < 0.9 * 7e3
    assert "right_torque: 7000.0" in dump_programme(tight.programme)


def test_page_and_json_hold_every_step(plan):
    page, tree = page_html(plan_page(plan), FIELD), plan_json(plan)
    for step in programme_in_words(plan.programme, plan.rig):
        assert FIELD.convert_text(step.text) in page
    assert parse_programme(tree["programme"]) == plan.programme
    assert [each["name"] for each in tree["alternatives"]] == ["planned", "routine", "commissioning"]
    assert json.dumps(tree, allow_nan=False)


@pytest.mark.parametrize("saved", [True, False])
def test_page_names_a_command_that_can_be_run(plan, tmp_path, saved):
    """A log that was diagnosed for the plan alone has left no diagnosis to start from."""
    source = tmp_path / "diagnosis.json"
    if saved:
        source.touch()
    answer = EarlierAnswer(str(source) if saved else "the diagnosis", ("my log.mcap",), "effect_and_unknown", (), ())
    page = plan_page(replace(plan, after=answer))
    command = "Then: slider-drilling diagnose 'my log.mcap' NEW_LOG --together"
    assert str(page.notes[-1]) == (f"{command} --after {source}" if saved else command)
    assert ("known before", "1 log, verdict: effect and unknown") in page.facts
    assert "just on bottom without weight" in str(page.notes[0])


def test_toolface_swing_is_in_the_json(plan):
    limits = replace(plan.programmes.limits, tool_face_swing=0.5)
    held = replace(plan, programmes=replace(plan.programmes, limits=limits))
    assert plan_json(plan)["tool_face_swing"] is None
    assert plan_json(held)["tool_face_swing"] == 0.5


def test_no_test_follows_from_an_interrupted_diagnosis(tmp_path, monkeypatch):
    interrupted = SimpleNamespace(diagnosis=SimpleNamespace(interrupted=True))
    monkeypatch.setattr("slider_drilling.api.diagnose.diagnose", lambda *logs, **options: interrupted)
    monkeypatch.setattr("slider_drilling.log.read_log", lambda path, rig: None)
    rig = tmp_path / "rig.yaml"
    rig.write_text(dump_rig(short_rig()))
    given = ["--after", str(tmp_path / "run.mcap"), "--rig", str(rig), "-o", str(tmp_path / "out")]
    result = CliRunner().invoke(command, given, standalone_mode=False)
    assert isinstance(result.exception, click.Abort | KeyboardInterrupt)
    assert not (tmp_path / "out" / FILES[0]).exists()


def test_plan_after_a_log_separates_its_explanations(tmp_path):
    rig = short_rig()
    routine = programme_of({each.name: each.nominal for each in programme_variables(rig)}, rig, 60.0)
    commands = open_loop_commands(routine, rig)
    path = tmp_path / "run.mcap"
    write_sealed_log(path, rig, commands, simulate(rig, commands, 60), np.random.default_rng(1))
    explanations = (
        Explanation((), 0.5, {}),
        Explanation(("torque_sensor_bias",), 0.3, {"torque_sensor_bias.bias": 300.0}),
        Explanation(("static_aging",), 0.2, {"static_aging.growth": 0.5, "static_aging.time": 5.0}),
    )
    answer = EarlierAnswer("answer", (str(path),), "unknown", (), explanations)
    after = plan_after(answer, [read_log(path)], rig, OPTIONS)
    pairs = {(each.first, each.second): each.log_likelihood_ratio for each in after.plan.planned.prospect.separations}
    assert len(pairs) == 3
    assert all(ratio >= 0.0 for ratio in pairs.values())
    assert after.plan.without is not None
    before = {each.name: each.size.amplitude for each in after.plan.without.effects}
    # A run more never shows less.
    assert all(each.size.noncentrality >= 0.0 for each in after.plan.planned.prospect.effects)
    smaller = [each.size.amplitude <= 1.02 * before[each.name] for each in after.plan.planned.prospect.effects]
    assert np.mean(smaller) > 0.8


def test_each_run_has_its_own_phase():
    effects = {effect.name: effect for effect in catalogue(3000.0, 240.0, runs=2)}
    assert [parameter.name for parameter in effects["heave"].parameters][-2:] == ["heave.phase", "heave.phase#2"]
    values = {"heave.amplitude": 0.1, "heave.phase": 1.0, "heave.phase#2": 2.0}
    assert of_run(values, 0) == {"heave.amplitude": 0.1, "heave.phase": 1.0}
    assert of_run(values, 1) == {"heave.amplitude": 0.1, "heave.phase": 2.0}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "give --rig RIG, or --after"),
        (["--rig", "RIG", "--minutes", "0"], "minutes 0: must be 1 to 30 min"),
        (["--after", "JSON"], "not a diagnosis: give a diagnosis.json"),
    ],
)
def test_wrong_input_is_refused(tmp_path, arguments, words):
    (tmp_path / "no.json").write_text("[]")
    names = {"RIG": str(installed_file("config/rig.example.yaml")), "JSON": str(tmp_path / "no.json")}
    given = [names.get(argument, argument) for argument in arguments]
    result = CliRunner().invoke(command, [*given, "-o", str(tmp_path / "out")])
    assert isinstance(result.exception, InputError)
    assert words in str(result.exception)
    assert not (tmp_path / "out" / FILES[0]).exists()


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        *(("right-torque", value, "must be 0.500 to 500 kN m") for value in ("0kN.m", "-5kN.m", "501kN.m")),
        *(("left-torque", value, "must be 0.500 to 500 kN m") for value in ("0kN.m", "-5kN.m")),
        *(("weight-on-bit", value, "must be 5.00 to 2000 kN") for value in ("0kN", "-1kN")),
        *(("pressure", value, "must be 1.00 to 1500 bar") for value in ("0bar", "-10bar")),
        ("toolface-swing", "0deg", "must be above 0"),
        ("right-torque", "500kN.m", "is more than the top drive of the rig file gives; give 45.0 kN m at most"),
        ("left-torque", "46kN.m", "is more than the top drive of the rig file gives; give 45.0 kN m at most"),
        ("pressure", "10bar", "circulation alone takes"),
    ],
)
def test_limit_that_cannot_be_is_refused_by_its_option(tmp_path, option, value, words):
    rig = str(installed_file("config/rig.example.yaml"))
    result = CliRunner().invoke(command, ["--rig", rig, f"--{option}", value, "-o", str(tmp_path / "out")])
    assert isinstance(result.exception, InputError)
    assert str(result.exception).startswith(f"--{option} ")
    assert words in str(result.exception)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("value", [0.0, -5e3, float("nan"), float("inf"), "20 kN m", True])
@pytest.mark.parametrize("name", ["right_torque", "left_torque", "weight_on_bit", "pressure"])
def test_limit_that_cannot_be_is_refused_by_its_argument(name, value):
    with pytest.raises(InputError, match=f"^{name} = "):
        PlanTestOptions(limits=StepLimits(**{name: value}))


def test_limits_of_a_log_are_checked_before_its_diagnosis(tmp_path, monkeypatch):
    path = tmp_path / "run.mcap"
    sd.simulate(short_rig(), programme=Programme((Step(Rest(5.0)),)), elements=20).save(path)
    monkeypatch.setattr("slider_drilling.api.diagnose.diagnose", lambda *_, **__: pytest.fail("it was diagnosed"))
    arguments = ["--after", str(path), "--right-torque", "400kN.m", "-o", str(tmp_path / "out")]
    result = CliRunner().invoke(command, arguments)
    assert isinstance(result.exception, InputError)
    assert "--right-torque 400 kN m: is more than the top drive" in str(result.exception)


@pytest.mark.parametrize(
    ("limits", "name"),
    [
        ({"pressure": 1.1 * short_rig().circulating_pressure}, "pressure"), ({"weight_on_bit": 5e3}, "weight_on_bit"),
        ({"right_torque": 500.0}, "right_torque"), ({"left_torque": 500.0}, "left_torque"),
    ],
)  # fmt: skip
def test_limit_that_no_programme_keeps_is_named(limits, name):
    with pytest.raises(InputError, match=rf"^{name} = .*: no programme stays within this limit: .* allow more$"):
        plan_before_logs(short_rig(), replace(OPTIONS, limits=StepLimits(**limits)))


def test_diagnosis_without_explanations_says_so(tmp_path):
    path = tmp_path / "diagnosis.json"
    path.write_text(json.dumps({"schema": "slider_drilling/diagnosis/3", "log": "a.mcap", "verdict": "none"}))
    with pytest.raises(InputError, match="holds no explanations: an older version wrote it"):
        plan_test(after=path)


def diagnosis_of(folder, log):
    """A diagnosis of a log at this path, as a file."""
    folder.mkdir(parents=True, exist_ok=True)
    tree = {"schema": "slider_drilling/diagnosis/3", "log": str(log), "verdict": "none", "effects": [],
            "explanations": []}  # fmt: skip
    (folder / "diagnosis.json").write_text(json.dumps(tree))
    return read_earlier_answer(folder)


@pytest.fixture(scope="module")
def small_log(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    sd.simulate(short_rig(), programme=Programme((Step(Rest(5.0)),)), elements=20).save(path)
    return path


@pytest.mark.parametrize(
    ("named", "kept"),
    [
        ("run.mcap", "run.mcap"), ("logs/run.mcap", "logs/run.mcap"), ("run.mcap", "diagnosis/run.mcap"),
        ("logs/run.mcap", "diagnosis/logs/run.mcap"), ("/gone/run.mcap", "diagnosis/run.mcap"),
        ("logs/run.mcap", "diagnosis/run.mcap"),
    ],
)  # fmt: skip
def test_log_of_a_moved_diagnosis_is_found_beside_it(tmp_path, monkeypatch, small_log, named, kept):
    answer = diagnosis_of(tmp_path / "diagnosis", named)
    (tmp_path / kept).parent.mkdir(exist_ok=True)
    shutil.copy(small_log, tmp_path / kept)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert logs_of(answer)[0].source == str(tmp_path / kept)


def test_missing_log_of_a_diagnosis_says_where_it_was_looked_for(tmp_path, monkeypatch, small_log):
    answer = diagnosis_of(tmp_path / "diagnosis", "logs/run.mcap")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"log = 'logs/run\.mcap': is not there") as refused:
        logs_of(answer)
    for place in ("logs/run.mcap", "diagnosis/logs/run.mcap", "diagnosis/run.mcap"):
        assert str(tmp_path / place) in str(refused.value)
    assert str(refused.value).endswith("put it beside diagnosis.json")
    shutil.copy(small_log, tmp_path / "diagnosis")
    assert logs_of(answer)[0].source == str(tmp_path / "diagnosis" / "run.mcap")
