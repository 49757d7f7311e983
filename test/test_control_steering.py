"""Lead of the centre, torque sensor and response of the toolface filter."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.control import SlideController, SlideSettings
from slider_drilling.control.estimation.cycle_average import CycleAverage
from slider_drilling.control.estimation.slide_state import SlideState
from slider_drilling.control.estimation.string_kalman_filter import StringKalmanFilter
from slider_drilling.control.estimation.tool_face_estimator import EstimatorNoise, ToolFaceEstimator
from slider_drilling.control.estimation.torque_sensor_model import TorqueSensorModel
from slider_drilling.control.interface import MwdSample
from slider_drilling.control.top_drive.amplitude_control import AmplitudeControl
from slider_drilling.control.top_drive.centre_control import CentreControl
from slider_drilling.control.top_drive.centre_lead import ToolFaceResponse, centre_lead, stable_gain
from slider_drilling.rig import load_rig

CONFIG = Path(__file__).resolve().parents[1] / "config"
QUICK_STRING = ToolFaceResponse(
    response_time=60.0, rocking_period=8.0, mwd_delay=18.0, tool_face_sigma=0.0, breakover_amplitude=24.0)


def overshoots(gain, response):
    """Whether a toolface with a dead time of 1.5 cycles overshoots its target by more than half."""
    step, dead_time = 0.1, round(1.5 * response.rocking_period / 0.1)
    off = [1.0] * (dead_time + 1)
    for _ in range(6000):
        off.append(off[-1] - step * (1.0 + gain) * off[-1 - dead_time] / response.response_time)
    return min(off) < -0.5


@pytest.mark.parametrize("response_time", [8.0, 20.0, 60.0, 300.0])
def test_lead_gain_is_stable_with_dead_time(response_time):
    response = dataclasses.replace(QUICK_STRING, response_time=response_time)
    gain = centre_lead(0.1, 3.0, 5.0, response) / 0.1
    assert 0.5 <= gain < 3.001
    # A gain of 3 is unstable where the string responds within 20 s; the reduced gain is not.
    assert overshoots(3.0, response) == (response_time <= 20.0)
    assert not overshoots(gain, response) or gain == 0.5


def test_gain_grows_with_response_time_not_mwd_delay():
    assert stable_gain(ToolFaceResponse(300.0, 8.0, 18.0, 0.0, 24.0)) > 3.0
    assert stable_gain(ToolFaceResponse(60.0, 8.0, 36.0, 0.0, 24.0)) < stable_gain(QUICK_STRING)


def test_lead_stays_below_breakover_amplitude():
    assert centre_lead(math.pi, 3.0, 5.0, QUICK_STRING) == 5.0
    short = ToolFaceResponse(60.0, 6.0, 18.0, 0.0, breakover_amplitude=5.0)
    assert centre_lead(-math.pi, 3.0, 5.0, short) == pytest.approx(-1.5)


def test_unknown_toolface_gives_no_lead():
    sure, unsure = (centre_lead(1.0, 1.0, 5.0, dataclasses.replace(QUICK_STRING, tool_face_sigma=sigma))
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
def test_drive_inertia_is_removed_from_torque(inertia, lag):
    reading = TorqueSensorModel(IMPEDANCE, 150.0, 0.1)
    off, read = [], []
    for speed, pipe, torque in strokes(inertia, lag):
        off.append(reading.pipe_torque(speed, torque, 0.1) - pipe)
        read.append(torque - pipe)
    assert reading.inertia == pytest.approx(inertia, abs=25.0)
    assert np.max(np.abs(off[200:])) < 1e3
    assert inertia == 0.0 or np.max(np.abs(read[200:])) > 12.0 * inertia


@pytest.mark.parametrize("lag", [0.0, 0.4, 0.8])
def test_sensor_lag_is_found_from_speed_changes(lag):
    reading = TorqueSensorModel(IMPEDANCE, 150.0, 0.1)
    for speed, _, torque in strokes(0.0, lag):
        reading.pipe_torque(speed, torque, 0.1)
    assert reading.inertia == 0.0
    assert (reading.lag == pytest.approx(0.0, abs=0.03)) if lag == 0.0 else (0.75 * lag < reading.lag < 2.0 * lag)


def test_missing_torque_changes_no_estimate():
    reading = TorqueSensorModel(IMPEDANCE, 150.0, 0.1)
    before = reading.lag
    for speed, _, _ in strokes(0.0, seconds=20.0):
        assert math.isnan(reading.pipe_torque(speed, math.nan, 0.1))
    assert (reading.inertia, reading.lag) == (0.0, before)
    assert reading.pipe_torque(1.0, 500.0, 0.0) == 500.0
    for speed in (1e30, -1e30, math.inf, math.nan, 0.0):
        assert reading.pipe_torque(speed, 500.0, 0.1) == 500.0
        assert reading.torque_from_below(500.0) == 500.0 and reading.speed == 0.0


def test_response_time_stays_within_bounds():
    """A toolface that jumps about must not make the string look immediate."""
    string = StringKalmanFilter(0.0042, 60.0)
    string.reset_tool_face(0.0, 0.0, 0.01)
    random = np.random.default_rng(2)
    for _ in range(300):
        string.advance(6.0, 1500.0, 500.0, 1.0, 0.01, 0.003)
        string.update_with_mwd(float(random.normal(0.0, 1.5)), math.nan, 0.003, 1.0)
    assert 20.0 <= string.estimate.response_time <= 181.0


def swing_of_estimate(every, seconds=120.0):
    """Swing of the estimate (deg) where the bit swings by 10 deg about a toolface at rest, read every `every` s."""
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


def test_samples_within_half_cycle_count_once():
    """At 10 Hz forty samples show the same side of the swing."""
    assert swing_of_estimate(0.1) < 5.0


def test_swing_is_found_at_ten_hertz():
    filter_ = StringKalmanFilter(0.0042, 60.0)
    for k in range(600):
        phase = 2.0 * math.pi * 0.1 * k / 8.0
        filter_.advance(0.1, 0.0, 0.0, 1.0, 0.0, 0.0)
        read = math.radians(5.0) * math.sin(phase)
        filter_.update_with_mwd(read - filter_.mean[0] - filter_.swing_at(phase), phase, math.radians(1.5) ** 2, 1.0)
    assert filter_.swing == pytest.approx(math.radians(5.0), rel=0.05)


def sigma_after(noise, until, every, reading):
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


def sigma_with_jumps(jump):
    """Standard deviation (deg) after samples that alternate by `jump` (deg)."""
    return sigma_after(3.0, 601, 24, lambda k: jump if k % 48 == 0 else -jump)


def test_large_innovations_widen_toolface_sigma():
    assert sigma_with_jumps(2.0) == pytest.approx(sigma_with_jumps(0.0), rel=0.02)
    assert sigma_with_jumps(12.0) > 1.3 * sigma_with_jumps(2.0)


def sigma_after_sample(third):
    """Standard deviation (deg) 29 s after the fifth sample of MWD every 30 s: `third` (deg), lost where None."""
    return sigma_after(2.0, 359, 60, lambda k: third if k == 300 else 0.0)


def test_outlier_does_not_widen_toolface_sigma():
    assert sigma_after_sample(140.0) == pytest.approx(sigma_after_sample(None), rel=0.02)
    assert sigma_after_sample(1.0) < 0.95 * sigma_after_sample(None)


def moved_by(second, first):
    """Move (deg) of a resting toolface, without MWD for two minutes, by a sample that is `second` (deg) off.

    One MWD period before it comes a sample that is `first` (deg) off, or none.
    """
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


def test_sample_after_outlier_counts_less():
    alone, after = moved_by(-65.0, None), moved_by(-65.0, 140.0)
    assert alone > 30.0 and after < 0.5 * alone
    assert moved_by(-10.0, 140.0) == pytest.approx(moved_by(-10.0, None), abs=1.5)


def test_doubtful_sample_moves_toolface_by_its_probability():
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
def test_response_time_grows_with_squared_length(rig, seconds):
    automatic = SlideController(load_rig(CONFIG / rig))
    assert status_value(automatic, "string", "response_time_s") == pytest.approx(seconds, rel=0.1)
    given = SlideController(load_rig(CONFIG / rig), SlideSettings(response_time=77.0))
    assert status_value(given, "string", "response_time_s") == 77.0


def status_value(controller, name, key):
    return float(next(dict(status.values)[key] for status in controller.status() if status.name == name))


def test_mobility_does_not_change_lead(monkeypatch):
    rig, settings = load_rig(CONFIG / "rig.short.yaml"), SlideSettings()
    amplitude, centre = AmplitudeControl(rig, settings, 8e4), CentreControl(rig, settings)
    estimator = SlideState(rig, settings, amplitude.model).tool_face
    monkeypatch.setattr(ToolFaceEstimator, "sigma", 0.05)
    lead = centre.lead(0.2, estimator, amplitude)
    estimator.mobility = 0.1
    assert centre.lead(0.2, estimator, amplitude) == lead != 0.0
