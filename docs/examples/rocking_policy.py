"""A trained policy that rocks: what it sees, what it commands, and the controller that runs it on any rig.

    slider-drilling closed-loop --controller rocking_policy:TrainedRocking --only "hold, 4.0 km" -o out

in this folder scores it. `train_rocking_policy.py` trains it.

The policy corrects shifted rocking, the simplest controller that steers: `FixedRocking` rocks by an amplitude and a
period that follow from the string's length, and shifts the centre by a tenth of each toolface error (residual policy
learning: Silver et al., arXiv:1812.06298). Once a second the policy adds to the speed of the centre, and chooses the
speed of the block and the amplitude.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.control import Rocking
from slider_drilling.control.fixed_rocking import settings_for
from slider_drilling.control.interface import Measurements, RigCommand
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.training.observation import MeasurementObserver

Array = NDArray[Any]

WEIGHTS = Path(__file__).with_name("rocking_policy.npz")
INTERVAL = 1.0  # s between two actions
ACTIONS = 3
SHIFT_GAIN, SHIFT_SPEED = 0.1, 0.3  # share of an error by which the centre is shifted, and rad/s
CENTRE_SPEED = 0.1  # rad/s, that the policy adds at most
BLOCK_SPEED = 0.0025  # m/s, 9 m/h: the middle of the range
AMPLITUDE_RATE = 0.05  # 1/s, fastest change of the amplitude over that of FixedRocking
_HORIZON = 2000  # s of the rocking table
_MEMORY = 64  # s, over which the centre is remembered: longer than any MWD sample is old
FEATURES = 20


class RockingMemory:
    """Features and commands of many rigs at once, from the observations of a vector environment.

    Args:
        rigs: Rig files, one of each kind of rig.
        index: (n,) which of them each slot has.
    """

    def __init__(self, rigs: Sequence[Rig], index: NDArray[np.int64]) -> None:
        self._waves = np.stack([_wave(rig) for rig in rigs])
        self._periods = np.array([settings_for(rig).period for rig in rigs])
        self._idle_pressure = np.array([rig.hydraulics.reference_pressure for rig in rigs]) / 1e6
        self._lengths = np.array([rig.string.length for rig in rigs])
        self._speeds = np.array([rig.top_drive.max_speed for rig in rigs])
        count = len(index)
        self.index = index.copy()
        self._angle, self._centre, self._amplitude = np.zeros(count), np.zeros(count), np.ones(count)
        self._centres, self._pressures = np.zeros((count, _MEMORY)), np.zeros((count, _MEMORY))
        self._pressure, self._torque, self._hook_load = np.zeros(count), np.zeros(count), np.zeros(count)
        self._measured_at = np.full(count, -1.0)
        self._at_sample = np.zeros((count, 2))  # centre rad and pressure MPa when the last toolface was measured
        self._older = np.zeros((count, 3))  # sine, cosine of the toolface before it, and the centre's shift since
        self._last = np.zeros((count, 2))
        self._action = np.zeros((count, ACTIONS))
        self._pending = np.zeros(count)  # rad, of the shift that the errors ask for

    def restart(self, slots: NDArray[np.bool_], index: NDArray[np.int64]) -> None:
        """Forget slots (n,) whose episodes start; index: (n,) as in the constructor."""
        self.index[slots] = index[slots]
        for values in (
            self._angle, self._centre, self._centres, self._pressures, self._pressure, self._torque, self._hook_load,
            self._pending, self._at_sample, self._older, self._last, self._action,
        ):  # fmt: skip
            values[slots] = 0.0
        self._amplitude[slots], self._measured_at[slots] = 1.0, -1.0

    def features(self, observation: NDArray[np.float32]) -> Array:
        """(n, FEATURES) of observations (n, 12), each of the order of 1."""
        o = observation.astype(float)
        time, step = o[:, 0], np.round(o[:, 0] / INTERVAL).astype(int)
        first = step == 0
        pressure = o[:, 7] - self._idle_pressure[self.index]
        self._pressure += np.where(first, 1.0, 0.2) * (pressure - self._pressure)
        self._torque += np.where(first, 1.0, 0.05) * (o[:, 3] - self._torque)
        self._hook_load = np.where(first, o[:, 6], self._hook_load)
        rows = np.arange(len(o))
        self._centres[rows, step % _MEMORY], self._pressures[rows, step % _MEMORY] = self._centre, self._pressure
        self._take_toolfaces(o, time, step, rows)
        phase = 2.0 * math.pi * time / self._periods[self.index]
        known = (self._measured_at >= 0.0).astype(float)
        return np.column_stack([
            o[:, 9], o[:, 10], known, o[:, 11] / 30.0, (self._centre - self._at_sample[:, 0]) / math.pi,
            self._pressure - self._at_sample[:, 1], self._older, self._pressure / 2.0, pressure - self._pressure,
            self._torque / 5.0, (o[:, 6] - self._hook_load) / 50.0, np.sin(phase), np.cos(phase),
            self._lengths[self.index] / 3000.0 - 1.0, 5.0 * (self._amplitude - 0.8), self._action[:, 1],
            self._action[:, 0], 3.0 * self._pending,
        ]).astype(np.float32)  # fmt: skip

    def _take_toolfaces(self, o: Array, time: Array, step: NDArray[np.int64], rows: NDArray[np.int64]) -> None:
        """Remember, for each toolface that is new, the centre and pressure when it was measured."""
        measured = time - o[:, 11]
        new = ((o[:, 9] != 0.0) | (o[:, 10] != 0.0)) & (measured > self._measured_at + 0.05)
        back = np.minimum(np.round(o[:, 11] / INTERVAL).astype(int), _MEMORY - 1)
        then = (np.maximum(step - back, 0)) % _MEMORY
        centre, pressure = self._centres[rows, then], self._pressures[rows, then]
        shift = (centre - self._at_sample[:, 0]) / math.pi
        had_one = self._measured_at >= 0.0
        older = np.column_stack([self._last, shift]) * had_one[:, None]
        self._older = np.where(new[:, None], older, self._older)
        self._at_sample = np.where(new[:, None], np.column_stack([centre, pressure]), self._at_sample)
        self._last = np.where(new[:, None], o[:, 9:11], self._last)
        self._pending -= np.where(new, SHIFT_GAIN * np.arctan2(o[:, 9], o[:, 10]), 0.0)
        self._measured_at = np.where(new, measured, self._measured_at)

    def commands(self, time: Array, actions: Array) -> Array:
        """(n, 2) speeds of top drive, rad/s, and block, m/s, from actions (n, ACTIONS) at times (n,) s."""
        a = self._action = np.clip(actions, -1.0, 1.0)
        shift = np.clip(self._pending, -SHIFT_SPEED * INTERVAL, SHIFT_SPEED * INTERVAL)
        self._pending -= shift
        self._centre += shift + CENTRE_SPEED * INTERVAL * a[:, 0]
        wanted = 0.8 + 0.4 * a[:, 2]
        self._amplitude += np.clip(wanted - self._amplitude, -AMPLITUDE_RATE * INTERVAL, AMPLITUDE_RATE * INTERVAL)
        step = np.minimum(np.round(time / INTERVAL).astype(int) + 1, _HORIZON)
        angle = self._centre + self._amplitude * self._waves[self.index, step]
        speed = np.clip((angle - self._angle) / INTERVAL, -self._speeds[self.index], self._speeds[self.index])
        self._angle += speed * INTERVAL
        return np.column_stack([speed, BLOCK_SPEED * (1.0 + a[:, 1])])


def _wave(rig: Rig) -> Array:
    """Angle of the rocking of `FixedRocking` at whole seconds, rad, (_HORIZON + 1,)."""
    settings = settings_for(rig)
    rocking = Rocking(settings.amplitude, settings.period, settings.rounding)
    period = settings.period
    once = [rocking.from_rest(INTERVAL * k)[0] for k in range(min(_HORIZON, math.ceil(2 * period)) + 1)]
    rest = [rocking.from_rest(period + (INTERVAL * k) % period)[0] for k in range(len(once), _HORIZON + 1)]
    return np.array(once + rest)


class Policy:
    """Two networks of two tanh layers: the mean of the actions, and the value of the state."""

    def __init__(self, parameters: dict[str, Array]) -> None:
        self.parameters = parameters

    @classmethod
    def random(cls, seed: int, width: int = 64) -> Policy:
        """A policy that has learnt nothing: its first actions are near zero."""
        random = np.random.default_rng(seed)
        parameters: dict[str, Array] = {"log_std": np.full(ACTIONS, -0.7)}
        for net, outputs, gain in (("actor", ACTIONS, 0.01), ("critic", 1, 1.0)):
            sizes = (FEATURES, width, width, outputs)
            for layer in range(3):
                scale = gain if layer == 2 else math.sqrt(2.0)
                orthogonal = np.linalg.qr(random.normal(size=(max(sizes[layer : layer + 2]),) * 2))[0]
                parameters[f"{net}_w{layer}"] = scale * orthogonal[: sizes[layer], : sizes[layer + 1]]
                parameters[f"{net}_b{layer}"] = np.zeros(sizes[layer + 1])
        return cls({name: value.astype(np.float32) for name, value in parameters.items()})

    @classmethod
    def load(cls, path: Path) -> Policy:
        """A trained policy. Raises InputError where the file is none."""
        try:
            with np.load(path) as stored:
                return cls({name: stored[name] for name in stored.files if not name.startswith("adam")})
        except (OSError, ValueError) as error:
            raise InputError(f"{path}: no policy: {error}; train one with train_rocking_policy.py") from None

    def layers(self, net: str, features: Array) -> list[Array]:
        """Outputs of the three layers of ``actor`` or ``critic``."""
        p, outputs = self.parameters, [features]
        for layer in range(3):
            linear = outputs[-1] @ p[f"{net}_w{layer}"] + p[f"{net}_b{layer}"]
            outputs.append(linear if layer == 2 else np.tanh(linear))
        return outputs[1:]

    def mean_action(self, features: Array) -> Array:
        """(n, ACTIONS), not yet clipped."""
        return self.layers("actor", features)[-1]


class TrainedRocking:
    """The trained policy as a controller: the same class for `closed-loop`, the nodes and `sd.simulate`."""

    tool_face_target = 0.0  # rad

    def __init__(self, rig: Rig, weights: Path = WEIGHTS) -> None:
        self._policy, self._memory = Policy.load(weights), RockingMemory([rig], np.zeros(1, dtype=np.int64))
        self._observer = MeasurementObserver()
        self._pump = rig.hydraulics.reference_flow / rig.mud_pump.displacement
        self._start = self._before = math.nan
        self._angle, self._command = 0.0, np.zeros(2)
        self._next = 0.0  # s since the start

    def step(self, measurements: Measurements) -> RigCommand:
        """Follow the last action; choose the next one every second."""
        if math.isnan(self._start):
            self._start = self._before = measurements.time
            self._angle = measurements.top_drive_angle if math.isfinite(measurements.top_drive_angle) else 0.0
        observation = self._observer.observe(measurements, self.tool_face_target)
        observation[0] -= np.float32(self._start)
        step, self._before = max(measurements.time - self._before, 0.0), measurements.time
        if measurements.time - self._start >= self._next - 1e-6:
            features = self._memory.features(observation[None])
            actions = self._policy.mean_action(features)
            self._command = self._memory.commands(observation[None, 0].astype(float), actions)[0]
            self._next += INTERVAL
        # The command is the angle one sample ahead, as an environment's action makes it.
        self._angle += float(self._command[0]) * (step or 0.1)
        return RigCommand(self._angle, float(self._command[0]), float(self._command[1]), self._pump)
