"""A virtual rig with the faults of a scenario: lost and wrong MWD samples, block slip, friction by angle and by
direction, lying sensors, faults of pump, pipe and nozzles.
"""

from __future__ import annotations

import copy
import dataclasses
import math

import numpy as np

from slider_drilling.blind.foreign.foreign_rig import ForeignRig
from slider_drilling.control.interface import Measurements, MwdSample, RigCommand
from slider_drilling.drillstring import VirtualRig
from slider_drilling.effects import AngleFriction, DirectionFriction
from slider_drilling.slide_scenarios.scenario import Scenario

_SLIP_TIME = 3.0  # s, duration of a block slip


class FaultyRig:
    """Steps like `VirtualRig`.

    The faults have their own random generator, so every contender meets the same faults.

    Args:
        scenario: The slide.
        seed: Of sensor noise and faults.
        elements: Of the string.

    Attributes:
        rig: The virtual rig, with its true state.
    """

    def __init__(self, scenario: Scenario, seed: int, elements: int):
        self.rig = _virtual_rig(scenario, seed, elements)
        self._scenario = scenario
        self._faults = copy.deepcopy(scenario.faults)   # a stuck sensor remembers its value
        self._random = np.random.default_rng((seed, 1))

    def step(self, command: RigCommand) -> Measurements:
        """Advance by one sample of the sensors and return the measurements."""
        slip = self._scenario.block_slip
        if slip is not None and slip[0] <= self.rig.truth.time < slip[0] + _SLIP_TIME:
            command = dataclasses.replace(command, block_speed=command.block_speed + slip[1] / _SLIP_TIME)
        for fault in self._faults:
            share = fault.flow_share(self.rig.truth.time + self.rig.interval)
            command = dataclasses.replace(command, pump_speed=share * command.pump_speed)
        measurements = self.rig.step(command)
        for fault in self._faults:
            measurements = fault.reading(measurements, self.rig.rig)
        return dataclasses.replace(measurements, mwd=tuple(self._received(measurements.mwd)))

    def _received(self, samples: tuple[MwdSample, ...]) -> list[MwdSample]:
        received = []
        for sample in samples:
            # Draw all three for every sample, so that the rate of one fault does not change the other fault.
            lost, wrong, angle = self._random.uniform(size=3)
            if lost < self._scenario.mwd_lost:
                continue
            if wrong < self._scenario.mwd_outliers:
                sample = dataclasses.replace(sample, tool_face=math.pi * (2.0 * float(angle) - 1.0))
            received.append(sample)
        return received


def _virtual_rig(scenario: Scenario, seed: int, elements: int) -> VirtualRig:
    """The rig of a scenario without its faults."""
    if scenario.structure is not None:
        return ForeignRig(scenario.true_rig(), scenario.structure, seed, elements, scenario.duration, scenario.start)
    by_angle = AngleFriction(scenario.angle_friction) if scenario.angle_friction else None
    by_speed = DirectionFriction(scenario.right_friction) if scenario.right_friction else None
    return VirtualRig(scenario.true_rig(), seed, elements, scenario.start, friction_of_angle=by_angle,
                      friction_of_speed=by_speed)
