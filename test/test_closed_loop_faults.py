"""Faults of the rig in the closed loop: what they do to the readings, and the table."""

import dataclasses
import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.commands.closed_loop import command
from slider_drilling.control.interface import Level, MwdSample, RigCommand
from slider_drilling.drillstring import VirtualRig
from slider_drilling.effects import effects_with
from slider_drilling.errors import InputError
from slider_drilling.slide_scenarios import SCENARIOS, run_scenario
from slider_drilling.slide_scenarios.contenders import build_contender
from slider_drilling.slide_scenarios.fault_scenarios import FAULTS
from slider_drilling.slide_scenarios.fault_table import limits_for, outcome_of, terminal_header, terminal_row
from slider_drilling.slide_scenarios.faulty_rig import FaultyRig
from slider_drilling.slide_scenarios.rig_faults import LostFlow, PluggedNozzle, SensorFault
from slider_drilling.slide_scenarios.scenario import Scenario
from slider_drilling.units import SI

HOLD = next(scenario for scenario in SCENARIOS if scenario.name == "hold, 4.0 km")
STILL = RigCommand(0.0, 0.0, 0.0, 12.3)
CHANNELS = ("standpipe_pressure", "surface_torque", "hook_load", "pump_speed", "block_position", "top_drive_angle",
            "mwd")


@pytest.mark.parametrize(("fault", "expected"), [
    ({"bias": 5.0}, [10.0, 16.0, 17.0]), ({"gain": 2.0}, [10.0, 22.0, 24.0]),
    ({"drift": 3.0}, [10.0, 11.0, 15.0]), ({"stuck": True}, [10.0, 10.0, 10.0])])
def test_sensor_lies_from_its_start(fault, expected):
    lie = SensorFault("hook_load", start=1.0, **fault)
    rig = VirtualRig(HOLD.true_rig(), elements=20)
    read = [lie.reading(dataclasses.replace(rig.measurements, time=time, hook_load=value), rig.rig).hook_load
            for time, value in ((0.0, 10.0), (1.0, 11.0), (2.0, 12.0))]
    assert read == pytest.approx(expected)


def test_lying_mwd_stays_an_angle():
    rig = VirtualRig(HOLD.true_rig(), elements=20)
    samples = (MwdSample(700.0, 706.0, 3.0),)
    read = SensorFault("mwd", bias=1.0).reading(dataclasses.replace(rig.measurements, mwd=samples), rig.rig)
    assert read.mwd[0].tool_face == pytest.approx(4.0 - 2.0 * math.pi)


def settled(fault):
    rig = FaultyRig(dataclasses.replace(HOLD, faults=(fault,)), seed=0, elements=20)
    for _ in range(300):
        measured = rig.step(STILL)
    return measured


def test_lost_flow_costs_pressure_and_hides_from_the_counter():
    whole, lost = settled(SensorFault("mwd")), settled(LostFlow(0.2, 1.0, 1.0))
    assert lost.standpipe_pressure == pytest.approx(0.8 * whole.standpipe_pressure, rel=0.01)
    assert lost.pump_speed == pytest.approx(whole.pump_speed)


def test_plugged_nozzle_raises_pressure_only():
    whole, plugged = settled(SensorFault("mwd")), settled(PluggedNozzle(0.1, 1.0))
    assert plugged.standpipe_pressure == pytest.approx(1.1 * whole.standpipe_pressure, rel=0.01)
    assert plugged.hook_load == whole.hook_load


def test_friction_by_direction_shows_in_mean_torque():
    """The string turns right and left by the same angle, far enough to free itself."""
    means = []
    for excess in (0.0, 0.5):
        rig = FaultyRig(dataclasses.replace(HOLD, right_friction=excess), seed=0, elements=20)
        torque = []
        for k in range(2400):
            speed = 1.0 if k % 1200 < 600 else -1.0
            angle = 0.1 * (k % 1200 if k % 1200 < 600 else 1200 - k % 1200)
            rig.step(RigCommand(angle, speed, 0.0, 12.3))
            torque.append(rig.rig.truth.surface_torque)
        means.append(np.mean(torque[1200:]))
    assert means[1] - means[0] > 300.0


def test_every_channel_has_every_fault():
    for channel in CHANNELS:
        faults = [fault for scenario in FAULTS for fault in scenario.faults
                  if getattr(fault, "channel", "") == channel]
        assert any(fault.bias for fault in faults) and any(fault.gain != 1.0 for fault in faults), channel
        assert any(fault.drift for fault in faults) and any(fault.stuck for fault in faults), channel
    assert {scenario.duration for scenario in FAULTS} == {2400.0}


