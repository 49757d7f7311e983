"""Closed loop without DDS: scores of made-up traces, faults, and short slides of the controller."""

import dataclasses
import io
import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from rich.console import Console

from slider_drilling.commands.closed_loop import command, print_results
from slider_drilling.control.interface import RigCommand
from slider_drilling.drillstring import VirtualRig
from slider_drilling.effects import Effects, effects_with
from slider_drilling.errors import InputError
from slider_drilling.pages import page_html
from slider_drilling.rig import check_rig
from slider_drilling.slide_scenarios import SCENARIOS, WELLS, SlideTrace, every_effect, run_scenario, score_slide
from slider_drilling.slide_scenarios.contenders import UNDER_TEST, build_contender, measurements_for, rig_file_for
from slider_drilling.slide_scenarios.faulty_rig import FaultyRig
from slider_drilling.slide_scenarios.page import closed_loop_page
from slider_drilling.slide_scenarios.report import as_json, information_costs, interlock_stops
from slider_drilling.slide_scenarios.run import ScenarioResult
from slider_drilling.units import FIELD, SI

HOLD = next(scenario for scenario in SCENARIOS if scenario.name == "hold, 4.0 km")


def trace_of(error_deg, duration=900.0):
    time = np.arange(1, int(duration * 10) + 1) / 10.0
    error = np.array([error_deg(t) for t in time])
    zero = np.zeros_like(time)
    target = np.full_like(time, math.radians(170.0))
    tool_face = target + np.radians(error)
    return SlideTrace(time, target, tool_face, zero, 1e3 * np.sin(time), zero + 8e4, zero + 0.0025, 0.0025 * time, ())


def test_score_wraps_error_at_half_turn():
    figures = score_slide(HOLD, trace_of(lambda t: 355.0 if t > 100.0 else 90.0))
    assert figures.mean_abs_error_deg == pytest.approx(5.0)
    assert figures.within_15_deg == 1.0
    assert figures.time_to_set_s == pytest.approx(100.1)
    assert figures.rop_m_h == pytest.approx(9.0)
    assert figures.peak_torque_n_m == pytest.approx(1e3, rel=1e-3)


def test_set_needs_a_minute_within_tolerance():
    figures = score_slide(HOLD, trace_of(lambda t: 20.0 if t % 50.0 < 1.0 else 0.0))
    assert figures.time_to_set_s is None
    assert figures.within_15_deg == pytest.approx(0.98, abs=2e-3)


def test_four_minutes_after_new_target_unscored():
    steps = dataclasses.replace(HOLD, targets=((0.0, 0.0), (450.0, 45.0)))
    figures = score_slide(steps, trace_of(lambda t: 50.0 if 450.0 <= t < 600.0 else 2.0))
    assert figures.mean_abs_error_deg == pytest.approx(2.0)
    assert figures.time_to_set_s == pytest.approx(150.0)


def test_faults_follow_scenario():
    faulty = dataclasses.replace(HOLD, mwd_lost=0.5, mwd_outliers=0.5, mwd_period=1.0)
    rig = FaultyRig(faulty, seed=3, elements=20)
    still = RigCommand(0.0, 0.0, 0.0, 12.3)
    received = [sample.tool_face for _ in range(2000) for sample in rig.step(still).mwd]
    assert 60 <= len(received) <= 130
    assert 0.3 < np.mean(np.abs(received) > 0.3) < 0.7
    slipping = FaultyRig(dataclasses.replace(HOLD, block_slip=(1.0, 0.6)), seed=3, elements=20)
    for _ in range(60):
        measurements = slipping.step(still)
    assert measurements.block_position == pytest.approx(0.6, rel=0.05)


def test_true_rig_differs_only_as_stated():
    rougher = dataclasses.replace(HOLD, friction_ratio=1.25)
    assumed, true = rougher.assumed_rig(), rougher.true_rig()
    assert [interval.factor for interval in true.well.friction_intervals] == pytest.approx(
        [1.25 * interval.factor for interval in assumed.well.friction_intervals])
    assert dataclasses.replace(true, well=assumed.well) == assumed


