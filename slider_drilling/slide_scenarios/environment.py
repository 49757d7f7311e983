"""The virtual rig as a `gymnasium` environment, for reinforcement learning (extra `gym`)."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from slider_drilling.control.interface import Measurements, RigCommand
from slider_drilling.slide_scenarios.faulty_rig import FaultyRig
from slider_drilling.slide_scenarios.scenario import Scenario

Array = NDArray[np.float32]

SAMPLES = 10             # sensor samples that an action holds for
MAX_BLOCK_SPEED = 0.1    # m/s
# Indices of the observation beyond the five surface channels.
_SINE, _COSINE, _AGE = 5, 6, 7
_OBSERVATIONS = 8


class SlideEnvironment(gymnasium.Env[Array, Array]):
    """A scenario as a gymnasium environment.

    Action, each in [-1, 1]: speed of the top drive over its maximum, and of the block over 0.1 m/s, positive lowers.
    The pump runs at the reference flow. An action holds for ten samples of the sensors.

    Observation (8,): top-drive angle rad, surface torque kN m, block position m, hook load kN, standpipe pressure MPa,
    sine and cosine of the last MWD toolface minus its target, and the age of that sample s (0 before the first). A
    channel without a reading keeps its last value.

    Reward: new hole in m, minus the magnitude of the true toolface error over half a turn. The true state is used for
    the reward only. An episode is truncated at the scenario's end and never terminates by itself.

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
        self._max_speeds = np.array([rig.top_drive.max_speed, MAX_BLOCK_SPEED])
        self._pump_speed = rig.hydraulics.reference_flow / rig.mud_pump.displacement
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (_OBSERVATIONS,), np.float32)
        self._rig: FaultyRig | None = None
        self._observed = np.zeros(_OBSERVATIONS)
        self._angle = 0.0            # rad, commanded
        self._measured_at = math.nan     # s, of the last MWD sample

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Start the scenario again; seed: of sensor noise and faults."""
        super().reset(seed=seed)
        self._rig = FaultyRig(self._scenario, int(self.np_random.integers(2**31)), self._elements)
        self._observed, self._measured_at = np.zeros(_OBSERVATIONS), math.nan
        self._observed[_COSINE] = 1.0
        measurements = self._rig.rig.measurements
        self._angle = measurements.top_drive_angle
        self._observe(measurements)
        return self._observation(), {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold an action for ten samples.

        Raises:
            RuntimeError: Called before the first `reset`.
        """
        if self._rig is None:
            raise RuntimeError("SlideEnvironment: call reset() before step()")
        drive, block = (float(value) for value in np.clip(action, -1.0, 1.0) * self._max_speeds)
        depth = self._rig.rig.truth.bit_depth
        for _ in range(SAMPLES):
            self._angle += drive * self._rig.rig.interval
            self._observe(self._rig.step(RigCommand(self._angle, drive, block, self._pump_speed)))
        truth = self._rig.rig.truth
        error = math.remainder(truth.tool_face - self._target(truth.time), 2.0 * math.pi)
        reward = truth.bit_depth - depth - abs(error) / math.pi
        truncated = truth.time >= self._scenario.duration - 0.5 * self._rig.rig.interval
        return self._observation(), reward, False, truncated, {"truth": dataclasses.asdict(truth), "error": error}

    def _target(self, time: float) -> float:
        return math.radians(self._scenario.target_at(time))

    def _observe(self, measurements: Measurements) -> None:
        m = measurements
        channels = (m.top_drive_angle, m.surface_torque / 1e3, m.block_position, m.hook_load / 1e3,
                    m.standpipe_pressure / 1e6)
        for index, value in enumerate(channels):
            if math.isfinite(value):
                self._observed[index] = value
        for sample in m.mwd:
            error = sample.tool_face - self._target(m.time)
            self._observed[_SINE], self._observed[_COSINE] = math.sin(error), math.cos(error)
            self._measured_at = sample.measured_at
        self._observed[_AGE] = 0.0 if math.isnan(self._measured_at) else m.time - self._measured_at

    def _observation(self) -> Array:
        return self._observed.astype(np.float32)