@pytest.mark.slow
@pytest.mark.parametrize(("fault", "status", "reason"), [
    (LostFlow(0.15, 300.0, 600.0), "off_bottom_pressure", "washout"),
    (SensorFault("surface_torque", drift=6.0, start=240.0), "load_channels", "torque sensor")])
def test_fault_stops_lowering_with_its_reason(fault, status, reason):
    scenario = dataclasses.replace(HOLD, duration=500.0, faults=(fault,))
    result = run_scenario(scenario, "controller", elements=20)
    stops = [event for event in result.trace.events if event[1] == "ERROR" and event[2] == status]
    assert stops and reason in stops[0][3]
    outcome, limits = outcome_of(result), limits_for(result)
    assert outcome.within_limits and outcome.peak_weight_n < limits.weight


@pytest.mark.slow
@pytest.mark.parametrize(("fault", "duration", "level", "status", "reason"), [
    (SensorFault("mwd", stuck=True, start=240.0), 560.0, "ERROR", "mwd_tool_face", "stuck"),
    (SensorFault("mwd", bias=0.7, start=240.0), 350.0, "WARN", "mwd_tool_face", "jumped by"),
    (SensorFault("hook_load", bias=50e3, start=360.0), 420.0, "ERROR", "load_channels", "hook-load sensor"),
    (SensorFault("block_position", gain=0.8, start=0.0), 320.0, "WARN", "block_following", "80%"),
    (SensorFault("top_drive_angle", bias=1.0, start=240.0), 320.0, "WARN", "top_drive", "on average")])
def test_fault_is_noticed_with_its_reason(fault, duration, level, status, reason):
    scenario = dataclasses.replace(HOLD, duration=duration, faults=(fault,))
    events = run_scenario(scenario, "controller", elements=20).trace.events
    assert any(event[1:3] == (level, status) and reason in event[3] for event in events), events


@pytest.mark.slow
def test_direction_dependent_friction_is_no_fault():
    scenario = next(one for one in SCENARIOS if one.name == "friction right +30 %")
    result = run_scenario(dataclasses.replace(scenario, duration=700.0), "controller", elements=30)
    assert not result.trace.stops and result.score.mean_abs_error_deg < 6.0


@pytest.mark.slow
def test_string_that_buckles_ends_in_the_interlock():
    effects = effects_with(buckling_contact={"factor": 2.5})
    scenario = Scenario("buckled", "5.6 km", "", duration=530.0, effects=effects)
    rig, controller = FaultyRig(scenario, 0, 25), build_contender("controller", scenario)
    measurements = rig.rig.measurements
    for _ in range(5300):
        measurements = rig.step(controller.step(measurements))
    (lock_up,) = [status for status in controller.status() if status.name == "lock_up"]
    assert lock_up.level is Level.ERROR and "stays stopped" in lock_up.message


def test_row_says_where_a_limit_was_passed():
    result = run_scenario(dataclasses.replace(HOLD, duration=5.0), "controller", elements=20)
    heavy = dataclasses.replace(result, trace=dataclasses.replace(
        result.trace, weight_on_bit=result.trace.weight_on_bit + 2e5))
    assert outcome_of(result).within_limits and not outcome_of(heavy).within_limits
    row = terminal_row(outcome_of(heavy), SI)
    assert len(row) == len(terminal_header(SI)) and row[-1] == "NO"


def test_faults_option_writes_table(tmp_path, monkeypatch):
    brief = tuple(dataclasses.replace(scenario, duration=3.0) for scenario in FAULTS[:2])
    monkeypatch.setattr("slider_drilling.slide_scenarios.fault_scenarios.FAULTS", brief)
    arguments = ["--faults", "--json", "-o", str(tmp_path), "--elements", "20", "--jobs", "1"]
    tree = json.loads(CliRunner().invoke(command, arguments, catch_exceptions=False).stdout)
    assert [row["name"] for row in tree["faults"]] == [scenario.name for scenario in brief]
    assert (tmp_path / "closed_loop_faults.json").exists() and tree["limits"]["weight"] > 1e5


def test_faults_option_excludes_others():
    with pytest.raises(InputError, match="--faults"):
        CliRunner().invoke(command, ["--faults", "--all"], catch_exceptions=False)
