"""SlideController: any stream of measurements, and each interlock."""

import dataclasses
import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slider_drilling.control import Level, SlideController, SlideSettings
from slider_drilling.control.controller_loader import DEFAULT_CONTROLLER, load_controller
from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.control.interface import Measurements, MwdSample
from slider_drilling.control.tool_face_target import target_in_rad, target_refusal
from slider_drilling.errors import InputError
from slider_drilling.rig import load_rig

RIG = load_rig(Path(__file__).resolve().parents[1] / "config" / "rig.example.yaml")
PERIOD = 0.1
NORMAL = {"top_drive_angle": 0.0, "top_drive_speed": 0.0, "surface_torque": 500.0, "block_position": 0.0,
          "block_speed": 0.0, "hook_load": 6e5, "standpipe_pressure": 1.8e7, "pump_speed": 12.3}
CHANNELS = tuple(NORMAL)
TORSION = 1.0 / TorqueAndDrag(RIG, 0.235, 0.0).compliance   # N m/rad, of the string with its bit held


def sample(time, mwd=(), **changed):
    return Measurements(time=time, mwd=tuple(mwd), **{**NORMAL, **changed})


def noisy(k, readings, stuck):
    """Readings that differ from one sample to the next, as those of a real sensor do."""
    sensors = {"surface_torque", "hook_load", "standpipe_pressure"} - {stuck}
    read = {**NORMAL, **readings}
    return {name: value + (-1.0) ** k if name in sensors else value for name, value in read.items()}


def follow(controller, seconds, start=0.0, mwd_every=12.0, tool_face=0.0, stuck="", **changed):
    """Commands of a controller whose top drive follows immediately, on a string with its bit held."""
    commands = []
    angle, block = vars(controller).get("followed", (0.0, 0.0))
    for k in range(1, round(seconds / PERIOD) + 1):
        time = start + k * PERIOD
        due = mwd_every and k % round(mwd_every / PERIOD) == 0
        mwd = (MwdSample(time - 6.0, time, tool_face),) if due else ()
        string = {"surface_torque": TORSION * (angle - tool_face), "top_drive_angle": angle, "block_position": block}
        command = controller.step(sample(time, mwd, **noisy(k, {**string, **changed}, stuck)))
        angle, block = command.top_drive_angle, block + PERIOD * command.block_speed
        commands.append(command)
    controller.followed = angle, block
    return commands


def level(controller, name):
    return next(status.level for status in controller.status() if status.name == name)


BAD = st.sampled_from([math.nan, math.inf, -math.inf, 0.0, 1e30, -1e30])
ANGLES = st.floats(allow_nan=True, allow_infinity=True)
EVENTS = st.one_of(
    st.just(("tick",)),
    st.tuples(st.just("lost"), st.sampled_from(CHANNELS), BAD, st.integers(1, 150)),
    st.tuples(st.just("time"), st.sampled_from([0.0, -0.1, -5.0, -1e4, 0.05, 1.0, 30.0, 1e4, math.nan])),
    st.tuples(st.just("mwd"), ANGLES, st.sampled_from([0.0, 6.0, 80.0, 1e4, -50.0, math.nan])),
    st.tuples(st.just("value"), st.sampled_from(CHANNELS), st.floats(-1e8, 1e8)),
    st.tuples(st.just("target"), st.floats(-10.0, 10.0)),
)


