"""How hard the controller pulls, and what it takes a torque reading for."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.control import SlideController, SlideSettings
from slider_drilling.control.estimation.cycle_average import CycleAverage
from slider_drilling.control.estimation.string_kalman_filter import StringKalmanFilter
from slider_drilling.control.estimation.tool_face_estimator import EstimatorNoise, ToolFaceEstimator
from slider_drilling.control.estimation.torque_sensor_model import TorqueSensorModel
from slider_drilling.control.interface import MwdSample
from slider_drilling.control.top_drive.centre_lead import ToolFaceResponse, centre_lead, stable_gain
from slider_drilling.rig import load_rig

CONFIG = Path(__file__).resolve().parents[1] / "config"
LOOSE = ToolFaceResponse(
    response_time=60.0, rocking_period=8.0, mwd_delay=18.0, tool_face_sigma=0.0, breakover_amplitude=24.0)


def turns_too_far(gain, answer):
    """Whether the toolface, following what pulls late by a cycle and a half, passes its target by more than half."""
    step, late = 0.1, round(1.5 * answer.rocking_period / 0.1)
    off = [1.0] * (late + 1)
    for _ in range(6000):
        off.append(off[-1] - step * (1.0 + gain) * off[-1 - late] / answer.response_time)
    return min(off) < -0.5


@pytest.mark.parametrize("response_time", [8.0, 20.0, 60.0, 300.0])
def test_gain_is_what_a_late_loop_bears(response_time):
    answer = dataclasses.replace(LOOSE, response_time=response_time)
    gain = centre_lead(0.1, 3.0, 5.0, answer) / 0.1
    assert 0.5 <= gain < 3.001
    # Three would have gone round in a string that answers within 20 s; what is left does not.
    assert turns_too_far(3.0, answer) == (response_time <= 20.0)
    assert not turns_too_far(gain, answer) or gain == 0.5


def test_a_held_string_gets_the_whole_gain_and_slow_mwd_less():
    assert stable_gain(ToolFaceResponse(300.0, 8.0, 18.0, 0.0, 24.0)) > 3.0
    assert stable_gain(ToolFaceResponse(60.0, 8.0, 36.0, 0.0, 24.0)) < stable_gain(LOOSE)


def test_no_lead_breaks_the_string_free():
    assert centre_lead(math.pi, 3.0, 5.0, LOOSE) == 5.0
    short = ToolFaceResponse(60.0, 6.0, 18.0, 0.0, breakover_amplitude=5.0)
    assert centre_lead(-math.pi, 3.0, 5.0, short) == pytest.approx(-1.5)


def test_an_angle_that_may_be_any_is_worth_no_pull():
    sure, unsure = (centre_lead(1.0, 1.0, 5.0, dataclasses.replace(LOOSE, tool_face_sigma=sigma))
                    for sigma in (0.05, 3.0))
    assert sure == pytest.approx(1.0, abs=0.01)
    assert unsure < 0.02


IMPEDANCE = 300.0


def strokes(inertia, lag=0.0, friction=5e3, noise=150.0, seconds=60.0):
    """Speed and torque at 10 Hz of a drive that rocks by 5 rad/s and is turned around at 16 rad/s2; torque of the pipe
    and as read at the motor by a sensor that lags."""
    random, speed, side, twist, lagged = np.random.default_rng(1), 0.0, 1.0, 0.0, 0.0
    for k in range(round(seconds * 10)):
        if k % 40 == 20:
            side = -side
        acceleration = np.clip(5.0 * side - speed, -1.6, 1.6) / 0.1
        for _ in range(100):
            speed += 1e-3 * acceleration
            twist = np.clip(twist + 1e-3 * speed * 300.0, -friction, friction)
            read = twist + IMPEDANCE * speed + inertia * acceleration
            lagged = read if lag == 0.0 else lagged + 1e-3 / lag * (read - lagged)
        yield speed, twist + IMPEDANCE * speed, lagged + random.normal(0.0, noise)


@pytest.mark.parametrize(("inertia", "lag"), [(0.0, 0.0), (300.0, 0.0), (1500.0, 0.0), (1500.0, 0.05)])
def test_what_speeds_the_drive_up_is_no_torque_of_the_pipe(inertia, lag):
    reading = TorqueSensorModel(IMPEDANCE, 150.0, 0.1)
    off, read = [], []
    for speed, pipe, torque in strokes(inertia, lag):
        off.append(reading.pipe_torque(speed, torque, 0.1) - pipe)
        read.append(torque - pipe)
    assert reading.inertia == pytest.approx(inertia, abs=25.0)
    assert np.max(np.abs(off[200:])) < 1e3
    assert inertia == 0.0 or np.max(np.abs(read[200:])) > 12.0 * inertia


@pytest.mark.parametrize("lag", [0.0, 0.4, 0.8])
def test_a_torque_that_comes_late_is_known_by_the_drives_own_changes_of_speed(lag):
    reading = TorqueSensorModel(IMPEDANCE, 150.0, 0.1)
    for speed, _, torque in strokes(0.0, lag):
        reading.pipe_torque(speed, torque, 0.1)
    assert reading.inertia == 0.0
    assert (reading.lag == pytest.approx(0.0, abs=0.03)) if lag == 0.0 else (0.75 * lag < reading.lag < 2.0 * lag)


def test_a_torque_that_is_missing_stays_so_and_teaches_nothing():
    reading = TorqueSensorModel(IMPEDANCE, 150.0, 0.1)
    before = reading.lag
    for speed, _, _ in strokes(0.0, seconds=20.0):
        assert math.isnan(reading.pipe_torque(speed, math.nan, 0.1))
    assert (reading.inertia, reading.lag) == (0.0, before)
    assert reading.pipe_torque(1.0, 500.0, 0.0) == 500.0
    for speed in (1e30, -1e30, math.inf, math.nan, 0.0):
        assert reading.pipe_torque(speed, 500.0, 0.1) == 500.0
        assert reading.torque_from_below(500.0) == 500.0 and reading.speed == 0.0


def test_response_time_stays_within_what_strings_do():
    """A toolface that leaps about must not teach that the string answers at once."""
    string = StringKalmanFilter(0.0042, 60.0)
    string.reset_tool_face(0.0, 0.0, 0.01)
    random = np.random.default_rng(2)
    for _ in range(300):
        string.advance(6.0, 1500.0, 500.0, 1.0, 0.01, 0.003)
        string.update_with_mwd(float(random.normal(0.0, 1.5)), math.nan, 0.003, 1.0)
    assert 20.0 <= string.estimate.response_time <= 181.0


def followed(every, seconds=120.0):
    """Degrees that the estimate of a toolface at rest swings by, where the bit swings by ten: read every so many s."""
    noise = EstimatorNoise(math.radians(3.0), 150.0, 0.1, 0.1, 0.3, math.radians(0.6), math.radians(0.15))
    estimator, samples, held = ToolFaceEstimator(0.0042, 60.0, noise), round(every / 0.1), []
    for k in range(1, round(seconds * 10)):
        time = 0.1 * k
        if k % 40 == 0:
            estimator.update_with_cycle(time, CycleAverage(0.0, 0.0, 0.0, 8.0), 0.75, 0.0)
        estimator.advance(time)
        if k % samples == 0:
            read = math.radians(10.0) * math.sin(2.0 * math.pi * time / 8.0)
            estimator.update_with_mwd(MwdSample(time, time, read), 0.0)
        held.append(estimator.tool_face)
    return math.degrees(np.max(np.abs(held[-80:])))


def test_samples_within_half_a_cycle_are_worth_one():
    """At 10 Hz what rocking leaves at the bit is the same in forty samples: it must not be taken for the mean."""
    assert followed(0.1) < 5.0


def test_swing_is_found_in_samples_at_ten_hertz():
    filter_ = StringKalmanFilter(0.0042, 60.0)
    for k in range(600):
        phase = 2.0 * math.pi * 0.1 * k / 8.0
        filter_.advance(0.1, 0.0, 0.0, 1.0, 0.0, 0.0)
        read = math.radians(5.0) * math.sin(phase)
        filter_.update_with_mwd(read - filter_.mean[0] - filter_.swing_at(phase), phase, math.radians(1.5) ** 2, 1.0)
    assert filter_.swing == pytest.approx(math.radians(5.0), rel=0.05)


def doubt(noise, until, every, reading):
    """One standard deviation of the toolface, deg, after `until` steps of 0.5 s with a stroke every 8 s and every
    `every` steps a sample of `noise` (deg), which is `reading` of the step (deg), or lost where that is None."""
    noises = EstimatorNoise(math.radians(noise), 150.0, 0.1, 0.1, 0.3, math.radians(0.6), math.radians(0.15))
    estimator = ToolFaceEstimator(0.0042, 60.0, noises)
    for k in range(1, until):
        time = 0.5 * k
        if k % 16 == 0:
            estimator.update_with_cycle(time, CycleAverage(0.0, 0.0, 0.0, 8.0), 0.75, 0.0)
        estimator.advance(time)
        if k % every == 0 and (read := reading(k)) is not None:
            estimator.update_with_mwd(MwdSample(time, time, math.radians(read)), 0.0)
    return math.degrees(estimator.sigma)


def surprised(jump):
    """The doubt after samples that leap by `jump` (deg) to and fro."""
    return doubt(3.0, 601, 24, lambda k: jump if k % 48 == 0 else -jump)


def test_samples_that_surprise_widen_the_doubt_of_the_tool_face():
    assert surprised(2.0) == pytest.approx(surprised(0.0), rel=0.02)
    assert surprised(12.0) > 1.3 * surprised(2.0)


def doubt_after(third):
    """The doubt 29 s after the fifth sample of an MWD of 30 s, which is `third` (deg), or lost where that is None."""
    return doubt(2.0, 359, 60, lambda k: third if k == 300 else 0.0)


def test_a_wrong_sample_does_not_open_the_door_to_the_next_one():
    assert doubt_after(140.0) == pytest.approx(doubt_after(None), rel=0.02)
    assert doubt_after(1.0) < 0.95 * doubt_after(None)


def thrown_by(second, first):
    """Degrees by which a sample that is `second` (deg) off moves a toolface at rest that was lost for two minutes, one
    MWD period after a sample that is `first` (deg) off, or lost where that is None."""
    estimator = ToolFaceEstimator(0.0042, 60.0, EstimatorNoise(
        math.radians(2.0), 150.0, 0.1, 0.1, 0.3, math.radians(6.0), math.radians(0.15)))
    for k in range(1, 302):
        time = 0.5 * k
        if k % 16 == 0:
            estimator.update_with_cycle(time, CycleAverage(0.0, 0.0, 0.0, 8.0), 0.75, 0.0)
        estimator.advance(time)
        read = {40: 0.0, 60: 0.0, 90: 0.0, 240: first, 300: second}.get(k)
        if read is not None:
            estimator.update_with_mwd(MwdSample(time, time, math.radians(read)), 0.0)
    return abs(math.degrees(estimator.tool_face))


def test_a_sample_after_a_wrong_one_is_believed_less_unless_it_agrees_with_the_string():
    alone, after = thrown_by(-65.0, None), thrown_by(-65.0, 140.0)
    assert alone > 30.0 and after < 0.5 * alone
    assert thrown_by(-10.0, 140.0) == pytest.approx(thrown_by(-10.0, None), abs=1.5)


def test_a_sample_that_may_be_wrong_moves_the_tool_face_by_as_much_as_it_is_likely_and_leaves_the_doubt():
    outcome = {}
    for genuine in (1.0, 0.5, 0.0):
        string = StringKalmanFilter(0.0042, 60.0)
        string.reset_tool_face(0.0, 0.0, 1.0)
        outcome[genuine] = (string.update_with_mwd(2.0, math.nan, 1e-4, genuine), string.tool_face_sigma)
    assert outcome[1.0] == pytest.approx((2.0, 0.01), rel=1e-3)
    assert outcome[0.5] == pytest.approx((1.0, math.sqrt(0.5 * 1.0 + 0.25 * 2.0**2)), rel=1e-3)
    assert outcome[0.0] == (0.0, 1.0)


@pytest.mark.parametrize(("rig", "seconds"), [("rig.short.yaml", 60.0), ("rig.example.yaml", 60.0),
                                              ("rig.long.yaml", 60.0 * (5.6 / 4.0) ** 2)])
def test_lag_of_the_tool_face_goes_with_the_square_of_the_length_of_a_long_string(rig, seconds):
    own = SlideController(load_rig(CONFIG / rig))
    assert status_value(own, "string", "response_time_s") == pytest.approx(seconds, rel=0.1)
    told = SlideController(load_rig(CONFIG / rig), SlideSettings(response_time=77.0))
    assert status_value(told, "string", "response_time_s") == 77.0


def status_value(controller, name, key):
    return float(next(dict(one.values)[key] for one in controller.status() if one.name == name))


def test_pipe_that_drags_raises_no_gain(monkeypatch):
    own = SlideController(load_rig(CONFIG / "rig.short.yaml"))
    monkeypatch.setattr(SlideController, "error", 0.2)
    monkeypatch.setattr(ToolFaceEstimator, "sigma", 0.05)
    free = own._lead()
    own._estimator.mobility = 0.1
    assert own._lead() == free != 0.0
