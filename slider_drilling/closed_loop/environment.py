"""The virtual rig for programs that learn by trying: a `gymnasium` environment (extra `gym`)."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from slider_drilling.closed_loop.faulty_rig import FaultyRig
from slider_drilling.closed_loop.scenario import Scenario
from slider_drilling.control.interface import Measurements, RigCommand

Array = NDArray[np.float32]

SAMPLES = 10         # of the sensors, that an action holds for
MOST_BLOCK_SPEED = 0.1   # m/s
_COUNT = 8


class SlideEnvironment(gymnasium.Env[Array, Array]):
    """A scenario as an environment. Raises InputError for a rig that cannot be simulated.

    Action, each in [-1, 1]: speed of the top drive over its greatest, and of the block over 0.1 m/s, positive lowers;
    the pump runs at the reference flow. It holds for ten samples of the sensors.

    Observation: top-drive angle rad, surface torque kN m, block position m, hook load kN, standpipe pressure MPa, sine
    and cosine of the last MWD toolface less its target, and that sample's age s (0 before the first). A channel
    without a reading keeps its last value.

    Reward: minus the error of the true toolface over half a turn, plus the hole drilled in m; truth is for the reward
    only. An episode is cut off at the scenario's end and never ends by itself.
    """

    def __init__(self, scenario: Scenario, elements: int = 60):
        self._scenario = scenario
        self._elements = elements
        rig = scenario.believed_rig()
        self._fastest = np.array([rig.top_drive.max_speed, MOST_BLOCK_SPEED])
        self._pump = rig.hydraulics.reference_flow / rig.mud_pump.displacement
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (_COUNT,), np.float32)
        self._rig: FaultyRig | None = None
        self._seen = np.zeros(_COUNT)
        self._angle = 0.0            # rad, that the top drive is told
        self._read_at = math.nan     # s, of the last MWD sample

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin the scenario again; seed: of noise and faults."""
        super().reset(seed=seed)
        self._rig = FaultyRig(self._scenario, int(self.np_random.integers(2**31)), self._elements)
        self._seen, self._read_at = np.zeros(_COUNT), math.nan
        self._seen[6] = 1.0
        measurements = self._rig.rig.measurements
        self._angle = measurements.top_drive_angle
        self._take(measurements)
        return self._observation(), {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold an action for ten samples. Raises RuntimeError before the first `reset`."""
        if self._rig is None:
            raise RuntimeError("SlideEnvironment: reset() comes before step()")
        drive, block = (float(value) for value in np.clip(action, -1.0, 1.0) * self._fastest)
        depth = self._rig.rig.truth.bit_depth
        for _ in range(SAMPLES):
            self._angle += drive * self._rig.rig.interval
            self._take(self._rig.step(RigCommand(self._angle, drive, block, self._pump)))
        truth = self._rig.rig.truth
        error = math.remainder(truth.tool_face - self._target(truth.time), 2.0 * math.pi)
        reward = truth.bit_depth - depth - abs(error) / math.pi
        over = truth.time >= self._scenario.duration - 0.5 * self._rig.rig.interval
        return self._observation(), reward, False, over, {"truth": dataclasses.asdict(truth), "error": error}

    def _target(self, time: float) -> float:
        return math.radians(self._scenario.target_at(time))

    def _take(self, m: Measurements) -> None:
        channels = (m.top_drive_angle, m.surface_torque / 1e3, m.block_position, m.hook_load / 1e3,
                    m.standpipe_pressure / 1e6)
        for place, value in enumerate(channels):
            if math.isfinite(value):
                self._seen[place] = value
        for sample in m.mwd:
            off = sample.tool_face - self._target(m.time)
            self._seen[5], self._seen[6] = math.sin(off), math.cos(off)
            self._read_at = sample.measured_at
        self._seen[7] = 0.0 if math.isnan(self._read_at) else m.time - self._read_at

    def _observation(self) -> Array:
        return self._seen.astype(np.float32)