@settings(max_examples=60)
@given(st.lists(st.tuples(EVENTS, st.integers(1, 80)), min_size=1, max_size=12))
def test_any_stream_gives_finite_continuous_commands(events):
    """Drop-outs, NaN, implausible values, a clock that stops, jumps or runs backwards, MWD of any kind."""
    s = SlideSettings()
    controller = SlideController(RIG, s)
    time, angle, lost, last = 0.0, 0.0, {}, None
    longest = 2.5 * PERIOD
    acceleration = max(s.rounding_acceleration, 0.0)
    for event, count in events:
        for k in range(count):
            changed, mwd, stamp = {"top_drive_angle": angle}, (), time + PERIOD
            if k == 0 and event[0] == "lost":
                lost[event[1]] = [event[2], event[3]]
            elif k == 0 and event[0] == "time":
                stamp = time + event[1]
            elif k == 0 and event[0] == "mwd":
                mwd = (MwdSample(time - event[2], time, event[1]),)
            elif k == 0 and event[0] == "value":
                changed[event[1]] = event[2]
            elif k == 0 and event[0] == "target":
                controller.tool_face_target = event[1]
            for name, (value, left) in list(lost.items()):
                changed[name] = value
                lost[name][1] = left - 1
                if left <= 1:
                    del lost[name]
            command = controller.step(sample(stamp, mwd, **changed))
            if math.isfinite(stamp):
                time = stamp
            assert all(math.isfinite(value) for value in dataclasses.astuple(command))
            assert abs(command.top_drive_speed) <= s.max_rocking_speed + 1e-9
            most = s.compensation_speed
            assert -s.pick_up_speed - most <= command.block_speed <= s.max_block_speed + most
            if last is not None:
                assert abs(command.top_drive_angle - last.top_drive_angle) <= s.max_rocking_speed * longest + 1e-9
                assert abs(command.top_drive_speed - last.top_drive_speed) <= acceleration * longest + 1e-9
            angle, last = command.top_drive_angle, command
        assert all(status.message for status in controller.status())


@pytest.mark.parametrize("channel", [name for name in CHANNELS if name not in ("top_drive_speed", "block_speed")])
def test_lost_channel_stops_lowering_then_rocking(channel):
    controller = SlideController(RIG)
    assert any(command.block_speed > 0.0 for command in follow(controller, 60.0))
    soon = follow(controller, 3.0, 60.0, **{channel: math.nan})
    assert soon[-1].block_speed == 0.0
    assert level(controller, channel) is Level.WARN
    later = follow(controller, 12.0, 63.0, **{channel: math.nan})
    assert later[-1].top_drive_speed == 0.0
    assert level(controller, channel) is Level.ERROR
    back = follow(controller, 10.0, 75.0)
    assert back[-1].block_speed > 0.0 and any(abs(command.top_drive_speed) > 0.5 for command in back)
    assert level(controller, channel) is Level.OK


@pytest.mark.parametrize("channel", ["surface_torque", "hook_load", "standpipe_pressure"])
def test_stuck_sensor_counts_as_lost(channel):
    controller = SlideController(RIG)
    follow(controller, 60.0)
    stuck = follow(controller, 30.0, 60.0, stuck=channel, **{channel: NORMAL[channel]})
    assert stuck[-1].block_speed == 0.0 and stuck[-1].top_drive_speed == 0.0
    message = next(status.message for status in controller.status() if status.name == channel)
    assert level(controller, channel) is Level.ERROR and "the same reading" in message
    assert follow(controller, 20.0, 90.0)[-1].block_speed > 0.0


def test_pump_at_another_speed_stops_lowering():
    controller = SlideController(RIG)
    follow(controller, 60.0)
    assert follow(controller, 15.0, 60.0, pump_speed=11.0, standpipe_pressure=1.8e7)[-1].block_speed == 0.0
    assert level(controller, "circulation") is Level.ERROR
    controller.configure(dataclasses.replace(controller.settings, pump_speed=11.0))
    follow(controller, 5.0, 75.0, pump_speed=11.0)
    assert level(controller, "circulation") is Level.OK


def test_pressure_far_below_rig_file_stops_lowering():
    controller = SlideController(RIG)
    assert follow(controller, 90.0, standpipe_pressure=0.8 * 1.8e7)[-1].block_speed == 0.0
    assert level(controller, "off_bottom_pressure") is Level.ERROR
    controller.configure(dataclasses.replace(controller.settings, off_bottom_pressure=0.8 * 1.8e7))
    assert follow(controller, 60.0, 90.0, standpipe_pressure=0.8 * 1.8e7)[-1].block_speed > 0.0


def test_another_friction_factor_on_bottom_tares_nothing():
    controller = SlideController(RIG)
    assert follow(controller, 90.0)[-1].block_speed > 0.0
    loaded = {"hook_load": 5e5, "standpipe_pressure": 1.9e7}
    follow(controller, 30.0, 90.0, **loaded)
    controller.configure(dataclasses.replace(controller.settings, friction_factor=0.3))
    follow(controller, 20.0, 120.0, **loaded)
    assert controller._amplitude.testing, "another friction factor repeats the breakover test"
    assert controller._block.drag.deficit(5e5) == pytest.approx(1e5, rel=0.01)


