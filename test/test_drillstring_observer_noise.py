import numpy as np
import pytest
from scipy.signal import lfilter
from short_well import short_rig

from slider_drilling.drillstring import Commands, Observer, simulate_batch
from slider_drilling.drillstring.assemble import common_mesh
from slider_drilling.drillstring.observer_noise import needed_smoothing, noise_shrinkage
from slider_drilling.wellbore.mesh import torsional_impedance

RIG = short_rig()
NOISE, INTERVAL = 150.0, 0.1


def sine_rocking(duration=240.0, turns=1.5, period=20.0):
    time = np.arange(0.0, duration, INTERVAL)
    angle, still = 2.0 * np.pi * turns * np.sin(2.0 * np.pi * time / period), np.zeros_like(time)
    speed = np.gradient(angle, time)
    return Commands(time, angle, speed, 0.003 * time, still + 0.003, still + 12.3)


def fed_back(commands, smoothing):
    """By how much feedback of a run's own torque with noise moves its mean hook load, N."""
    (free,) = simulate_batch([RIG], commands, 40)
    noisy = free.surface_torque + np.random.default_rng(3).normal(0.0, NOISE, commands.time.size)
    (fed,) = simulate_batch([RIG], commands, 40, observer=Observer(commands.time, noisy, smoothing=smoothing))
    return float(np.mean((fed.hook_load - free.hook_load)[commands.time > 60.0]))


def test_noise_that_is_fed_back_does_not_free_the_string():
    commands = sine_rocking()
    smoothed = fed_back(commands, needed_smoothing(RIG, NOISE, INTERVAL, 0.3))
    assert abs(smoothed) < 1500.0
    assert abs(fed_back(commands, 0.0)) > 4.0 * abs(smoothed)


@pytest.mark.parametrize("noise", [60.0, 150.0, 400.0])
def test_noise_of_any_size_shakes_the_drive_alike(noise):
    smoothing = needed_smoothing(RIG, noise, INTERVAL, 0.3)
    share = 1.0 - np.exp(-INTERVAL / smoothing)
    drawn = np.random.default_rng(1).normal(0.0, noise, 400000)
    smooth = lfilter([share], [1.0, share - 1.0], drawn)
    speed = 0.3 * smooth / torsional_impedance(RIG, common_mesh([RIG], 40))
    assert np.std(speed) == pytest.approx(0.02, rel=0.2)


def test_no_noise_needs_no_smoothing():
    assert needed_smoothing(RIG, 0.0, INTERVAL, 0.3) == 0.0


@pytest.mark.parametrize("smoothing", [0.0, 0.05, 0.4, 3.0])
def test_noise_shrinks_as_in_a_loop_of_the_strings_impedance(smoothing):
    """Error e of noise n: e = n - gain times smoothed e, with the band that samples can hold."""
    gain, fine = 0.3, 0.002
    frequency = np.linspace(0.0, 0.5 / INTERVAL, 20001)
    s = 2j * np.pi * frequency
    passed = np.abs((1.0 + s * smoothing) / (1.0 + gain + s * smoothing)) ** 2
    assert noise_shrinkage(gain, smoothing, INTERVAL) == pytest.approx(1.0 / np.sqrt(np.mean(passed)), rel=1e-3)
    # The same in time: noise of that band, and a lag in small steps.
    samples = np.random.default_rng(2).normal(size=4000)
    noise = np.repeat(samples, round(INTERVAL / fine))
    error, smooth = np.empty_like(noise), 0.0
    share = 1.0 - np.exp(-fine / smoothing) if smoothing else 1.0
    for index, value in enumerate(noise):
        e = (value - gain * (1.0 - share) * smooth) / (1.0 + gain * share)
        smooth += share * (e - smooth)
        error[index] = e
    assert np.std(noise) / np.std(error) == pytest.approx(noise_shrinkage(gain, smoothing, INTERVAL), rel=0.06)
