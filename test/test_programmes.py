"""Programmes: the file is read with its units or refused in one line; the motion is what the steps say."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.errors import InputError
from slider_drilling.programmes import (
    DrillOff,
    Flow,
    PickUp,
    Programme,
    Rest,
    Rock,
    Rotate,
    Slide,
    Step,
    dump_programme,
    load_programme,
    open_loop_commands,
    parse_programme,
)
from slider_drilling.programmes.open_loop import SETTLING, plan_programme
from slider_drilling.rig import Rig, load_rig

CONFIG = Path(__file__).parents[1] / "config"
COMMISSIONING = CONFIG / "programmes" / "commissioning.yaml"


@pytest.fixture(scope="module")
def rig() -> Rig:
    return load_rig(CONFIG / "rig.example.yaml")


def steps(*lines: str) -> str:
    return "schema: slider_drilling/programme/1\nsteps:\n" + "".join(f"  - {line}\n" for line in lines)


def test_units_beside_numbers_are_converted() -> None:
    programme = parse_programme(steps("rock: {right: 2 turns, left: 90 deg, speed: 60 rpm, cycles: 2}"))
    action = programme.steps[0].action
    assert isinstance(action, Rock)
    assert (action.right, action.left, action.speed) == pytest.approx((4 * math.pi, math.pi / 2, 2 * math.pi))


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("rest: {time: -1 s}", r"steps\[0\].rest.time = '-1 s': must be above 0 s"),
        ("rest: {tme: 1 s}", "did you mean time"),
        ("rst: {time: 1 s}", "unknown step; known steps: rotate"),
        ("rotate: {speed: 60, time: 9 s}", "is this 60 rpm"),
        ("rotate: {speed: 60 rpm}", "one of time and length, not neither"),
        ("rotate: {speed: 60 rpm, time: 9 s, length: 1 m}", "one of time and length, not both"),
        ("rotate: {speed: 60 m, time: 9 s}", "is a unit of length"),
        ("rock: {right: 0, left: 0, speed: 60 rpm, cycles: 1}", "right and left are both 0"),
        ("{rest: {time: 1 s}, flow: {flow: 30 L/s}}", "expected one step, found rest, flow"),
        ("{rest: {time: 1 s}, limits: {bit: up}}", "must be on bottom, off bottom or either"),
        ("{rest: {time: 1 s}, limits: {weight_on_bit: 100}}", "is this 100 kN"),
        ("slide: {tool_face: 30, time: 60 s}", "write 30 deg"),
        ("{rest: {time: 1 s}, limits: []}", r"steps\[0\].limits = \[\]: expected keys and values"),
        ("{rest: {time: 1 s}, limits: 0}", r"steps\[0\].limits = 0: expected keys and values"),
        ("{rest: {time: 1 s}, note: false}", r"steps\[0\].note = False: expected text"),
        ("{rest: {time: 1 s}, limits: {weight_on_bit: 1 kN}}", "must be at least 5000 N$"),
        ("{rest: {time: 1 s}, limits: {tool_face_tolerance: 20}}", "at most 3.14159 rad .15 to 180 deg"),
    ],
)
def test_bad_steps_are_refused_by_name(line: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_programme(steps(line))


def test_written_programme_reads_back_unchanged() -> None:
    programme = load_programme(COMMISSIONING)
    assert parse_programme(dump_programme(programme)) == programme


def test_strokes_reach_their_wraps_and_return(rig: Rig) -> None:
    programme = Programme((Step(Rock(right=12.0, left=7.0, speed=3.0, rest=2.0, cycles=2)),))
    commands = open_loop_commands(programme, rig)
    angle = commands.top_drive_angle
    assert (angle.max(), angle.min(), angle[-1]) == pytest.approx((12.0, -7.0, 0.0), abs=0.01)
    assert np.abs(commands.top_drive_speed).max() == pytest.approx(3.0)
    acceleration = np.diff(commands.top_drive_speed) / np.diff(commands.time)
    assert np.abs(acceleration).max() <= programme.drive_acceleration + 1e-9
    assert np.isclose(angle, -7.0, atol=1e-6).sum() == pytest.approx(np.isclose(angle, 12.0, atol=1e-6).sum(), abs=2)
    at_rest = np.isclose(angle, 12.0, atol=1e-6).sum() / rig.sensors.rate
    assert at_rest == pytest.approx(2 * 2.0, abs=0.3)


def test_positions_are_integrals_of_speeds(rig: Rig) -> None:
    commands = open_loop_commands(load_programme(COMMISSIONING), rig)
    step = np.diff(commands.time)
    for position, speed, most in (
        (commands.top_drive_angle, commands.top_drive_speed, 4.0),
        (commands.block_position, commands.block_speed, 0.05),
    ):
        mean = 0.5 * (speed[1:] + speed[:-1])
        # A change of acceleration between two samples is all that the trapezoidal rule can miss.
        assert np.abs(np.diff(position) - mean * step).max() < most * step[0] ** 2


def test_rotating_a_length_drills_it(rig: Rig) -> None:
    programme = Programme((Step(PickUp(3.0)), Step(Rotate(6.0, length=1.0, block_speed=0.02))))
    commands = open_loop_commands(programme, rig)
    assert commands.block_position[-1] == pytest.approx(1.0, abs=0.01)
    # Down to half a metre above bottom the block is faster than it drills.
    assert commands.block_speed[commands.block_position < -0.6].max() == pytest.approx(0.05)
    assert commands.block_speed[commands.block_position > -0.4].max() == pytest.approx(0.02, abs=0.005)


def test_length_without_block_speed_is_refused(rig: Rig) -> None:
    with pytest.raises(InputError, match=r"steps\[0\].rotate: length = 1 m needs a block that is lowered"):
        open_loop_commands(Programme((Step(Rotate(6.0, length=1.0)),)), rig)


def test_slide_needs_feedback(rig: Rig) -> None:
    programme = Programme((Step(Rest(1.0)), Step(Slide(0.5, time=60.0))))
    with pytest.raises(InputError, match=r"steps\[1\].slide: a slide depends on what is measured"):
        open_loop_commands(programme, rig)


def test_block_goes_on_after_drill_off(rig: Rig) -> None:
    text = steps("block_speed: {speed: 9 m/h}", "drill_off: {time: 5 s}", "rest: {time: 9 s}")
    commands = open_loop_commands(parse_programme(text), rig)
    time = commands.time - SETTLING
    assert commands.block_speed[time < 2.0].max() > 0.0
    assert not commands.block_speed[(time > 4.1) & (time < 7.0)].any()
    assert commands.block_speed[-1] == pytest.approx(0.0025)


def test_flow_changes_within_its_ramp(rig: Rig) -> None:
    commands = open_loop_commands(Programme((Step(Flow(0.016, ramp=4.0)), Step(DrillOff(2.0)))), rig)
    half = 0.016 / rig.mud_pump.displacement
    assert commands.pump_speed[0] == pytest.approx(2.0 * half)
    assert commands.pump_speed[commands.time >= 4.0 + SETTLING] == pytest.approx(half)


def test_commissioning_takes_four_minutes(rig: Rig) -> None:
    planned = plan_programme(load_programme(COMMISSIONING), rig)
    assert 200.0 < planned[-1].begin + planned[-1].motion.duration <= 240.0