@pytest.mark.parametrize("build", [SlideController, lambda rig: load_controller(DEFAULT_CONTROLLER, rig)])
def test_slow_sensors_are_refused(build):
    slow = dataclasses.replace(RIG, sensors=dataclasses.replace(RIG.sensors, rate=1.0))
    with pytest.raises(InputError, match=r"sensors\.rate = 1 Hz: must be at least 5"):
        build(slow)


@pytest.mark.parametrize("degrees", [900.0, -181.0, math.nan, math.inf])
def test_target_beyond_half_a_turn_is_refused(degrees):
    assert target_refusal(degrees)
    with pytest.raises(InputError, match="--target"):
        target_in_rad(degrees, "--target")
    assert target_refusal(-180.0) is None and target_in_rad(90.0, "--target") == pytest.approx(0.5 * math.pi)


def test_refused_target_names_the_same_direction():
    assert target_refusal(290.0) == "290 deg: must be within -180 to 180; the same direction is -70"


def test_stopped_clock_stops_drive():
    controller = SlideController(RIG)
    follow(controller, 60.0)
    for _ in range(150):
        command = controller.step(sample(60.0))
    assert command.block_speed == 0.0
    assert level(controller, "clock") is Level.ERROR


def test_missing_mwd_stops_lowering():
    controller = SlideController(RIG)
    follow(controller, 60.0)
    commands = follow(controller, 160.0, 60.0, mwd_every=0.0)
    assert commands[0].block_speed > 0.0 and commands[-1].block_speed == 0.0
    assert level(controller, "mwd_tool_face") is Level.WARN


def test_stall_picks_up_and_resumes():
    controller = SlideController(RIG)
    follow(controller, 60.0)
    stalled = 1.8e7 + RIG.motor.max_pressure
    commands = follow(controller, 5.0, 60.0, standpipe_pressure=stalled)
    assert commands[-1].block_speed == -controller.settings.pick_up_speed
    assert level(controller, "motor_stall") is Level.ERROR
    commands = follow(controller, 40.0, 65.0)
    assert commands[-1].block_speed > 0.0
    assert level(controller, "motor_stall") is Level.OK


def test_slipping_block_is_lifted():
    controller = SlideController(RIG)
    follow(controller, 60.0)
    commands = [follow(controller, PERIOD, 60.0 + PERIOD * k, block_position=0.02 * k)[0] for k in range(1, 11)]
    assert commands[2].block_speed >= 0.0
    assert commands[-1].block_speed == -controller.settings.pick_up_speed
    assert level(controller, "draw_works") is Level.ERROR
    for k in range(1, 11):
        commands = follow(controller, PERIOD, 61.0 + PERIOD * k, block_position=0.2 - 0.02 * k)
    assert commands[-1].block_speed >= 0.0
    assert level(controller, "draw_works") is Level.OK


def test_lost_pressure_keeps_stall_state():
    controller = SlideController(RIG)
    follow(controller, 60.0)
    follow(controller, 5.0, 60.0, standpipe_pressure=1.8e7 + RIG.motor.max_pressure)
    commands = follow(controller, 30.0, 65.0, standpipe_pressure=math.nan)
    assert all(command.block_speed <= 0.0 for command in commands)
    assert level(controller, "motor_stall") is Level.ERROR


def test_pump_off_stops_lowering():
    controller = SlideController(RIG)
    follow(controller, 60.0)
    assert follow(controller, 3.0, 60.0, pump_speed=0.0, standpipe_pressure=0.0)[-1].block_speed == 0.0
    assert level(controller, "circulation") is Level.WARN


@pytest.mark.parametrize(("limits", "side"), [({"make_up_torque_limit": 2000.0}, 1.0),
                                              ({"back_off_torque_limit": 1500.0}, -1.0)])
def test_stroke_ends_before_torque_limit(limits, side):
    controller = SlideController(RIG, dataclasses.replace(SlideSettings(), **limits))
    torque = [TORSION * side * command.top_drive_angle for command in follow(controller, 60.0)]
    assert max(torque) <= next(iter(limits.values()))
    assert any("torque" in status.message for status in controller.status() if status.name == "torque_limits")


