"""Estimates of toolface and string, against closed forms."""

import math
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.control.estimation.calibrated_rig import calibrated_rig, with_worn_motor
from slider_drilling.control.estimation.circular_histogram import CircularHistogram
from slider_drilling.control.estimation.cycle_average import CycleAverage
from slider_drilling.control.estimation.string_kalman_filter import StringEstimate
from slider_drilling.control.estimation.tool_face_estimator import EstimatorNoise, ToolFaceEstimator
from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.control.interface import MwdSample
from slider_drilling.rig import dump_rig, load_rig, parse_rig

CONFIG = Path(__file__).resolve().parents[1] / "config"
RIG = load_rig(CONFIG / "rig.example.yaml")
NOISE = EstimatorNoise(math.radians(3.0), 150.0, 0.1, 0.1, 0.3, math.radians(0.6), math.radians(0.15))
S = 0.0042   # rad/(N m)


def test_uniform_side_force_gives_parabolic_reach(tmp_path):
    """Horizontal throughout: torque falls linearly, A = q s^2 / 2GJ."""
    text = (CONFIG / "rig.example.yaml").read_text()
    survey = text[text.index("    - [0.0, 0.0"):text.index("  hole_diameter")]
    flat = text.replace(survey, "    - [0.0, 90.0, 0.0]\n    - [4000.0, 90.0, 0.0]\n")
    flat = flat.replace("factor: 0.8", "factor: 1.0")
    flat = flat.replace("length: 60.0, outer_diameter: 0.165, inner_diameter: 0.0714",
                        "length: 60.0, outer_diameter: 0.127, inner_diameter: 0.1086")
    path = tmp_path / "flat.yaml"
    path.write_text(flat)
    rig = load_rig(path)
    belief = TorqueAndDrag(rig, 0.25, 0.0)
    area = math.pi / 4.0 * (0.127**2 - 0.1086**2)
    gradient = 0.25 * area * (7850.0 - 1200.0) * 9.81 * 0.127 / 2.0
    torsion = 7.92e10 * math.pi / 32.0 * (0.127**4 - 0.1086**4)
    for reach in (1000.0, 3000.0):
        amplitude = gradient * reach**2 / (2.0 * torsion)
        assert belief.reach(amplitude, 1.0) == pytest.approx(reach, abs=5.0)
        assert belief.breakover_torque(amplitude, 1.0) == pytest.approx(gradient * reach, rel=2e-3)
        assert belief.scale_from(amplitude, belief.breakover_torque(amplitude, 1.3)) == pytest.approx(1.3, rel=1e-3)
    zones = belief.zones(0.0, gradient * 500.0, 1.0)
    assert zones.reactive_from == pytest.approx(3500.0, abs=5.0)
    assert zones.static_length == pytest.approx(3500.0, abs=5.0)


def feed(estimator, twist, offset, until, samples):
    """Rocking of 8 s about a centre on target, on a string that the bit twists by `twist(t)`, its bend `offset` off."""
    for k in range(round(until / 0.5)):
        time = 0.5 * k
        estimator.advance(time)
        if time > 8.0 and time % 4.0 == 0.0:
            torque = twist(time - 4.0) / S
            estimator.update_with_cycle(time, CycleAverage(0.0, torque, torque, 8.0), 1.0, 0.0)
        if time in samples:
            angle = offset - twist(time - 6.0) if samples[time] is None else samples[time]
            estimator.update_with_mwd(MwdSample(time - 6.0, time, math.remainder(angle, 2.0 * math.pi)), 0.0)


def test_torque_shows_toolface_between_samples():
    """After four samples off bottom none come any more, and the reactive torque winds the string up by a turn."""
    estimator, x = slide(following=0.0, last_sample=54.0, duration=190.0)
    assert x < -2.0 * math.pi
    assert estimator.tool_face == pytest.approx(x, abs=2.0 * estimator.sigma)
    assert estimator.sigma < 1.5


def test_single_outlier_is_rejected_repeated_offset_accepted():
    every = dict.fromkeys(np.arange(18.0, 300.0, 12.0))
    estimator = ToolFaceEstimator(S, 60.0, NOISE)
    feed(estimator, lambda time: 0.0, 0.5, 300.0, every | {150.0: 3.0})
    assert estimator.rejections == 1
    assert estimator.tool_face == pytest.approx(0.5, abs=math.radians(1.0))
    feed(estimator := ToolFaceEstimator(S, 60.0, NOISE), lambda time: 0.0, 0.5, 300.0,
         every | dict.fromkeys(np.arange(150.0, 300.0, 12.0), 3.0))
    assert math.remainder(estimator.tool_face - 3.0, 2.0 * math.pi) == pytest.approx(0.0, abs=math.radians(3.0))


