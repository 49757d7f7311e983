"""Friction from the driller's weights, on wells whose friction is known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from short_well import short_rig

import slider_drilling as sd
from slider_drilling.analysis.calibrate_friction import calibrate_friction
from slider_drilling.analysis.driller_weights import DrillerWeights, read_driller_weights
from slider_drilling.analysis.friction_misfit import with_friction_factors
from slider_drilling.analysis.weights_in_log import find_weights
from slider_drilling.blind.wells import DEFAULT_WELLS, WELLS
from slider_drilling.commands.torque_drag import command
from slider_drilling.drillstring import Commands, simulate
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log.series import JointSeries
from slider_drilling.rig import FrictionInterval, Rig, StringSection, dump_rig
from slider_drilling.wellbore.broomstick import broomstick
from slider_drilling.wellbore.survey_table import read_survey

KLBF, FT = 4448.2216, 0.3048
BLOCK = 62.0 * KLBF


def drawn(seed: int) -> tuple[Rig, Rig]:
    """A rig file's rig and the true one: its friction factors, and a string that weighs 2 % more."""
    generator = np.random.default_rng(seed)
    rig = WELLS[DEFAULT_WELLS[seed % 3]](generator, sd.load_rig())
    truth = with_friction_factors(rig, np.array([generator.uniform(0.4, 0.8), generator.uniform(0.5, 0.95)]))
    return rig, replace(truth, string=replace(truth.string, weight_factor=1.02))


def readings(truth: Rig, generator: np.random.Generator, *shares: float) -> list[DrillerWeights]:
    """What a driller reads, to 1 klbf and 3 % of torque, block and all, with the bit at shares of the depth."""
    stick = broomstick(truth, None, [share * truth.string.length for share in shares])
    rows = zip(stick.depth, stick.pick_up, stick.slack_off, stick.rotating, stick.torque, strict=True)
    noisy = [[depth, *(KLBF * np.round(load / KLBF + generator.normal(0.0, 0.7)) + BLOCK for load in loads),
              torque * generator.normal(1.0, 0.03)] for depth, *loads, torque in rows]  # fmt: skip
    return [DrillerWeights(*row) for row in noisy]


@pytest.mark.parametrize("seed", range(6))
def test_factors_are_found_from_readings(seed):
    """Open hole within 5 %, cased within 10 %, from readings at twelve depths."""
    rig, truth = drawn(seed)
    found = calibrate_friction(rig, readings(truth, np.random.default_rng(seed), *np.linspace(0.5, 1.0, 12)), BLOCK)
    cased, open_hole = (row.factor for row in truth.well.friction_intervals)
    assert found.intervals[1].factor == pytest.approx(open_hole, rel=0.05)
    assert found.intervals[0].factor == pytest.approx(cased, rel=0.10)
    assert found.weight_factor == pytest.approx(1.02, abs=0.012)


def test_intervals_hold_the_truth():
    """At least 30 of 36 95 % intervals hold it."""
    held = 0
    for seed in range(100, 118):
        rig, truth = drawn(seed)
        found = calibrate_friction(rig, readings(truth, np.random.default_rng(seed), 0.6, 1.0), BLOCK)
        for row, true in zip(found.intervals, truth.well.friction_intervals, strict=True):
            held += row.factor_interval[0] <= true.factor <= row.factor_interval[1]
    assert 30 <= held <= 36


def test_vertical_casing_is_not_determined():
    """A straight casing has no friction to measure: its factor keeps the rig file's ratio, and says so."""
    rig, _ = drawn(0)
    kick = rig.well.survey[1][0]
    intervals = tuple(replace(row, to=kick if place == 0 else row.to)
                      for place, row in enumerate(rig.well.friction_intervals))  # fmt: skip
    rig = replace(rig, well=replace(rig.well, friction_intervals=intervals))
    truth = with_friction_factors(rig, np.array([0.5, 0.6]))
    found = calibrate_friction(rig, readings(truth, np.random.default_rng(1), 1.0), BLOCK)
    assert not found.intervals[0].is_determined
    assert found.intervals[1].is_determined
    assert found.intervals[0].factor == pytest.approx(0.8 * found.intervals[1].factor, rel=0.02)


