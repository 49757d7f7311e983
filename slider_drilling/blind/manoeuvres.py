"""Manoeuvres of sealed logs: the commands of top drive, block and pump."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from slider_drilling.blind.sealed_plant import INTERVAL_S
from slider_drilling.drillstring import Commands
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.rig import Rig

_BLOCK_SPEED = (0.0022, 0.0036)  # m/s, 8 to 13 m/h
_BLOCK_STEPS = (0.4, 0.7)  # shares of the run at which the block changes its speed
_LOW_FLOW_TIME, _LOW_FLOW = (0.5, 0.59), 0.93  # share of the run with lower flow, relative to the reference flow
_SMOOTHING = 4  # samples over which the drive changes its speed
_FIRST_STROKE_S = 5.0


def varied(generator: np.random.Generator, rig: Rig, duration: float) -> Commands:
    """Returns rocking with several amplitudes and speeds and rests between, a flow step, and steps of block speed."""
    time = _times(duration)
    speed: Array = np.zeros_like(time)
    at = _FIRST_STROKE_S
    while at < duration - 40.0:
        amplitude, rate = generator.uniform(6.0, 28.0), generator.uniform(1.5, 4.5)
        at = _rock(speed, time, at, amplitude, rate, int(generator.integers(3, 6)))
        at += generator.uniform(8.0, 20.0)
    levels = generator.uniform(*_BLOCK_SPEED, size=3)
    first, second = (share * duration for share in _BLOCK_STEPS)
    block = np.interp(time, [0.0, first - 2.0, first, second - 2.0, second, duration], np.repeat(levels, 2))
    low = (time > _LOW_FLOW_TIME[0] * duration) & (time < _LOW_FLOW_TIME[1] * duration)
    return _commands(rig, time, speed, block, np.where(low, _LOW_FLOW, 1.0))


def steady(generator: np.random.Generator, rig: Rig, duration: float) -> Commands:
    """Returns a routine slide: one amplitude and speed of rocking, constant block speed and flow."""
    time = _times(duration)
    speed: Array = np.zeros_like(time)
    amplitude, rate = generator.uniform(10.0, 22.0), generator.uniform(2.0, 4.5)
    cycles = int((duration - 15.0) * rate / (4.0 * amplitude))
    _rock(speed, time, _FIRST_STROKE_S, amplitude, rate, max(cycles, 1))
    return _commands(rig, time, speed, np.full_like(time, generator.uniform(*_BLOCK_SPEED)), np.ones_like(time))


def rotary(generator: np.random.Generator, rig: Rig, duration: float) -> Commands:
    """Returns rotary drilling: several speeds with stops between, and one step of block speed."""
    time = _times(duration)
    speed: Array = np.zeros_like(time)
    at = _FIRST_STROKE_S
    while at < duration - 10.0:
        until = at + generator.uniform(25.0, 50.0)
        speed[(time >= at) & (time < until)] = generator.uniform(2.0, 8.0)
        at = until + (generator.uniform(8.0, 20.0) if generator.uniform() < 0.6 else 0.0)
    levels = generator.uniform(*_BLOCK_SPEED, size=2)
    half = 0.5 * duration
    block = np.interp(time, [0.0, half, half + 2.0, duration], np.repeat(levels, 2))
    return _commands(rig, time, speed, block, np.ones_like(time))


MANOEUVRES: dict[str, Callable[[np.random.Generator, Rig, float], Commands]] = {
    make.__name__: make for make in (varied, steady, rotary)
}


def _times(duration: float) -> Array:
    return np.arange(0.0, duration, INTERVAL_S, dtype=np.float64)


def _rock(speed: Array, time: Array, at: float, amplitude: float, rate: float, cycles: int) -> float:
    """Writes strokes into the drive's speed from the time `at` on; returns the time at which they end."""
    quarter = amplitude / rate
    for leg in range(2 * cycles):
        length = quarter if leg == 0 else 2.0 * quarter
        speed[(time >= at) & (time < at + length)] = rate if leg % 2 == 0 else -rate
        at += length
    speed[(time >= at) & (time < at + quarter)] = rate
    return at + quarter


def _commands(rig: Rig, time: Array, speed: Array, block_speed: Array, flow: Array) -> Commands:
    speed = np.convolve(speed, np.ones(_SMOOTHING) / _SMOOTHING, mode="same").astype(np.float64)
    crank = flow * rig.hydraulics.reference_flow / rig.mud_pump.displacement
    return Commands(time, _integral(speed), speed, _integral(block_speed), block_speed, crank)


def _integral(rate: Array) -> Array:
    total: Array = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * INTERVAL_S)])
    return total