def slide(softer=0.0, motor=0.0, bias=0.0, following=1.0, last_sample=math.inf, duration=600.0, seed=0):
    """A rocked string without static zone, in closed form: off bottom, a ramp of pressure, then drilling; the centre
    follows a share of the twist that the rig file would need, and a step. Returns the estimator and the true
    toolface."""
    random = np.random.default_rng(seed)
    estimator = ToolFaceEstimator(S, 60.0, NOISE)
    compliance, x, samples = S * (1.0 + softer), 0.4, []
    for k in range(round(duration / 0.5)):
        time = 0.5 * k
        shown = 2900.0 * min(max((time - 60.0) / 60.0, 0.0), 1.0)
        centre = following * S * shown + (1.0 if time > 300.0 else 0.0)
        torque, reactive = (centre - x + 0.4) / compliance, (1.0 + motor) * shown
        x += 0.5 * compliance * (torque - reactive) / 60.0
        estimator.bit_loaded = time > 130.0
        estimator.advance(time, shown)
        if time > 8.0 and time % 4.0 == 0.0:
            cycle = CycleAverage(centre, torque + bias + random.normal(0.0, 17.0), shown, 8.0)
            estimator.update_with_cycle(time, cycle, 1.0, 0.0)
        if time % 12.0 == 0.0 and time <= last_sample:
            samples.append(MwdSample(time, time + 6.0, math.remainder(x + random.normal(0.0, 0.02), 2.0 * math.pi)))
        while samples and samples[0].arrived_at <= time:
            estimator.update_with_mwd(samples.pop(0), 0.0)
    return estimator, x


@pytest.mark.parametrize("known", [True, False])
def test_known_jump_of_torque_turns_nothing(known):
    estimator, x = slide()
    for time in np.arange(600.0, 640.0, 4.0):
        jump = -2e3 * min(max((time - 604.0) / 8.0, 0.0), 1.0)   # averages of two strokes show half of it first
        if known and time == 616.0:
            estimator.shift_torque(-2e3)
        estimator.update_with_cycle(time, CycleAverage(S * 2900.0 + 1.0, 2900.0 + jump, 2900.0, 8.0), 1.0, 0.0)
    assert (abs(estimator.tool_face - x) < math.radians(5.0)) == known
    assert estimator.filter.estimate.bias == pytest.approx(-2e3 if known else 0.0, abs=300.0 if known else 800.0)


@pytest.mark.parametrize(("softer", "motor", "bias"), [
    (0.13, 0.0, 0.0), (0.0, -0.25, 0.0), (0.0, 0.0, -500.0), (0.08, -0.12, 300.0), (0.0, 0.0, 0.0)])  # fmt: skip
def test_string_errors_are_estimated_while_sliding(softer, motor, bias):
    """Compliance, motor and sensor bias together, each within three standard deviations."""
    estimator, x = slide(softer, motor, bias)
    estimate = estimator.filter.estimate
    assert estimator.tool_face == pytest.approx(x, abs=math.radians(3.0))
    assert estimate.compliance == pytest.approx(softer, abs=3.0 * estimate.compliance_sigma)
    assert estimate.motor == pytest.approx(motor, abs=3.0 * estimate.motor_sigma)
    assert estimate.bias == pytest.approx(bias, abs=3.0 * estimate.bias_sigma)
    # Together they predict the torque at which the toolface rests.
    resting = (1.0 + estimate.motor) * 2900.0 + estimate.bias
    assert resting == pytest.approx((1.0 + motor) * 2900.0 + bias, abs=60.0)


def swung(amplitude, period, every=12.0, seed=1):
    """A string at rest whose bit swings with rocking of `period` s, as MWD every `every` s shows it over 400 s."""
    random, estimator = np.random.default_rng(seed), ToolFaceEstimator(S, 60.0, NOISE)
    cycle = CycleAverage(0.0, 0.0, 0.0, period)
    estimator.bit_loaded = True
    for k in range(1, 801):
        time = 0.5 * k
        estimator.advance(time, 0.0)
        if time % 6.0 == 0.0:
            estimator.update_with_cycle(time, cycle, 1.0, 0.0)
        if time % every == 0.0:
            phase = 2.0 * math.pi * (time - 6.0) / period
            angle = 0.3 + amplitude * math.sin(phase + 0.7) + random.normal(0.0, 0.02)
            estimator.update_with_mwd(MwdSample(time - 6.0, time, angle), 0.0, phase)
    return estimator