def test_untared_weights_need_the_block():
    rig, truth = drawn(3)
    rows = readings(truth, np.random.default_rng(3), 0.9)
    with pytest.raises(InputError, match=r"give its weight .* with --block-weight"):
        calibrate_friction(rig, rows)
    tared = [row.without(BLOCK) for row in rows]
    assert "taken as those of the string alone" in calibrate_friction(rig, tared).notes[0]


def test_swapped_weights_are_refused():
    with pytest.raises(InputError, match=r"pick-up weight .* is below slack-off weight .* swapped"):
        calibrate_friction(sd.load_rig(), [DrillerWeights(4000.0, pick_up=200e3, slack_off=400e3)])


def manoeuvre(truth: Rig) -> RigLog:
    """A log of rotation off bottom, pick-up and slack-off, as the plant gives it."""
    time = np.arange(0.0, 330.0, 0.1)
    turning = np.interp(time, [0.0, 60.0, 65.0, 130.0, 135.0], [0.0, 0.0, 4.0, 4.0, 0.0])
    speed = np.interp(time, [0.0, 5.0, 45.0, 50.0, 150.0, 155.0, 215.0, 220.0, 240.0, 245.0, 300.0, 305.0],
                      [-0.1, -0.1, -0.1, 0.0, 0.0, -0.1, -0.1, 0.0, 0.0, 0.1, 0.1, 0.0])  # fmt: skip
    angle, block = (np.concatenate([[0.0], np.cumsum(0.05 * (rate[1:] + rate[:-1]))]) for rate in (turning, speed))
    response = simulate(truth, Commands(time, angle, turning, block, speed, np.zeros_like(time)), 100)
    return RigLog(
        source="made",
        start_ns=0,
        top_drive=JointSeries(time, time, angle, turning, response.surface_torque),
        draw_works=JointSeries(time, time, block, speed, response.hook_load + BLOCK),
    )


def test_log_weights_give_the_friction():
    rig = short_rig()
    truth = with_friction_factors(rig, np.array([0.9, 1.2]))
    log = manoeuvre(truth)
    (row,) = find_weights(log, rig)
    loads = broomstick(truth, None, [row.depth])
    for motion in ("pick_up", "slack_off", "rotating"):
        assert getattr(row, motion) - BLOCK == pytest.approx(getattr(loads, motion)[0], abs=2e3)
    assert row.torque == pytest.approx(loads.torque[0], rel=0.05)
    found = calibrate_friction(rig, [row], BLOCK)
    assert found.intervals[1].factor == pytest.approx(1.2, rel=0.05)


def test_rocking_on_bottom_gives_no_weights():
    time = np.arange(0.0, 120.0, 0.1)
    rocked = JointSeries(time, time, 5.0 * np.sin(time / 3.0), 5.0 / 3.0 * np.cos(time / 3.0), 3e3 * np.sin(time / 3.0))
    lowered = JointSeries(time, time, 0.003 * time, np.full_like(time, 0.003), np.full_like(time, 3e5))
    log = RigLog(source="made", start_ns=0, top_drive=rocked, draw_works=lowered)
    assert find_weights(log, short_rig()) == ()


def test_table_of_weights_is_read(tmp_path: Path):
    table = tmp_path / "weights.csv"
    table.write_text("Bit depth [ft],Pick-up [klbf],Slack-off [klbf],Rotating [klbf],Torque [ft lbf]\n"
                     "9000,200,150,175,3000\n14500,260,121,193,\n")  # fmt: skip
    first, last = read_driller_weights(table)
    assert first.depth == pytest.approx(9000.0 * FT)
    assert (first.pick_up, first.torque) == pytest.approx((200.0 * KLBF, 3000.0 * 1.3558179483))
    assert last.torque is None


@pytest.mark.parametrize(("text", "message"), [
    ("Depth [ft],Pick-up\n9000,200\n", "column 'Pick-up': has no unit"),
    ("Depth [ft],Pick-up [psi]\n9000,200\n", "is a unit of pressure"),
    ("Depth [ft],Remark\n9000,x\n", "need the bit depth and at least one"),
    ("Depth [ft],Pick-up [klbf]\n9000,much\n", "line 2: Pick-up [klbf] = 'much': not a number"),
    ("Depth [ft],Pick-up [klbf],Slack-off [klbf]\n9000,121,260\n", "line 2: pick-up weight 121.0 klbf is below"),
    ("Depth [ft],Pick-up [klbf]\n9000,\n", "line 2: no reading"),
])  # fmt: skip
def test_faulty_table_is_named(tmp_path: Path, text: str, message: str):
    table = tmp_path / "weights.csv"
    table.write_text(text)
    with pytest.raises(InputError) as caught:
        read_driller_weights(table)
    assert message in str(caught.value)