def test_friction_by_angle_follows_each_pipe():
    """A string that rubs twice as hard beyond 80 rad of its own angle takes twice the torque once it is all there."""
    torque, seen_angles = {}, []

    def rub(angle):
        seen_angles.append(angle.copy())
        return np.where(angle < 80.0, 1.0, 2.0)

    rig = VirtualRig(HOLD.true_rig(), elements=20, friction_of_angle=rub)
    for k in range(1, 2400):
        measured = rig.step(RigCommand(0.1 * k, 1.0, 0.0, 12.3))
        if abs(measured.time - 70.0) < 5.0:
            assert np.all(seen_angles[-1] < 80.0)
        torque[round(measured.time, 1)] = measured.surface_torque
    assert np.all(seen_angles[-1] > 80.0) and len(seen_angles[-1]) == 20
    early = np.mean([value for time, value in torque.items() if 65.0 < time < 75.0])
    late = np.mean([value for time, value in torque.items() if time > 230.0])
    assert late == pytest.approx(2.0 * early, rel=0.05)


def test_oracle_gets_true_rig_and_toolface():
    softer = dataclasses.replace(HOLD, effects=effects_with(torsional_compliance={"extra": 0.13}))
    assert rig_file_for("controller", softer).effects.torsional_compliance.extra == 0.0
    assert rig_file_for("oracle", softer).effects.torsional_compliance.extra == 0.13
    assert rig_file_for("informed", softer).sensors.mwd == softer.assumed_rig().sensors.mwd
    rig = FaultyRig(softer, seed=3, elements=20)
    measured = rig.step(RigCommand(0.0, 0.0, 0.0, 12.3))
    truth = dataclasses.replace(rig.rig.truth, tool_face=7.0)
    assert measurements_for("controller", measured, truth).mwd == ()
    assert measurements_for("oracle", measured, truth).mwd[0].tool_face == pytest.approx(7.0 - 2.0 * math.pi)


@pytest.mark.slow
def test_controller_sets_and_holds_toolface():
    """On 50 elements instead of the 200 of `closed-loop`."""
    outcome = run_scenario(dataclasses.replace(HOLD, duration=480.0), "controller", elements=50)
    assert outcome.score.time_to_set_s is not None
    assert outcome.score.mean_abs_error_deg < 8.0


@pytest.mark.slow
def test_same_seed_gives_same_run():
    brief = dataclasses.replace(HOLD, duration=250.0, mwd_lost=0.3, mwd_outliers=0.2)
    first, second = (run_scenario(brief, "controller", seed=7, elements=20) for _ in range(2))
    assert np.array_equal(first.trace.tool_face, second.trace.tool_face)
    assert first.score == second.score


@pytest.mark.slow
def test_command_writes_json_and_page(tmp_path, monkeypatch):
    brief = (dataclasses.replace(HOLD, duration=250.0),)
    monkeypatch.setattr("slider_drilling.slide_scenarios.SCENARIOS", brief)
    monkeypatch.setattr("slider_drilling.slide_scenarios.run.DAILY", brief)
    outcome = CliRunner().invoke(
        command, ["--json", "-o", str(tmp_path), "--elements", "20", "--jobs", "1"], catch_exceptions=False)
    figures = json.loads(outcome.stdout)
    assert figures.pop("wrote") == [str(tmp_path / "closed_loop.json"), str(tmp_path / "closed_loop.html")]
    assert json.loads((tmp_path / "closed_loop.json").read_text()) == figures
    scenario = figures["scenarios"][0]
    asked = {"name", "well", "mwd_period_s", "mean_abs_error_deg", "within_15_deg", "time_to_set_s", "peak_torque_n_m",
             "p95_abs_error_deg", "rop_m_h", "no_rocking", "fixed_rocking", "informed", "oracle"}
    assert asked <= set(scenario)
    assert scenario["no_rocking"]["peak_torque_n_m"] < scenario["fixed_rocking"]["peak_torque_n_m"]
    page = (tmp_path / "closed_loop.html").read_text()
    assert len(page) < 1_500_000 and "hold, 4.0 km" in page