@pytest.mark.parametrize("amplitude", [0.0, 0.05, 0.15])
def test_swing_is_separated_from_toolface(amplitude):
    estimator = swung(amplitude, 8.3)
    assert estimator.filter.swing == pytest.approx(amplitude, abs=3.0 * estimator.filter.swing_sigma)
    assert estimator.filter.swing_sigma < 0.042
    assert estimator.tool_face == pytest.approx(0.3, abs=0.04)
    assert estimator.filter.swing_at(math.nan) == 0.0


def estimated_response_time(min_response_time, seed):
    """Lag (s) that is estimate in an hour of a string that follows in 60 s, held by what is believed of it; MWD every
    30 s reads a swing that stays unknown."""
    random, x = np.random.default_rng(seed), 0.0
    estimator = ToolFaceEstimator(S, 60.0, NOISE, min_response_time=min_response_time)
    estimator.bit_loaded = True
    for k in range(1, 7201):
        time, pull = 0.5 * k, -estimator.tool_face if estimator.known else 0.0
        x += 0.5 * pull / 60.0
        estimator.advance(time, 0.0)
        if time % 8.0 == 0.0:
            cycle = CycleAverage(x + pull, pull / S + random.normal(0.0, 30.0), 0.0, 8.0)
            estimator.update_with_cycle(time, cycle, 1.0, 0.0)
        if time % 30.0 == 0.0:
            estimator.update_with_mwd(MwdSample(time, time, x + random.normal(0.0, math.radians(3.0))), 0.0)
    return estimator.filter.estimate.response_time


@pytest.mark.parametrize("seed", [0, 1])
def test_estimated_response_time_has_lower_bound(seed):
    """The loop's correction of one sample looks like a quick response at the next one."""
    assert estimated_response_time(0.0, seed) < 30.0
    assert 45.0 <= estimated_response_time(45.0, seed) < 60.0
    assert estimated_response_time(90.0, seed) >= 60.0   # a set value stays


def test_swing_sampled_at_one_phase_stays_uncertain():
    """It cannot be distinguished from the toolface, and both have a larger sigma."""
    same, unlike = swung(0.1, 12.0), swung(0.1, 8.3)
    assert same.filter.swing_sigma > 1.3 * unlike.filter.swing_sigma
    assert same.sigma > 1.2 * unlike.sigma
    assert same.tool_face == pytest.approx(0.3, abs=3.0 * same.sigma)


def test_calibrated_rig_is_valid_rig_file():
    estimate = StringEstimate(0.1, 0.02, -0.2, 0.05, 250.0, 80.0, 70.0)
    again = parse_rig(dump_rig(calibrated_rig(RIG, estimate)))
    assert again.effects.torsional_compliance.extra == pytest.approx(0.1)
    assert again.effects.motor_wear.torque_loss == pytest.approx(0.2)
    assert again.effects.torque_sensor_bias.bias == pytest.approx(250.0)
    assert with_worn_motor(again).motor.torque_per_pressure == pytest.approx(0.8 * RIG.motor.torque_per_pressure)
    assert TorqueAndDrag(again, 0.235, 0.0).compliance == pytest.approx(1.1 * TorqueAndDrag(RIG, 0.235, 0.0).compliance)


def test_wrong_first_sample_is_outvoted():
    estimator = ToolFaceEstimator(S, 60.0, NOISE)
    feed(estimator, lambda time: 0.0, 0.5, 60.0, {18.0: -2.5, 30.0: None, 42.0: None})
    assert estimator.tool_face == pytest.approx(0.5, abs=math.radians(2.0))


@pytest.mark.parametrize("sample", [MwdSample(math.nan, 1.0, 0.0), MwdSample(0.0, 1.0, math.nan),
                                    MwdSample(1e9, 1e9, 0.0), MwdSample(-200.0, 1.0, 0.0)])
def test_estimator_rejects_invalid_samples(sample):
    estimator = ToolFaceEstimator(S, 60.0, NOISE)
    assert not estimator.update_with_mwd(sample, 0.0)
    estimator.update_with_cycle(10.0, CycleAverage(0.0, 0.0, 0.0, 8.0), 1.0, 0.0)
    assert not estimator.update_with_mwd(sample, 0.0)
    assert not estimator.known


def test_circular_histogram_matches_normal_distribution():
    """Across the half turn: precisions add at an update, variances at a diffusion."""
    histogram = CircularHistogram(0.05)
    for off in (-0.02, 0.06):
        histogram.update(math.remainder(math.pi + off, 2.0 * math.pi), 0.01)
    assert abs(math.remainder(histogram.mean - (math.pi + 0.02), 2.0 * math.pi)) < 2e-3
    assert histogram.sigma == pytest.approx(math.sqrt(0.005), rel=0.05)
    assert histogram.weight > 0.99
    histogram.diffuse(0.02)
    assert histogram.sigma == pytest.approx(math.sqrt(0.025), rel=0.05)