def test_command_writes_the_calibrated_rig(tmp_path: Path):
    rig, truth = drawn(6)
    path = tmp_path / "rig.yaml"
    path.write_text(dump_rig(rig))
    *rows, last = readings(truth, np.random.default_rng(6), *np.linspace(0.5, 1.0, 12))
    table = tmp_path / "weights.csv"
    table.write_text("depth_m,pick_up_N,slack_off_N\n" + "".join(
        f"{row.depth},{row.pick_up},{row.slack_off}\n" for row in rows))  # fmt: skip
    given = [f"--weights={table}", *(f"--{name}={value / KLBF}klbf" for name, value in (
        ("pick-up", last.pick_up), ("slack-off", last.slack_off), ("rotating", last.rotating),
        ("block-weight", BLOCK)))]  # fmt: skip
    result = CliRunner().invoke(command, ["--rig", str(path), "-o", str(tmp_path / "out"), *given, "--json",
                                          f"--free-torque={last.torque}N.m", "--elements", "50"])  # fmt: skip
    assert result.exit_code == 0, result.output
    tree = json.loads(result.stdout)
    factor = tree["calibration"]["friction"][1]["factor"]
    written = sd.load_rig(tmp_path / "out" / "torque_drag.rig.yaml").well.friction_intervals
    assert written[1].factor == pytest.approx(factor)
    assert factor == pytest.approx(truth.well.friction_intervals[1].factor, rel=0.05)
    assert "Friction from the driller" in (tmp_path / "out" / "torque_drag.html").read_text()


def test_number_without_unit_is_refused(tmp_path: Path):
    result = CliRunner().invoke(command, ["-o", str(tmp_path), "--pick-up", "260"])
    assert isinstance(result.exception, InputError)
    assert "--pick-up = '260': expected a number and its unit" in str(result.exception)


def test_paper_well_agrees_with_its_torque(shared_data: Path):
    """Weights alone give an open-hole friction whose torque is the one that was read, within 5 %."""
    rig = paper_rig(shared_data)
    found = calibrate_friction(rig, [DrillerWeights(14500.0 * FT, 260.0 * KLBF, 121.0 * KLBF, 193.0 * KLBF)],
                               62.0 * KLBF)  # fmt: skip
    cased, open_hole = found.intervals
    assert open_hole.is_determined
    assert not cased.is_determined
    torque = broomstick(found.rig, None, [14500.0 * FT]).torque[0]
    assert torque == pytest.approx(7000.0 * 1.3558179, rel=0.05)


def paper_rig(shared_data: Path) -> Rig:
    """Survey and tally of the paper well on the example rig; friction is the rig file's."""
    survey = read_survey(shared_data / "paper_well" / "survey.csv").stations
    rows = (("drill pipe", 5.0, 4.276, 21.9, 13810.0), ("HWDP", 5.0, 3.0, 49.3, 600.0),
            ("NMDC", 6.75, 2.81, 104.0, 59.2), ("motor", 6.75, 2.81, 96.0, 30.8))  # fmt: skip
    inch, pound_per_foot = 0.0254, KLBF / 1e3 / FT
    sections = tuple(StringSection(name, length * FT, outer * inch, inner * inch, weight * pound_per_foot)
                     for name, outer, inner, weight, length in rows)  # fmt: skip
    rig = sd.load_rig()
    depth = sum(section.length for section in sections)
    intervals = (FrictionInterval(6200.0 * FT, 0.8), FrictionInterval(depth, 1.0))
    well = replace(rig.well, survey=(*survey[:-1], (depth, *survey[-1][1:])), friction_intervals=intervals)
    return replace(rig, well=well, mud=replace(rig.mud, density=9.6 * 119.8264),
                   string=replace(rig.string, sections=sections))  # fmt: skip
