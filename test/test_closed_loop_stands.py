"""Stands in the closed loop: a slide between rotating, on rigs that differ from their files, scored by the truth."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.cli import group
from slider_drilling.programmes import Programme, Rotate, Slide, Step, StepLimits
from slider_drilling.programmes.limits import complete
from slider_drilling.programmes.progress import ProgrammeProgress, ProgrammeState, StepRecord
from slider_drilling.programmes.rig_check import nominal_times
from slider_drilling.slide_scenarios import stand_run, stand_scenarios
from slider_drilling.slide_scenarios.scenario import Scenario
from slider_drilling.slide_scenarios.stand_run import StandScore, run_stand, score_stand
from slider_drilling.slide_scenarios.stand_scenarios import STANDS, StandScenario

SHORT = Scenario("short", "2.6 km", "")
TARGET = math.radians(40.0)


def stand(rig: Scenario, time: float = 20.0, tolerance_deg: float = 30.0) -> StandScenario:
    actions = (Rotate(6.0, time=20.0, block_speed=0.002), Slide(TARGET, time=time))
    limits = StepLimits(weight_on_bit=150e3, tool_face_tolerance=math.radians(tolerance_deg))
    return StandScenario(rig, Programme(tuple(Step(action) for action in actions), limits=limits))


def test_tool_face_near_its_tolerance_aborts_the_slide() -> None:
    slipping = dataclasses.replace(SHORT, block_slip=(430.0, 0.25))
    score = run_stand(stand(slipping, 300.0, 15.0), elements=15)
    assert score.outcome.startswith("the toolface is") and score.outcome.endswith("the tolerance of 15 deg")
    assert score.duration_s < 480.0


def test_every_stand_fits_its_rig() -> None:
    assert len({each.name for each in STANDS}) == len(STANDS)
    for each in STANDS:
        assert sum(nominal_times(each.programme, each.rig.assumed_rig())) > 500.0


def score(**changes: object) -> StandScore:
    """The score of 100 s of a slide that holds its toolface between 20 and 80 s."""
    time = np.arange(0.0, 100.0, 0.1)
    truth = {"time": time, "tool_face": np.full_like(time, TARGET), "surface_torque": np.full_like(time, 5e3),
             "weight_on_bit": np.full_like(time, 50e3), "standpipe_pressure": np.full_like(time, 190e5),
             "bit_depth": 2600.0 + 0.001 * time}  # fmt: skip
    for name, change in changes.items():
        truth[name] = truth[name] + change
    record = StepRecord(2, "slide", 10.0, 90.0, "done", 20.0, 80.0)
    progress = ProgrammeProgress(ProgrammeState.DONE, 2, 2, "slide", "", 0.0, "", (record,))
    scenario = stand(SHORT)
    limits = complete(scenario.programme.limits, scenario.programme.limits, SHORT.assumed_rig())
    return score_stand(scenario, progress, limits, truth)


def test_error_counts_while_the_toolface_is_held() -> None:
    time = np.arange(0.0, 100.0, 0.1)
    before_and_after = np.where((time < 19.9) | (time > 80.1), 1.0, 0.0)
    assert score(tool_face=before_and_after).largest_error_deg == pytest.approx(0.0, abs=1e-6)
    assert score(tool_face=0.1).mean_abs_error_deg == pytest.approx(math.degrees(0.1))
    assert score(tool_face=2.0 * math.pi).largest_error_deg == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    "change",
    [{"surface_torque": 21e3}, {"surface_torque": -21e3}, {"weight_on_bit": 101e3}, {"standpipe_pressure": 60e5},
     {"tool_face": 0.6}],
)  # fmt: skip
def test_each_limit_is_checked(change: dict[str, float]) -> None:
    assert score().within_limits
    assert not score(**change).within_limits


def test_score_names_hole_and_times() -> None:
    figures = score()
    assert (figures.time_to_orient_s, figures.slid_m) == pytest.approx((10.0, 0.08))


def test_slide_orients_from_rotation_and_leaves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stand_scenarios, "STANDS", (stand(SHORT),))
    arguments = ["closed-loop", "--stands", "--elements", "15", "--jobs", "1", "-o", str(tmp_path)]
    done = CliRunner().invoke(group, arguments, catch_exceptions=False)
    assert done.exit_code == 0 and "within" in done.output
    (row,) = json.loads((tmp_path / "closed_loop_stands.json").read_text())["stands"]
    assert row["outcome"] == "done" and row["within_limits"]
    assert 60.0 < row["time_to_orient_s"] < 600.0
    assert row["mean_abs_error_deg"] < 10.0
    assert row["slid_m"] > 0.05


def test_table_is_in_the_units_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    aborted = dataclasses.replace(score(), outcome="weight on bit may reach 151 kN, above the limit of 150 kN")
    monkeypatch.setattr(stand_run, "run_stands", lambda *arguments: iter([dataclasses.replace(aborted, name="short")]))
    monkeypatch.setattr(stand_scenarios, "STANDS", (stand(SHORT),))
    printed = CliRunner().invoke(group, ["closed-loop", "--stands", "--units", "field"], catch_exceptions=False).output
    assert {"ft lbf", "klbf", "psi"} <= set(re.findall(r"ft lbf|klbf|psi|kN m|kN|bar", printed))
    assert "kN" not in printed and "bar" not in printed
    assert "33.7 klbf" in printed


def test_command_refuses_options_without_meaning() -> None:
    for more in (["--duration", "900"], ["--against", "no_rocking"], ["--scheduler", "tcp://nowhere:1"]):
        done = CliRunner().invoke(group, ["closed-loop", "--stands", *more])
        assert f"{more[0]}: has no meaning" in str(done.exception)
    for more in (["--faults"], ["--set", "gain=1"], ["--controller", "mine:Mine"]):
        done = CliRunner().invoke(group, ["closed-loop", "--stands", *more])
        assert done.exit_code and "--stands: cannot be used with" in str(done.exception or done.output)
