"""One motion from a position and a speed that do not quite agree."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import RigLog
from slider_drilling.log.series import JointSeries
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.log_inputs.fuse_position_and_speed import fuse_position_and_speed, smooth_motion
from slider_drilling.rig import load_rig

TIME = 0.1 * np.arange(1200)


def rocked(period=17.0, fastest=2.1, steepest=3.0):
    """Angle and speed of a drive that rocks evenly, speeding up as fast as it may, exactly."""
    fine = np.arange(0.0, TIME[-1] + 0.0005, 0.001)
    ramp = np.clip(steepest * (fine % (0.5 * period)) - fastest, -fastest, fastest)
    speed = np.where(fine % period < 0.5 * period, ramp, -ramp)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * 0.001)])
    return np.interp(TIME, fine, angle), np.interp(TIME, fine, speed)


def in_steps(values, step):
    return np.round(values / step) * step


@pytest.mark.parametrize("motion", [
    rocked(),
    (5.0 * np.sin(0.8 * TIME), 4.0 * np.cos(0.8 * TIME)),
    (2.0 * TIME, np.full(TIME.size, 2.0)),
    (np.zeros(TIME.size), np.zeros(TIME.size)),
])  # fmt: skip
def test_agreeing_measurements_are_unchanged(motion):
    angle, speed = fuse_position_and_speed(TIME, *motion)
    assert angle is motion[0] and speed is motion[1]


@pytest.mark.parametrize(("degrees", "rpm"), [(2.0, 0.1), (2.0, 1.0), (1.0, 1.0), (0.35, 1.0)])
def test_coarse_encoder_follows_the_drive(degrees, rpm):
    """What drives a string is how fast its end turns: the steps of an angle are not in it, nor is its lag."""
    true_angle, true_speed = rocked()
    angle = in_steps(true_angle, np.radians(degrees))
    speed = in_steps(true_speed, rpm * 2.0 * np.pi / 60.0)
    found, turning = fuse_position_and_speed(TIME, angle, speed)
    assert np.std(found - true_angle) < 0.85 * np.std(angle - true_angle)
    assert np.max(np.abs(found - true_angle)) < 1.2 * np.radians(degrees)

    def between(angle, speed):
        """Its speed half way between two samples, of the cubic that drives the plant."""
        return 1.5 * np.diff(angle) / 0.1 - 0.25 * (speed[1:] + speed[:-1])

    exact = between(true_angle, true_speed)
    off = np.std(between(found, turning) - exact)
    assert off < 0.6 * np.std(between(angle, speed) - exact)
    assert off < 0.03


def test_gap_is_no_disagreement():
    angle, speed = rocked()
    kept = np.r_[0:400, 431:1200]
    found = fuse_position_and_speed(TIME[kept], angle[kept], speed[kept])
    assert found[0] is not None and np.array_equal(found[0], angle[kept]) and np.array_equal(found[1], speed[kept])


def test_fused_motion_minimises_the_squares():
    """Against the normal equations, dense, with the inverse covariance of a Wiener process's step."""
    noise = np.random.default_rng(4)
    step, spread = noise.uniform(0.05, 0.3, 29), noise.uniform(0.1, 2.0, 29)
    position, speed = noise.normal(size=30), noise.normal(size=30)
    sigmas = 0.3, 0.7
    found = smooth_motion(step, position, speed, sigmas, spread)
    normal, right = np.diag(np.tile((sigmas[0] ** -2.0, sigmas[1] ** -2.0), 30)), np.zeros(60)
    right[0::2], right[1::2] = position / sigmas[0] ** 2, speed / sigmas[1] ** 2
    for k, (h, q) in enumerate(zip(step, spread, strict=True)):
        moved = np.zeros((2, 60))
        moved[0, [2 * k, 2 * k + 1, 2 * k + 2]] = -1.0, -h, 1.0
        moved[1, [2 * k + 1, 2 * k + 3]] = -1.0, 1.0
        covariance = q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]])
        normal += moved.T @ np.linalg.solve(covariance, moved)
    dense = np.linalg.solve(normal, right)
    assert found[0] == pytest.approx(dense[0::2], rel=1e-8) and found[1] == pytest.approx(dense[1::2], rel=1e-8)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10000), st.integers(1, 80), *[st.sampled_from([0.0, 1e-3, 0.3, 5.0])] * 2)
def test_fused_motion_is_always_finite(seed, count, angle_step, speed_step):
    noise = np.random.default_rng(seed)
    time = np.cumsum(noise.choice([noise.choice([1e-4, 0.05]), 0.1, 0.1, 3.0], size=count))
    angle, speed = 10.0 * noise.normal(size=count), noise.normal(size=count) * noise.choice([0.0, 1e-9, 1.0, 1e6])
    if angle_step > 0.0:
        angle = in_steps(angle, angle_step)
    if speed_step > 0.0:
        speed = in_steps(speed, speed_step)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = fuse_position_and_speed(time, angle, speed)
    assert all(np.isfinite(one).all() and one.shape == (count,) for one in found)


def test_replay_states_the_fused_motion():
    angle, speed = rocked()
    rig = load_rig(installed_file("config/rig.example.yaml"))
    nothing = np.full(TIME.size, np.nan)

    def assumed(angle):
        drive = JointSeries(TIME, TIME, angle, speed, nothing)
        return [str(text) for text in commands_from_log(RigLog("run.mcap", 0, top_drive=drive), rig).assumptions]

    (said,) = (sentence for sentence in assumed(in_steps(angle, 0.03)) if "agree" in sentence)
    assert "the top drive's angle and its speed disagree" in said and "rad and" in said
    assert not any("agree" in sentence for sentence in assumed(angle))
