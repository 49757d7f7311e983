"""A virtual rig with a scenario's faults: MWD samples lost or wrong, a block that slips, pipe that rubs to one side."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from slider_drilling.closed_loop.scenario import Scenario
from slider_drilling.control.interface import Measurements, MwdSample, RigCommand
from slider_drilling.drillstring import VirtualRig
from slider_drilling.effects import AngleFriction

_SLIP_TIME = 3.0  # s, over which the block drops


class FaultyRig:
    """Steps like `VirtualRig`; the faults have a generator of their own, so every contender meets the same."""

    def __init__(self, scenario: Scenario, seed: int, elements: int):
        by_angle = AngleFriction(scenario.angle_friction) if scenario.angle_friction else None
        self.rig = VirtualRig(scenario.true_rig(), seed, elements, scenario.start, friction_of_angle=by_angle)
        self._scenario = scenario
        self._random = np.random.default_rng((seed, 1))

    def step(self, command: RigCommand) -> Measurements:
        """One sensor period."""
        slip = self._scenario.slip
        if slip is not None and slip[0] <= self.rig.truth.time < slip[0] + _SLIP_TIME:
            command = dataclasses.replace(command, block_speed=command.block_speed + slip[1] / _SLIP_TIME)
        measurements = self.rig.step(command)
        return dataclasses.replace(measurements, mwd=tuple(self._received(measurements.mwd)))

    def _received(self, samples: tuple[MwdSample, ...]) -> list[MwdSample]:
        received = []
        for sample in samples:
            # Both are drawn for every sample, so that one fault's rate does not move the other's.
            lost, wrong, angle = self._random.uniform(size=3)
            if lost < self._scenario.lost:
                continue
            if wrong < self._scenario.outliers:
                sample = dataclasses.replace(sample, tool_face=math.pi * (2.0 * float(angle) - 1.0))
            received.append(sample)
        return received
