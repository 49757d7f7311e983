"""Section 5 of `model.md`: what the surface sensors and the MWD make of the truth."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.control.interface import MwdSample
from slider_drilling.rig import Mwd, Sensor

_RESOLVED = 2.0**52


def wrap_angle(angle: float) -> float:
    """The same direction in (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)


def quantise(value: float, resolution: float) -> float:
    """The nearest multiple of ``resolution``; the value itself where that is zero."""
    steps = value / resolution if resolution > 0.0 else math.inf
    # Steps that a double does not resolve change nothing, and neither does a value that is no number become one.
    return round(steps) * resolution if abs(steps) < _RESOLVED else value


@dataclass
class SurfaceSensor:
    """First-order lag, white noise, then quantisation, sampled every ``interval`` seconds."""

    settings: Sensor
    interval: float
    lagged: float | None = None

    def read(self, truth: float, random: np.random.Generator) -> float:
        """The reading for a true value now; the first one starts the lag in its steady state."""
        noise = random.normal(0.0, 1.0) * self.settings.noise
        gain = 1.0 - math.exp(-self.interval / self.settings.lag) if self.settings.lag > 0.0 else 1.0
        self.lagged = truth if self.lagged is None else self.lagged + gain * (truth - self.lagged)
        return quantise(self.lagged + noise, self.settings.resolution)


@dataclass
class MwdSensor:
    """Samples the toolface every period and lets surface have it latency later."""

    settings: Mwd
    taken: int = 0
    on_the_way: tuple[MwdSample, ...] = field(default=())

    def read(
        self, before: tuple[float, float], now: tuple[float, float], random: np.random.Generator
    ) -> tuple[MwdSample, ...]:
        """Samples that arrive by ``now``; both arguments are (time s, unwrapped toolface rad)."""
        while (self.taken + 1) * self.settings.period <= now[0] + 1e-9:
            self.taken += 1
            at = self.taken * self.settings.period
            share = (at - before[0]) / (now[0] - before[0])
            true = before[1] + share * (now[1] - before[1])
            noisy = true + random.normal(0.0, 1.0) * self.settings.noise
            decoded = wrap_angle(quantise(wrap_angle(noisy), self.settings.resolution))
            self.on_the_way += (MwdSample(at, at + self.settings.latency, decoded),)
        arrived = tuple(sample for sample in self.on_the_way if sample.arrived_at <= now[0] + 1e-9)
        self.on_the_way = self.on_the_way[len(arrived) :]
        return arrived

    def copy(self) -> MwdSensor:
        """The same sensor, to be stepped on its own."""
        return replace(self)