def test_tight_torque_limit_reduces_pressure():
    """Strokes are cut short, and the block slows down."""
    lowered = []
    for limit in (25e3, 1500.0):
        controller = SlideController(RIG, dataclasses.replace(SlideSettings(), make_up_torque_limit=limit))
        pressure = 1.8e7 + 1.2e6   # which the torque of the held string agrees with
        follow(controller, 240.0, standpipe_pressure=pressure)
        commands = follow(controller, 60.0, 240.0, standpipe_pressure=pressure)
        lowered.append(sum(command.block_speed for command in commands))
        status = next(status for status in controller.status() if status.name == "reach")
        assert (float(dict(status.values)["share_of_target_pressure"]) < 1.0) == (limit == 1500.0)
    assert lowered[1] < lowered[0]


def test_return_to_bottom_is_fast_then_slow():
    controller = SlideController(RIG)
    follow(controller, 90.0, standpipe_pressure=1.8e7 + 1.8e6)
    follow(controller, 12.0, 90.0, standpipe_pressure=1.8e7 + RIG.motor.max_pressure)
    lifted = follow(controller, 6.0, 102.0)
    assert lifted[-1].block_speed == pytest.approx(controller.settings.max_block_speed)
    near = follow(controller, 75.0, 108.0)
    assert 0.0 < near[-1].block_speed < 0.01
    assert abs(near[-1].top_drive_angle) < 20.0


@pytest.mark.parametrize(("tool_face_deg", "side"), [(-40.0, 1.0), (40.0, -1.0)])
def test_centre_moves_against_the_error(tool_face_deg, side):
    """A toolface left of its target moves the centre further right than a toolface on target."""
    centres = []
    for tool_face in (0.0, math.radians(tool_face_deg)):
        controller = SlideController(RIG, SlideSettings(feed_forward=0.0))
        follow(controller, 120.0, tool_face=tool_face)
        status = next(status for status in controller.status() if status.name == "tool_face")
        centres.append(float(dict(status.values)["centre_rad"]))
    assert side * (centres[1] - centres[0]) > 0.3


def test_toolface_left_of_target_delays_load():
    for tool_face, waits in ((math.radians(-40.0), True), (math.radians(40.0), False)):
        controller = SlideController(RIG)
        commands = follow(controller, 120.0, tool_face=tool_face)
        message = next(status.message for status in controller.status() if status.name == "reach")
        assert ("weight on bit waits" in message) == waits
        assert (commands[-1].block_speed <= 0.0) == waits


def test_pressure_feeds_forward_to_centre():
    centres = []
    for pressure in (1.8e7, 1.8e7 + 1e6):
        controller = SlideController(RIG)
        follow(controller, 60.0)
        commands = follow(controller, 24.0, 60.0, standpipe_pressure=pressure)
        angles = [command.top_drive_angle for command in commands[-160:]]
        centres.append(0.5 * (max(angles) + min(angles)))
    twist_share = 0.5 * RIG.motor.torque_per_pressure * 1e6 * 0.0042
    assert centres[1] - centres[0] > 0.5 * twist_share


def test_settings_change_without_jump():
    controller = SlideController(RIG)
    before = follow(controller, 60.0)[-1]
    controller.configure(dataclasses.replace(controller.settings, amplitude=5.0, period=30.0, max_rocking_speed=6.0))
    after = controller.step(sample(60.1, top_drive_angle=before.top_drive_angle))
    assert abs(after.top_drive_angle - before.top_drive_angle) <= 12.0 * PERIOD
    kept = controller.settings
    with pytest.raises(InputError, match="gain"):
        controller.configure(dataclasses.replace(kept, gain=math.nan))
    assert controller.settings is kept


def test_parking_comes_to_rest():
    controller = SlideController(RIG)
    follow(controller, 60.0)
    controller.configure(dataclasses.replace(controller.settings, rocking=0.0))
    commands = follow(controller, 60.0, 60.0)
    assert commands[-1].top_drive_speed == 0.0
    assert commands[-1].block_speed == 0.0
