"""The workload: rocking the 4 km example well."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from slider_drilling.drillstring import Commands, Plant
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.rig import Rig

ELEMENTS = 200


def rocking_commands(rig: Rig, duration: float, start: float = 0.0) -> Commands:
    """Commands from ``start`` on: rocking by 20 rad in 24 s, block at 9 m/h, at the sampling rate of the sensors."""
    interval = 1.0 / rig.sensors.rate
    time: Array = np.asarray(start + interval * np.arange(round(duration / interval) + 1), dtype=float)
    rate = 2.0 * math.pi / 24.0
    pump = rig.reference_pump_speed
    return Commands(time, 20.0 * (1.0 - np.cos(rate * time)), 20.0 * rate * np.sin(rate * time), 0.0025 * time,
                    np.full_like(time, 0.0025), np.full_like(time, pump))  # fmt: skip


def variants(rig: Rig, count: int) -> list[Rig]:
    """``count`` copies of the rig with different bits, as in a Jacobian."""
    shares = np.linspace(0.9, 1.1, count)
    return [
        dataclasses.replace(rig, bit=dataclasses.replace(rig.bit, aggressiveness=share * rig.bit.aggressiveness))
        for share in shares
    ]


class RockingPlant:
    """A plant under continuous rocking."""

    def __init__(self, rig: Rig, elements: int = ELEMENTS) -> None:
        self._rig, self._plant = rig, Plant(rig, elements)
        self._elements, self.step = elements, self._plant.step
        self.last = self._plant.advance(rocking_commands(rig, 1.0 - self._plant.interval))

    def advance(self, duration: float) -> None:
        """Simulate ``duration`` s more; `last` holds the response."""
        interval = self._plant.interval
        self.last = self._plant.advance(rocking_commands(self._rig, duration - interval, self._plant.time + interval))

    def element_steps(self, duration: float) -> float:
        """Element-steps in ``duration`` s: elements times time steps."""
        return self._elements * duration / self.step
