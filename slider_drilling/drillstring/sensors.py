"""Surface sensors and MWD (`model.md` section 5): from true values to readings."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.angles import wrap_angle
from slider_drilling.control.interface import MwdSample
from slider_drilling.rig import Mwd, Sensor

_MAX_STEPS = 2.0**52  # beyond it a double does not resolve a step of 1


def quantise(value: float, resolution: float) -> float:
    """The nearest multiple of ``resolution``; the value itself where that is zero."""
    steps = value / resolution if resolution > 0.0 else math.inf
    # Steps that a double does not resolve change nothing; NaN stays NaN.
    return round(steps) * resolution if abs(steps) < _MAX_STEPS else value


def lag_gain(lag: float, interval: float) -> float:
    """Fraction of the way to the truth that a reading with a first-order lag goes between two samples; both s."""
    return 1.0 - math.exp(-interval / lag) if lag > 0.0 else 1.0


@dataclass
class SurfaceSensor:
    """First-order lag, white noise, then quantisation, sampled every ``interval`` seconds."""

    settings: Sensor
    interval: float
    lagged: float | None = None

    def read(self, truth: float, random: np.random.Generator) -> float:
        """The reading for a true value now; the first call starts the lag in its steady state."""
        noise = random.normal(0.0, 1.0) * self.settings.noise
        gain = lag_gain(self.settings.lag, self.interval)
        self.lagged = truth if self.lagged is None else self.lagged + gain * (truth - self.lagged)
        return quantise(self.lagged + noise, self.settings.resolution)


@dataclass
class MwdSensor:
    """Samples the toolface every period; the sample reaches surface latency later."""

    settings: Mwd
    samples_taken: int = 0
    in_transit: tuple[MwdSample, ...] = field(default=())

    def read(
        self, before: tuple[float, float], now: tuple[float, float], random: np.random.Generator
    ) -> tuple[MwdSample, ...]:
        """Samples that arrive between two instants, each given as (time s, unwrapped toolface rad)."""
        while (self.samples_taken + 1) * self.settings.period <= now[0] + 1e-9:
            self.samples_taken += 1
            at = self.samples_taken * self.settings.period
            fraction = (at - before[0]) / (now[0] - before[0])
            true = before[1] + fraction * (now[1] - before[1])
            noisy = true + random.normal(0.0, 1.0) * self.settings.noise
            decoded = wrap_angle(quantise(wrap_angle(noisy), self.settings.resolution))
            self.in_transit += (MwdSample(at, at + self.settings.latency, decoded),)
        arrived = tuple(sample for sample in self.in_transit if sample.arrived_at <= now[0] + 1e-9)
        self.in_transit = self.in_transit[len(arrived) :]
        return arrived

    def copy(self) -> MwdSensor:
        """A copy that is stepped on its own."""
        return replace(self)
