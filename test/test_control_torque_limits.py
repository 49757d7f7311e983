"""Torque limits of the connections, on the true torque of the pipe, with effects unknown to the controller."""

import dataclasses
import math

import numpy as np
import pytest

from slider_drilling.control.interlocks.motor_stall import StallGuard
from slider_drilling.control.interlocks.slide_interlocks import Interlocks
from slider_drilling.control.interlocks.torque_prediction import Stroke
from slider_drilling.effects import effects_with
from slider_drilling.slide_scenarios import SCENARIOS
from slider_drilling.slide_scenarios.contenders import UNDER_TEST, build_contender
from slider_drilling.slide_scenarios.faulty_rig import FaultyRig

MAKE_UP, BACK_OFF = 25e3, 15e3
SLIDES = {scenario.name: scenario for scenario in SCENARIOS}
# Limits that this well's strokes meet again and again.
TIGHT = dataclasses.replace(SLIDES["hold, 2.6 km"], friction_ratio=1.1, make_up_limit=4.6e3, back_off_limit=2.8e3)


def pipe_torque(scenario, seconds):
    """N m, to the right, that the uppermost pipe takes after each sample; the controller."""
    rig, controller = FaultyRig(scenario, seed=0, elements=60), build_contender(UNDER_TEST, scenario)
    measurements, torque = rig.rig.measurements, []
    for _ in range(round(seconds / rig.rig.interval)):
        measurements = rig.step(controller.step(measurements))
        torque.append(rig.rig.profile().torque[0])
    return np.array(torque), controller


@pytest.mark.parametrize(
    "effect",
    [
        {},
        {"static_aging": {"growth": 0.6}},
        {"stribeck": {"drop": 0.6}},
        {"torque_sensor_lag": {"lag": 0.8}},
        {"torque_at_motor": {"inertia": 400.0, "friction": 100.0}},
    ],
    ids=lambda effect: "+".join(effect) or "none",
)
def test_pipe_torque_stays_within_limits(effect):
    torque, controller = pipe_torque(dataclasses.replace(TIGHT, effects=effects_with(**effect)), 90.0)
    assert np.max(torque) <= TIGHT.make_up_limit
    assert -np.min(torque) <= TIGHT.back_off_limit
    # The limits are not kept by not rocking.
    assert np.max(torque) > 0.6 * TIGHT.make_up_limit and -np.min(torque) > 0.6 * TIGHT.back_off_limit
    if "torque_sensor_lag" not in effect:
        limits = next(status for status in controller.status() if status.name == "torque_limits")
        assert int(dict(limits.values)["strokes_cut_short"]) > 3


def interlocks():
    return Interlocks(MAKE_UP, BACK_OFF, StallGuard(1e7, 1e6), 1.0)


def first_turn(torque_from_below, stroke, noise=0.0):
    """s after which a stroke is ended on what arrives from below, a function of time (s)."""
    limits, random = interlocks(), np.random.default_rng(0)
    for k in range(1, 600):
        if limits.must_reverse(stroke.side * (torque_from_below(0.1 * k) + random.normal(0.0, noise)), stroke, 0.1):
            return 0.1 * k
    return math.inf


STROKE = Stroke(side=1.0, speed=10.0, acceleration=16.0, impedance=300.0, delay=0.2)


@pytest.mark.parametrize(("side", "limit"), [(1.0, MAKE_UP), (-1.0, BACK_OFF)])
@pytest.mark.parametrize("rate", [1e3, 3e3, 8e3])
def test_stroke_ends_in_time_for_rising_torque(side, limit, rate):
    """What the pipe takes from then on: what arrives goes on rising while the drive brakes. The delay holds a sample's
    wait, within which the stroke should have been ended."""
    stroke = dataclasses.replace(STROKE, side=side)
    turned = first_turn(lambda time: rate * time, stroke)
    braked = stroke.delay - 0.1
    time = np.linspace(0.0, braked + stroke.speed / stroke.acceleration, 200)
    speed = np.clip(stroke.speed - stroke.acceleration * (time - braked), 0.0, stroke.speed)
    peak = np.max(rate * (turned + time) + stroke.impedance * speed)
    assert 0.95 * limit - 0.1 * rate < peak <= limit + 1e-6


def test_speed_delay_and_noise_end_stroke_earlier():
    def ended(noise=0.0, **changed):
        return first_turn(lambda time: 2e3 * time, dataclasses.replace(STROKE, **changed), noise)

    assert ended(speed=12.0) < ended() < ended(speed=5.0)
    assert ended(delay=1.0) == pytest.approx(ended() - 0.8, abs=0.11)
    assert ended(noise=500.0) < ended()


def test_steady_torque_below_limit_ends_no_stroke():
    steady = MAKE_UP - STROKE.impedance * STROKE.speed - 1e3
    assert first_turn(lambda time: steady, STROKE, noise=100.0) == math.inf
    assert first_turn(lambda time: math.nan, STROKE) == math.inf
