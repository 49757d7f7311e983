"""What may be called noise: not what steps, drifts or repeats."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom
from toy import toy

from slider_drilling.gap import explain
from slider_drilling.gap.model import Channel
from slider_drilling.gap.problem.noise import difference_noise, is_white, lowered, noise_floor

TIME = np.arange(0.0, 400.0, 0.1)


def channel(values, declared=3.0):
    return Channel("hook_load", TIME, values, "kN", declared_noise=declared)


def white(sigma=3.0):
    return np.random.default_rng(2).normal(0.0, sigma, TIME.size)


def test_a_square_wave_is_no_noise():
    square = 40.0 * np.sign(np.sin(2.0 * np.pi * TIME / 17.3))
    assert noise_floor(channel(square + white())).sigma == pytest.approx(3.0, rel=0.1)


@pytest.mark.parametrize("gap", [20.0 * np.sin(TIME), TIME * 0.5, np.where(TIME > 200.0, 50.0, 0.0)])
def test_waves_drifts_and_steps_are_no_noise(gap):
    assert noise_floor(channel(gap + white())).sigma == pytest.approx(3.0, rel=0.1)


def test_noise_far_above_the_sensors_is_said_and_not_believed():
    floor = noise_floor(channel(white(30.0)))
    assert floor.sigma == pytest.approx(6.0)
    assert floor.excess == pytest.approx(10.0, rel=0.1)
    assert noise_floor(channel(white(4.5))).excess is None


def test_kinks_of_the_signal_are_no_noise_once_a_model_explains_them():
    kinked = 300.0 * np.abs(np.sin(2.0 * np.pi * TIME / 0.9))
    floor = noise_floor(channel(kinked + white(), declared=None))
    assert floor.sigma > 6.0
    assert lowered(floor, white()).sigma == pytest.approx(3.0, rel=0.1)
    assert lowered(floor, 100.0 * white()).sigma == floor.sigma


def test_a_record_without_noise_has_its_last_digit():
    assert noise_floor(channel(np.round(TIME), declared=None)).sigma == pytest.approx(1.0 / np.sqrt(12.0), rel=1e-6)
    assert np.isnan(difference_noise(np.zeros(3)))


def test_too_few_samples_and_nothing_declared():
    few = Channel("mwd", TIME[:20], TIME[:20], "rad")
    with pytest.raises(ValueError, match="none is declared"):
        noise_floor(few)


def test_white_is_white_as_often_as_stated_and_a_drift_is_not():
    generator = np.random.default_rng(8)
    noise = generator.normal(size=(400, 500))
    told = sum(is_white(row) is False for row in noise)
    assert binom.ppf(0.001, 400, 0.01) <= told <= binom.ppf(0.999, 400, 0.01)
    assert is_white(noise[0] + np.sin(np.arange(500.0) / 30.0)) is False
    assert is_white(noise[0, :50]) is None


@pytest.mark.parametrize(("declared", "said"), [(1.0, False), (40.0, True)])
def test_a_record_far_quieter_than_its_sensor_is_told(declared, said):
    model = toy({"slope": 5.0}, 3)
    (run,) = model.runs
    runs = (replace(run, channels=(replace(run.channels[0], declared_noise=declared),)),)
    remarks = explain(replace(model, runs=runs)).remarks
    assert any("times what its sensor is said to: E is counted in half" in remark for remark in remarks) == said
