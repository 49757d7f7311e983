"""Noise floors: what steps, drifts or repeats is not noise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom
from toy import toy

from slider_drilling.gap import explain
from slider_drilling.gap.model import Channel
from slider_drilling.gap.problem.noise import difference_noise, is_white, lower_floor, noise_floor
from slider_drilling.gap.problem.spectral_lines import remove_lines

TIME = np.arange(0.0, 400.0, 0.1)


def channel(values, declared=3.0):
    return Channel("hook_load", TIME, values, "kN", declared_noise=declared)


def white(sigma=3.0):
    return np.random.default_rng(2).normal(0.0, sigma, TIME.size)


def test_square_wave_is_not_noise():
    square = 40.0 * np.sign(np.sin(2.0 * np.pi * TIME / 17.3))
    assert noise_floor(channel(square + white())).sigma == pytest.approx(3.0, rel=0.1)


@pytest.mark.parametrize("gap", [20.0 * np.sin(TIME), TIME * 0.5, np.where(TIME > 200.0, 50.0, 0.0)])
def test_waves_drifts_and_steps_are_not_noise(gap):
    assert noise_floor(channel(gap + white())).sigma == pytest.approx(3.0, rel=0.1)


def test_excess_noise_is_reported_and_capped():
    floor = noise_floor(channel(white(30.0)))
    assert floor.sigma == pytest.approx(6.0)
    assert floor.excess == pytest.approx(10.0, rel=0.1)
    assert noise_floor(channel(white(4.5))).excess is None


def coloured(share, sigma=3.0, memory=0.45):
    """Noise of which a share of the variance is slow."""
    generator = np.random.default_rng(4)
    keep = np.exp(-0.1 / memory)
    slow = lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], generator.normal(size=TIME.size))
    return sigma * (np.sqrt(1.0 - share) * generator.normal(size=TIME.size) + np.sqrt(share) * slow)


@pytest.mark.parametrize("share", [0.1, 0.25, 0.4])
def test_coloured_noise_keeps_nearly_the_declared_floor(share):
    noise = coloured(share)
    floor = noise_floor(channel(noise))
    assert floor.observed < 2.95 < floor.sigma <= 3.0
    assert floor.method == "colour"
    assert lower_floor(floor, noise).sigma == floor.sigma
    assert lower_floor(floor, noise + 5.0 * np.sin(TIME)).sigma == pytest.approx(floor.sigma, rel=0.01)


def test_sensor_better_than_declared_gets_lower_floor():
    floor = noise_floor(channel(white(1.8)))
    assert floor.sigma == pytest.approx(1.8 * np.sqrt(2.0), rel=0.05)
    assert noise_floor(channel(white(0.9))).sigma == pytest.approx(1.5)
    assert noise_floor(channel(white(1.8), declared=None)).sigma == pytest.approx(1.8, rel=0.05)


def test_floor_grows_smoothly_with_noise():
    floors = [noise_floor(channel(white(sigma))).sigma for sigma in np.linspace(0.3, 9.0, 60)]
    assert np.all(np.diff(floors) >= -1e-9)
    assert np.max(np.diff(floors)) < 0.3


def test_explained_kinks_lower_the_floor():
    turns = np.random.default_rng(5).uniform(size=TIME.size) < 0.25
    kinked = 3.0 * np.cumsum(np.where(np.cumsum(turns) % 2, 10.0, -10.0))
    floor = noise_floor(channel(kinked + white(), declared=None))
    assert floor.sigma > 6.0
    assert lower_floor(floor, white()).sigma == pytest.approx(3.0, rel=0.1)
    assert lower_floor(floor, 100.0 * white()).sigma == floor.sigma


def test_noiseless_record_has_floor_of_its_resolution():
    assert noise_floor(channel(np.round(TIME), declared=None)).sigma == pytest.approx(1.0 / np.sqrt(12.0), rel=1e-6)
    assert np.isnan(difference_noise(np.zeros(3)))


def test_too_few_undeclared_samples_are_refused():
    few = Channel("mwd", TIME[:20], TIME[:20], "rad")
    with pytest.raises(ValueError, match="none is declared"):
        noise_floor(few)


def test_whiteness_test_holds_its_level():
    generator = np.random.default_rng(8)
    noise = generator.normal(size=(400, 500))
    rejected = sum(is_white(row) is False for row in noise)
    assert binom.ppf(0.001, 400, 0.01) <= rejected <= binom.ppf(0.999, 400, 0.01)
    assert is_white(noise[0] + np.sin(np.arange(500.0) / 30.0)) is False
    assert is_white(noise[0, :50]) is None


@pytest.mark.parametrize(("declared", "remarked"), [(1.0, False), (2.3, False), (40.0, True)])
def test_record_quieter_than_declared_is_remarked(declared, remarked):
    model = toy({"slope": 5.0}, 3)
    (run,) = model.runs
    runs = (replace(run, channels=(replace(run.channels[0], declared_noise=declared),)),)
    remarks = explain(replace(model, runs=runs)).remarks
    assert any("times the declared noise; E is counted in 1/2" in remark for remark in remarks) == remarked


@pytest.mark.parametrize("hertz", [2.6, 3.46, 4.9])
def test_fast_line_is_not_noise(hertz):
    line = 6.0 * np.sin(2.0 * np.pi * hertz * TIME + 0.4)
    assert difference_noise(line + white()) > 3.5
    floor = noise_floor(channel(line + white()))
    assert floor.sigma == pytest.approx(3.0, rel=0.05)
    assert floor.excess is None


def test_lines_are_found_in_patchy_records():
    came = np.random.default_rng(3).uniform(size=TIME.size) > 0.02
    line = 6.0 * np.sin(2.0 * np.pi * 13.46 * TIME)  # as an alias
    patchy = replace(channel(line + white()), time=TIME[came], measured=(line + white())[came])
    assert noise_floor(patchy).sigma == pytest.approx(3.0, rel=0.08)


def test_white_noise_has_no_line():
    changed = 0
    for seed in range(200):
        record = np.random.default_rng(seed).normal(0.0, 3.0, 1200)
        changed += remove_lines(TIME[:1200], record, 0.01) is not record
    assert changed <= binom.ppf(0.999, 200, 0.02)


def test_wandering_line_is_removed():
    chirp = 6.0 * np.sin(2.0 * np.pi * (3.3 * TIME + 1.5e-5 * TIME**2))
    assert noise_floor(channel(chirp + white())).sigma == pytest.approx(3.0, rel=0.1)


def test_constant_record_has_no_line():
    still = np.zeros(TIME.size)
    assert remove_lines(TIME, still, 0.01) is still


def test_record_of_mostly_gaps_is_unchanged():
    bursts = TIME + 1e6 * np.floor(TIME / 100.0)
    line = 6.0 * np.sin(2.0 * np.pi * 3.46 * bursts)
    assert remove_lines(bursts, line, 0.01) is line