def test_idle_controller_has_no_error():
    """Off bottom the toolface does not move: 0 deg of error, but nothing drilled."""
    scenario = SCENARIOS[0]
    time = np.arange(0.0, scenario.duration, 1.0)
    still = np.zeros_like(time)
    target = np.full_like(time, scenario.targets[0][1])
    trace = SlideTrace(time, target, target, still, still, still, still, still + 4000.0, ())
    idle = score_slide(scenario, trace)
    assert idle.nothing_drilled and idle.drilled_m == 0.0
    assert math.isnan(idle.mean_abs_error_deg) and math.isnan(idle.within_15_deg) and idle.time_to_set_s is None
    row = {UNDER_TEST: ScenarioResult(scenario, UNDER_TEST, idle, trace)}
    figures = as_json([row], "module:Idle", 0, 200)["scenarios"][0]
    assert figures["mean_abs_error_deg"] is None and figures["within_15_deg"] is None
    page = closed_loop_page([row], "module:Idle", 0, 200)
    assert "Nothing was drilled in 1." in page.headline.text and page.headline.tone == "bad"
    assert "nothing drilled" in page_html(page, FIELD)


def test_page_reports_stops_and_unheld_slides():
    lock = "weight no longer arrives: 108 kN hang on pipe below 3458 m"
    events = ((0.1, "WARN", "tool_face", "no MWD"), (329.4, "ERROR", "lock_up", lock), (436.0, "WARN", "lock_up", ""),
              (700.0, "ERROR", "lock_up", "again"), (800.0, "ERROR", "clock", "stamps stand still"))
    trace = dataclasses.replace(trace_of(lambda t: 20.0 if t > 800.0 else 1.0), events=events)
    row = {UNDER_TEST: ScenarioResult(HOLD, UNDER_TEST, score_slide(HOLD, trace), trace)}
    assert interlock_stops(row) == [(329.4, "lock_up", lock), (800.0, "clock", "stamps stand still")]
    assert as_json([row], "a:B", 0, 200)["scenarios"][0]["interlocks"][0] == {
        "time_s": 329.4, "name": "lock_up", "message": lock}
    lead = closed_loop_page([row], "a:B", 0, 200).headline
    assert "more than 15 deg off for over 5 % of the time in 1." in lead.text and lead.tone == "bad"
    held = results_of(HOLD, 1.0, 1.0, 1.0)
    assert closed_loop_page([held], "a:B", 0, 200).headline.tone == "good"


def test_terminal_reports_interlock_stops(monkeypatch):
    trace = dataclasses.replace(trace_of(lambda t: 1.0), events=((329.4, "ERROR", "lock_up", "weight [kN] hangs"),))
    outcome = ScenarioResult(HOLD, UNDER_TEST, score_slide(HOLD, trace), trace)
    monkeypatch.setattr("slider_drilling.slide_scenarios.run_all", lambda *args: iter([outcome]))
    printed = CliRunner().invoke(command, ["--only", HOLD.name], catch_exceptions=False).stdout
    assert f"{HOLD.name}, 329 s: lock_up: weight [kN] hangs" in " ".join(printed.split())


def results_of(scenario, *means):
    """Results of controller, informed and oracle with these mean errors."""
    results = {}
    for contender, mean in zip(("controller", "informed", "oracle"), means, strict=True):
        trace = trace_of(lambda t, mean=mean: mean, 300.0)
        results[contender] = ScenarioResult(scenario, contender, score_slide(scenario, trace), trace)
    return results


