"""FixedRocking: sign of its correction, continuity, and torque limits."""

import dataclasses
import itertools
import math
from types import SimpleNamespace

import pytest

from slider_drilling.control.fixed_rocking import FixedRocking, FixedRockingSettings, settings_for
from slider_drilling.control.interface import Measurements, MwdSample
from slider_drilling.errors import InputError

# Only what the controller reads of a rig file.
RIG = SimpleNamespace(top_drive=SimpleNamespace(max_acceleration=20.0),
                      string=SimpleNamespace(sections=(SimpleNamespace(length=3940.0),
                                                       SimpleNamespace(length=60.0))),
                      reference_pump_speed=0.032 / 0.0026)


def measurements(time, angle=0.0, torque=0.0, mwd=()):
    return Measurements(time=time, top_drive_angle=angle, top_drive_speed=0.0, surface_torque=torque,
                        block_position=0.0, block_speed=0.0, hook_load=4e5, standpipe_pressure=1.8e7,
                        pump_speed=12.3, mwd=mwd)


def run(controller, duration, mwd_at=None, torque=lambda angle: 0.0, period=0.1):
    """Step a controller whose rig follows at once; mwd_at: time -> toolface or None."""
    commands, angle = [], 0.0
    for k in range(round(duration / period)):
        time = k * period
        tool_face = None if mwd_at is None else mwd_at(k)
        mwd = () if tool_face is None else (MwdSample(time - 6.0, time, tool_face),)
        command = controller.step(measurements(time, angle, torque(angle), mwd))
        angle = command.top_drive_angle
        commands.append(command)
    return commands


def test_settings_follow_the_rig():
    settings = settings_for(RIG)
    assert (settings.amplitude, settings.period) == (20.0, 24.0)
    assert settings.pump_speed == pytest.approx(0.032 / 0.0026)
    string = SimpleNamespace(sections=(SimpleNamespace(length=3300.0),))
    half_way = SimpleNamespace(**{**vars(RIG), "string": string})
    assert (settings_for(half_way).amplitude, settings_for(half_way).period) == (14.0, 19.0)


@pytest.mark.parametrize(("tool_face_deg", "side"), [(-20.0, 1.0), (20.0, -1.0)])
def test_centre_moves_against_the_error(tool_face_deg, side):
    """A toolface left of its target needs the centre further right, by the gain times the error."""
    controller = FixedRocking(RIG)
    plain = run(FixedRocking(RIG), 48.0)
    shifted = run(controller, 48.0, lambda k: math.radians(tool_face_deg) if k == 10 else None)
    shift = shifted[-1].top_drive_angle - plain[-1].top_drive_angle
    assert shift == pytest.approx(side * 0.1 * math.radians(20.0))


def test_error_is_unwrapped():
    """170 then -170 degrees is 190: the correction goes on to the left, it does not turn round."""
    controller = FixedRocking(RIG)
    samples = {10: math.radians(170.0), 20: math.radians(-170.0)}
    shifted = run(controller, 48.0, samples.get)
    plain = run(FixedRocking(RIG), 48.0)
    shift = shifted[-1].top_drive_angle - plain[-1].top_drive_angle
    assert shift == pytest.approx(-0.1 * math.radians(170.0 + 190.0))


def test_trajectory_is_continuous():
    commands = run(FixedRocking(RIG), 60.0, lambda k: 1.0 if k % 120 == 60 else None)
    fastest = 4 * 20.0 / 24.0 + 0.5
    for before, after in itertools.pairwise(commands):
        assert abs(after.top_drive_angle - before.top_drive_angle) <= fastest * 0.1 + 1e-9


def test_torque_limit_reverses_stroke():
    """On a rig whose torque is 200 N m per rad, limits of 2 and 1 kN m turn it near 10 and -5 rad."""
    settings = dataclasses.replace(settings_for(RIG), right_torque_limit=2000.0, left_torque_limit=1000.0)
    angles = [c.top_drive_angle for c in run(FixedRocking(RIG, settings), 120.0, torque=lambda a: 200.0 * a)]
    overshoot = (4 * 20.0 / 24.0) * (0.25 / 2 + 2 * 0.1)
    assert 10.0 <= max(angles) <= 10.0 + overshoot
    assert -5.0 - overshoot <= min(angles) <= -5.0


def test_torque_limited_rocking_corrects_by_bump():
    settings = dataclasses.replace(settings_for(RIG), right_torque_limit=2000.0, left_torque_limit=2000.0)
    controller = FixedRocking(RIG, settings)
    angles = [c.top_drive_angle for c in
              run(controller, 120.0, lambda k: -2.0 if k == 400 else None, torque=lambda a: 200.0 * a)]
    plain = max(angles[:400])
    assert max(angles[400:]) == pytest.approx(plain + 0.2, abs=0.4)
    assert max(angles[400:]) > plain
    assert min(angles[400:]) >= min(angles[:400]) - 0.4


def test_missing_torque_leaves_amplitude_limit():
    settings = dataclasses.replace(settings_for(RIG), right_torque_limit=2000.0, left_torque_limit=2000.0)
    angles = [c.top_drive_angle for c in run(FixedRocking(RIG, settings), 120.0, torque=lambda a: math.nan)]
    assert max(angles) <= 20.0 and min(angles) >= -20.0


def test_silent_rig_is_held_and_resumed():
    controller = FixedRocking(RIG)
    before = run(controller, 5.0)[-1]
    lost = [controller.step(measurements(4.9 + 0.1 * k, math.nan)) for k in range(1, 10)]
    assert {(c.top_drive_angle, c.top_drive_speed, c.block_speed) for c in lost} == {(before.top_drive_angle, 0.0, 0.0)}
    assert all(c.pump_speed == before.pump_speed for c in lost)
    after = controller.step(measurements(5.9))
    assert abs(after.top_drive_angle - before.top_drive_angle) < 0.5 and after.block_speed == 0.0025


def test_backward_clock_holds_angle():
    controller = FixedRocking(RIG)
    for k in range(50):
        last = controller.step(measurements(0.1 * k))
    assert controller.step(measurements(1.0)).top_drive_angle == last.top_drive_angle


def test_configure_keeps_the_angle():
    controller = FixedRocking(RIG)
    before = run(controller, 10.0)[-1]
    controller.configure(dataclasses.replace(controller.settings, amplitude=10.0, period=14.0))
    after = controller.step(measurements(9.9))
    assert after.top_drive_angle == pytest.approx(before.top_drive_angle, abs=1e-9)


@pytest.mark.parametrize("change", [{"amplitude": -1.0}, {"shift_gain": math.nan}, {"block_speed": 1.0},
                                    {"amplitude": 100.0, "rounding": 0.1}])
def test_invalid_settings_are_refused(change):
    controller = FixedRocking(RIG)
    before = controller.settings
    with pytest.raises(InputError, match=next(iter(change)) + "|rounding"):
        controller.configure(dataclasses.replace(before, **change))
    assert controller.settings is before


def test_settings_have_unit_range_and_description():
    for field in dataclasses.fields(FixedRockingSettings):
        limits = field.metadata["limits"]
        assert limits.unit and limits.description and limits.low < limits.high
        assert limits.low <= field.default <= limits.high


def test_settings_suit_a_slow_top_drive():
    slow = SimpleNamespace(**{**vars(RIG), "top_drive": SimpleNamespace(max_acceleration=6.0)})
    assert settings_for(RIG).rounding == 0.25
    assert FixedRocking(slow).settings.rounding > 0.5
