"""Spectral lines of an axial oscillation tool in the hook load."""

from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.diagnosis.hook_load_lines import sampled_too_slowly, tool_frequencies
from slider_drilling.gap.model import Channel, LoggedRun

RATE_HZ = 10.0


def hook_load(seed, duration, amplitude=0.0, hertz=14.2, rate=RATE_HZ):
    time = np.arange(0.0, duration, 1.0 / rate)
    reading = np.random.default_rng(seed).normal(0.0, 1.0, time.size) + amplitude * np.sin(2.0 * np.pi * hertz * time)
    return LoggedRun("log", time, np.zeros_like(time), (Channel("hook_load", time, reading, "N"),))


@pytest.mark.parametrize("duration", [60.0, 400.0])
def test_noise_shows_no_tool(duration):
    assert all(tool_frequencies([hook_load(seed, duration)]) == () for seed in range(40))


def test_line_stands_for_all_its_aliases():
    found = tool_frequencies([hook_load(1, 120.0, amplitude=0.5)])
    assert min(abs(hertz - 14.2) for hertz in found) < 0.01
    assert min(abs(hertz - 5.8) for hertz in found) < 0.01  # folded at half the sampling rate


@pytest.mark.parametrize("rate", [5.0, 6.0, 8.0, 12.5])
def test_aliases_reach_the_fastest_tool(rate):
    for hertz in (6.3, 14.2, 21.7, 29.1):
        found = tool_frequencies([hook_load(1, 400.0, amplitude=1.0, hertz=hertz, rate=rate)])
        assert min(abs(each - hertz) for each in found) < 0.01


@pytest.mark.parametrize("rate", [1.0, 3.0, 4.0])
def test_slower_samples_than_a_tool_vibrates_show_none(rate):
    runs = [hook_load(1, 600.0, amplitude=1.0, rate=rate)]
    assert sampled_too_slowly(runs) and tool_frequencies(runs) == ()
    assert not sampled_too_slowly([hook_load(1, 60.0)])


def test_missing_samples_do_not_move_a_line():
    whole = hook_load(2, 120.0, amplitude=1.0)
    came = np.random.default_rng(0).uniform(size=whole.time.size) > 0.03
    (channel,) = whole.channels
    patchy = replace(whole, channels=(replace(channel, time=channel.time[came], measured=channel.measured[came]),))
    assert min(abs(hertz - 14.2) for hertz in tool_frequencies([patchy])) < 0.01


def test_slow_hook_load_shows_no_tool():
    time = np.arange(0.0, 1000.0, 2.0)
    slow = LoggedRun("log", time, np.zeros_like(time), (Channel("hook_load", time, np.sin(time), "N"),))
    assert tool_frequencies([slow]) == ()


def test_first_hook_load_is_used():
    shaken = hook_load(1, 120.0, amplitude=0.5)
    (channel,) = shaken.channels
    torque = replace(shaken, channels=(replace(channel, name="surface_torque"),))
    assert tool_frequencies([torque]) == ()
    assert tool_frequencies([torque, shaken]) == tool_frequencies([shaken]) != ()


def rocking_hook_load(seed: int, period: float, line: float = 0.0) -> LoggedRun:
    """Hook load that answers rocking with all its harmonics and wandering friction, and a line of its own."""
    random, time = np.random.default_rng(seed), np.arange(0.0, 400.0, 1.0 / RATE_HZ)
    angle = 12.0 * np.sin(2.0 * np.pi * time / period)
    answer = 5.0 * np.abs(np.cos(2.0 * np.pi * time / period)) + 3.0 * np.tanh(angle)
    wander = np.cumsum(random.normal(0.0, 0.02, time.size))
    reading = answer + wander + random.normal(0.0, 1.0, time.size) + 3.0 * np.sin(2.0 * np.pi * line * time)
    return LoggedRun("log", time, angle, (Channel("hook_load", time, reading, "N"),))


@pytest.mark.parametrize("period", [12.0, 17.3, 31.0])
def test_rocking_alone_shows_no_tool(period):
    assert all(tool_frequencies([rocking_hook_load(seed, period)]) == () for seed in range(10))


def test_slow_line_stands_for_its_aliases():
    found = tool_frequencies([rocking_hook_load(1, 17.3, line=10.102)])
    assert min(abs(hertz - 10.102) for hertz in found) < 0.002