def test_costs_of_rig_file_and_mwd():
    brief = dataclasses.replace(HOLD, targets=((0.0, 170.0),), duration=300.0)
    rows = [results_of(brief, 3.0, 2.0, 0.5), results_of(brief, 4.0, 2.5, 1.5), results_of(brief, 9.0, 6.0, 5.5)]
    sentence = information_costs(rows)
    assert "4.00 deg; 2.50 deg with the true rig file, 1.50 deg with the true toolface" in sentence
    assert "costs +1.50 deg, MWD +1.00 deg" in sentence
    assert information_costs([{UNDER_TEST: rows[0][UNDER_TEST]}]) == "" == information_costs(rows[:1])


@pytest.mark.slow
def test_every_effect_has_two_sizes_and_pairs():
    scenarios = every_effect()
    names = [scenario.name for scenario in scenarios]
    assert len(set(names)) == len(names) and not set(names) & {scenario.name for scenario in SCENARIOS}
    neutral = Effects()
    for block in (field.name for field in dataclasses.fields(Effects)):
        alone = [scenario for scenario in scenarios if [
            field.name for field in dataclasses.fields(Effects)
            if getattr(scenario.effects, field.name) != getattr(neutral, field.name)] == [block]]
        assert sorted(scenario.well for scenario in alone) == sorted(2 * list(WELLS)), block
        assert len({getattr(scenario.effects, block) for scenario in alone if scenario.well == "4.0 km"}) == 2, block
    pairs = [scenario for scenario in scenarios if " and " in scenario.name]
    assert len(pairs) >= 9
    for scenario in scenarios:
        check_rig(scenario.true_rig())
        assert scenario.assumed_rig().effects == neutral


def test_settings_reach_controller_or_are_refused(tmp_path):
    assert build_contender("controller", HOLD, settings={"gain": 1.25}).settings.gain == 1.25
    assert build_contender("oracle", HOLD, settings={"gain": 1.25}).settings.gain == 1.25
    for wrong in ("gane=1", "gain=99", "gain"):
        with pytest.raises(InputError, match=r"--set|gain"):
            CliRunner().invoke(command, ["--only", "hold, 2.6", "--set", wrong], catch_exceptions=False)


def test_table_fits_eighty_columns(monkeypatch):
    monkeypatch.setattr("slider_drilling.console.streams.stdout", lambda: Console(width=80, file=shown))
    shown = io.StringIO()
    longest = max(every_effect(), key=lambda scenario: len(scenario.name))
    row = results_of(dataclasses.replace(longest, targets=((0.0, 170.0),), duration=300.0), 123.45, 101.25, 88.75)
    print_results([row], SI)
    lines = shown.getvalue().splitlines()
    assert max(map(len, lines)) <= 80
    for number in ("123.45", "101.25", "88.75"):
        assert number in lines[2] or number in lines[3]
    assert "\u2026" not in shown.getvalue()


def test_unknown_scenario_is_refused():
    with pytest.raises(InputError, match="--only"):
        CliRunner().invoke(command, ["--only", "nonsense"], catch_exceptions=False)


@pytest.mark.parametrize(("options", "said"), [
    ("--duration 600", "--duration: has no meaning without --campaign or --slide"),
    ("--foreign --faults", "--foreign: has no meaning without"), ("--rig mine.yaml", "--rig: has no meaning without"),
    ("--against no_rocking --only hold", "--against: has no meaning without"),
    ("--slide 3 --only hold", "--only: has no meaning with --slide"),
    ("--campaign 3 -o out --all", "--all: has no meaning with --campaign"),
    ("--campaign 3 -o out --slide 2", "--slide: has no meaning with --campaign"),
])  # fmt: skip
def test_options_without_meaning_are_refused(options, said):
    done = CliRunner().invoke(command, options.split())
    assert done.exit_code and said in str(done.exception or done.output)
