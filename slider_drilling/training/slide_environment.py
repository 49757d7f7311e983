"""One slide as a `gymnasium` environment, for reinforcement learning (extra `gym`)."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import gymnasium
import numpy as np

from slider_drilling.control.interface import RigCommand
from slider_drilling.slide_scenarios.faulty_rig import FaultyRig
from slider_drilling.slide_scenarios.scenario import Scenario
from slider_drilling.training.observation import (
    MAX_BLOCK_SPEED,
    OBSERVED,
    MeasurementObserver,
    Observation,
    reward,
)

SAMPLES = 10  # sensor samples that an action holds for


class SlideEnvironment(gymnasium.Env[Observation, Observation]):
    """A scenario as a gymnasium environment, with all of its faults.

    Actions, observations and reward are those of `VectorSlideEnvironment`. The pump runs at the reference flow. An
    episode is truncated at the scenario's end and never terminates by itself.

    Args:
        scenario: The slide.
        elements: Of the string.

    Raises:
        InputError: The rig cannot be simulated.
    """

    def __init__(self, scenario: Scenario, elements: int = 60):
        self._scenario = scenario
        self._elements = elements
        rig = scenario.assumed_rig()
        most = np.array([rig.top_drive.max_speed, MAX_BLOCK_SPEED], np.float32)
        self._pump_speed = rig.reference_pump_speed
        self.action_space = gymnasium.spaces.Box(-most, most, dtype=np.float32)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (len(OBSERVED),), np.float32)
        self._rig: FaultyRig | None = None
        self._observer = MeasurementObserver()
        self._angle = 0.0  # rad, commanded
        self._deepest = 0.0  # m

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start the scenario again; seed: of sensor noise and faults."""
        super().reset(seed=seed)
        self._rig = FaultyRig(self._scenario, int(self.np_random.integers(2**31)), self._elements)
        self._observer = MeasurementObserver()
        measurements, truth = self._rig.rig.measurements, self._rig.rig.truth
        self._angle, self._deepest = measurements.top_drive_angle, truth.bit_depth
        return self._observer.observe(measurements, self._target(truth.time)), {}

    def step(self, action: Observation) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold an action for ten samples.

        Raises:
            RuntimeError: Called before the first `reset`.
        """
        if self._rig is None:
            raise RuntimeError("SlideEnvironment: call reset() before step()")
        drive, block = (float(value) for value in np.clip(action, self.action_space.low, self.action_space.high))  # type: ignore[attr-defined]
        rig = self._rig.rig
        for _ in range(SAMPLES):
            self._angle += drive * rig.interval
            measurements = self._rig.step(RigCommand(self._angle, drive, block, self._pump_speed))
            observation = self._observer.observe(measurements, self._target(measurements.time))
        truth = rig.truth
        error = math.remainder(truth.tool_face - self._target(truth.time), 2.0 * math.pi)
        new_hole = max(truth.bit_depth - self._deepest, 0.0)
        self._deepest = max(truth.bit_depth, self._deepest)
        truncated = truth.time >= self._scenario.duration - 0.5 * rig.interval
        earned = float(reward(new_hole, error, SAMPLES * rig.interval))
        return observation, earned, False, truncated, {"truth": dataclasses.asdict(truth), "error": error}

    def _target(self, time: float) -> float:
        return math.radians(self._scenario.target_at(time))
