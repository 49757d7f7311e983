"""Many slides at once as a `gymnasium` vector environment, stepped by compiled code on all cores (extra `gym`)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from slider_drilling.control.interface import Measurements
from slider_drilling.drillstring.kernel_arrays import CHANNELS, Array
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.schema.option_types import check_option_types
from slider_drilling.slide_scenarios.scenario import Scenario
from slider_drilling.training.drawn_rigs import DrawnRig, assemble_rigs
from slider_drilling.training.instruments import ANGLE, BIT_DEPTH, HOOK_LOAD, PRESSURE, SPEED, TOOL_FACE, TORQUE
from slider_drilling.training.observation import (
    AGE,
    COSINE,
    MAX_BLOCK_SPEED,
    OBSERVED,
    SCALES,
    SINE,
    Observation,
    reward,
)
from slider_drilling.training.slots import RigSlots

AUTORESET = {"next_step": AutoresetMode.NEXT_STEP, "same_step": AutoresetMode.SAME_STEP,
             "disabled": AutoresetMode.DISABLED}  # fmt: skip
Slots = NDArray[Any]
ACTIONS = ("speed", "command")
_START_TWIST = 6.0  # rad, largest twist of a string at the start, either way


@dataclass(frozen=True)
class EpisodeOptions:
    """How episodes go.

    Attributes:
        duration: s.
        samples: Of the sensors, that an action holds for.
        actions: ``speed`` or ``command``, see `VectorSlideEnvironment`.
        autoreset: A key of `AUTORESET`.
        threads: How many step the rigs; None for all that are idle.
    """

    duration: float = 900.0
    samples: int = 10
    actions: str = "speed"
    autoreset: str = "next_step"
    threads: int | None = None

    def __post_init__(self) -> None:
        check_option_types(self, "vector_env")
        if not (math.isfinite(self.duration) and self.duration >= 1.0):
            raise InputError(f"vector_env: duration = {self.duration}: give seconds, at least 1")
        if self.samples < 1:
            raise InputError(f"vector_env: samples = {self.samples}: an action holds for at least 1 sample")
        if self.actions not in ACTIONS:
            raise InputError(f"vector_env: actions = {self.actions!r}: use one of {', '.join(ACTIONS)}")
        if self.autoreset not in AUTORESET:
            raise InputError(f"vector_env: autoreset = {self.autoreset!r}: use one of {', '.join(AUTORESET)}")
        if self.threads is not None and self.threads < 1:
            raise InputError(f"vector_env: threads = {self.threads}: give at least 1, or None for all that are idle")


class VectorSlideEnvironment(VectorEnv[Observation, Observation, Array]):
    """Slides on rigs that differ from each other and from their rig files.

    Each episode takes one of the drawn rigs, a toolface target, a twist of the string and a seed of noise, all at
    random. A slot's episodes follow from its own seed, whatever the number of slots.

    Action of each slot, with ``speed``: speed of the top drive in rad/s, within the drive's limit, and of the block in
    m/s, within 0.1 m/s, positive lowers; the pump runs at the reference flow. With ``command``: angle rad and speed
    rad/s of the top drive, block speed m/s and pump speed rad/s, as in `control.interface.RigCommand`. Actions beyond
    the limits are clipped to them, as a drive does.

    Observation: `observation.OBSERVED`. Reward: `observation.reward`. An episode is truncated after its duration. It is
    terminated only where a rig's numbers make its plant unstable; its reward is then 0.

    Args:
        count: Number of slots.
        rigs: Drawn rigs, at least one.
        elements: Of each string.
        options: How episodes go.

    Raises:
        InputError: The rigs' sensors differ in rate.
    """

    def __init__(
        self, count: int, rigs: Sequence[DrawnRig], elements: int = 40, options: EpisodeOptions = EpisodeOptions()
    ) -> None:
        self.num_envs, self._options = count, options
        drawn = assemble_rigs(rigs, elements, options.duration)
        self._slots = RigSlots(drawn, count, options.duration, options.samples, options.threads)
        self._assumed = tuple(each.scenario.assumed_rig() for each in rigs)
        self._low, self._high = _limits(drawn.instruments.limits, options.actions)
        self.metadata = {"autoreset_mode": AUTORESET[options.autoreset], "render_modes": []}
        self.single_action_space = gymnasium.spaces.Box(self._low, self._high, dtype=np.float32)
        self.single_observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (len(OBSERVED),), np.float32)
        self.action_space = batch_space(self.single_action_space, count)
        self.observation_space = batch_space(self.single_observation_space, count)
        self._samples_left = np.zeros(count, dtype=np.int64)
        self._target, self._twist, self._deepest = np.zeros(count), np.zeros(count), np.zeros(count)
        self._seeds = np.zeros(count, dtype=np.int64)
        self._over = np.zeros(count, dtype=bool)
        self._started = False
        self._generators = [np.random.default_rng(slot) for slot in range(count)]

    @property
    def interval(self) -> float:
        """s between two actions."""
        return self._options.samples * self._slots.rigs.interval

    @property
    def rig_index(self) -> Slots:
        """(slots,) which of the drawn rigs each slot has now."""
        return self._slots.records.rig.copy()

    @property
    def rig_files(self) -> tuple[Rig, ...]:
        """The drawn rigs as a controller knows them."""
        return self._assumed

    @property
    def targets(self) -> Array:
        """(slots,) toolface targets, rad."""
        return self._target.copy()

    def measurements(self, slot: int) -> Measurements:
        """The last sample of a slot, as a controller gets it; MWD samples are complete where ``samples`` is 1."""
        return self._slots.measurements(slot)

    def episode(self, slot: int) -> tuple[Scenario, int]:
        """The slot's episode as a scenario and its seed: `FaultyRig` with both repeats it bit for bit.

        Raises:
            InputError: The slot's plant is of foreign structure.
        """
        drawn = self._slots.rigs.rigs[int(self._slots.records.rig[slot])]
        if drawn.structure is not None:
            raise InputError(f"episode: slot {slot} has a plant of foreign structure, which no scenario holds")
        targets = ((0.0, math.degrees(self._target[slot])),)
        scenario = dataclasses.replace(drawn.scenario, targets=targets, start_twist=float(self._twist[slot]),
                                       duration=self._options.duration)  # fmt: skip
        return scenario, int(self._seeds[slot])

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start episodes.

        Args:
            seed: Slot k gets ``seed + k``, or its own of a sequence. Without one its random numbers go on.
            options: ``reset_mask``, (slots,) of bool: which slots start; the others stay as they are.

        Raises:
            InputError: Seed or mask do not fit the slots.
        """
        mask = np.ones(self.num_envs, dtype=bool)
        if options and "reset_mask" in options:
            mask = np.asarray(options["reset_mask"])
            if mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
                raise InputError(f"reset: reset_mask: give {self.num_envs} bools, at least one of them true")
            if not (self._started or mask.all()):
                raise InputError("reset: reset_mask: no slot has started yet; start all of them first, without a mask")
        for slot, own in enumerate(self._seeds_of(seed)):
            if own is not None and mask[slot]:
                self._generators[slot] = np.random.default_rng(own)
        self._start(np.flatnonzero(mask))
        self._started = True
        return self._observe(), self._info()

    def step(self, actions: Observation) -> tuple[Observation, Array, Slots, Slots, dict[str, Any]]:
        """Hold an action in each slot.

        Args:
            actions: (slots, 2), or (slots, 4) with ``command``.

        Raises:
            RuntimeError: Called before `reset`, or for an episode that is over where autoreset is disabled.
            InputError: The actions have another shape or are not finite.
        """
        self._check_running()
        starting = self._over.copy()
        if starting.any():
            self._start(np.flatnonzero(starting))
        moving = ~starting
        self._slots.step(moving, self._commands(actions), self._options.samples, self._options.actions == "command")
        self._samples_left[moving] -= self._options.samples
        unstable = ~np.isfinite(self._slots.records.truth.sum(axis=1))
        earned = np.where(moving & ~unstable, self._earned(), 0.0)
        truncated = (self._samples_left <= 0) & ~unstable
        self._over = truncated | unstable
        observation, info = self._observe(), self._info()
        if self._options.autoreset == "same_step" and self._over.any():
            info = {"final_obs": observation.copy(), "_final_obs": self._over.copy(), "final_info": info}
            self._start(np.flatnonzero(self._over))
            observation = self._observe()
            info |= self._info()
        return observation, earned, unstable, truncated, info

    def _seeds_of(self, seed: int | Sequence[int | None] | None) -> Sequence[int | None]:
        """A seed for each slot, or None where its random numbers go on. Raises InputError."""
        if seed is None:
            return ()
        given: list[int | None] = list(seed) if isinstance(seed, Iterable) else [seed]
        for own in given:
            if own is not None and (isinstance(own, bool) or not isinstance(own, Integral) or own < 0):
                raise InputError(f"reset: seed = {seed!r:.60}: give a whole number from 0 on, or one for each slot")
        if isinstance(seed, Integral):
            return [int(seed) + slot for slot in range(self.num_envs)]
        if len(given) != self.num_envs:
            raise InputError(f"reset: seed: {len(given)} seeds for {self.num_envs} slots; give one each")
        return [None if own is None else int(own) for own in given]

    def _check_running(self) -> None:
        if not self._started:
            raise RuntimeError("VectorSlideEnvironment: call reset() before step()")
        if self._options.autoreset == "disabled" and self._over.any():
            slot = int(self._over.argmax())
            raise RuntimeError(f"VectorSlideEnvironment: the episode of slot {slot} is over: reset it")

    def _earned(self) -> Array:
        """Rewards of the step, (slots,); keeps the depth that each bit has reached."""
        truth = self._slots.records.truth
        new_hole = np.maximum(truth[:, BIT_DEPTH] - self._deepest, 0.0)
        self._deepest = np.fmax(self._deepest, truth[:, BIT_DEPTH])
        return reward(new_hole, truth[:, TOOL_FACE] - self._target, self.interval)

    def _start(self, slots: Slots) -> None:
        """Draw and start an episode in each of some slots."""
        count = len(self._slots.rigs.rigs)
        for slot in slots:
            random = self._generators[slot]
            self._slots.records.rig[slot] = random.integers(count)
            self._target[slot] = math.radians(float(random.uniform(-180.0, 180.0)))
            self._twist[slot] = random.uniform(-_START_TWIST, _START_TWIST)
            self._seeds[slot] = random.integers(2**31)
        self._slots.start(slots, self._slots.records.rig[slots], self._twist[slots], self._seeds[slots])
        self._samples_left[slots] = round(self._options.duration / self._slots.rigs.interval)
        self._deepest[slots] = self._slots.records.truth[slots, BIT_DEPTH]
        self._over[slots] = False

    def _commands(self, actions: Observation) -> Array:
        given = np.asarray(actions, dtype=float)
        if given.shape != (self.num_envs, self._low.size):
            raise InputError(f"step: actions have shape {given.shape}; give ({self.num_envs}, {self._low.size})")
        if not np.isfinite(given).all():
            raise InputError("step: an action is not finite; check the policy's output")
        given = np.clip(given, self._low, self._high)
        if self._options.actions == "command":
            return given
        pump = self._slots.rigs.pump_speed[self._slots.records.rig]
        return np.column_stack([np.zeros(self.num_envs), given, pump])

    def _observe(self) -> Observation:
        s = self._slots.records
        time = s.samples * self._slots.rigs.interval
        known = ~np.isnan(s.last_mwd[:, 0])
        error = s.last_mwd[:, 2] - self._target
        observed = np.zeros((self.num_envs, len(OBSERVED)))
        measured = (time, s.readings[:, ANGLE], s.readings[:, SPEED], s.readings[:, TORQUE], s.drives[:, 2],
                    s.drives[:, 3], s.readings[:, HOOK_LOAD], s.readings[:, PRESSURE], s.drives[:, 4])  # fmt: skip
        observed[:, : SCALES.size] = np.column_stack(measured) / SCALES
        observed[:, SINE], observed[:, COSINE] = known * np.sin(error), known * np.cos(error)
        observed[:, AGE] = np.where(known, time - s.last_mwd[:, 0], 0.0)
        return np.nan_to_num(observed.astype(np.float32), posinf=0.0, neginf=0.0)

    def _info(self) -> dict[str, Any]:
        """True channels by name, (slots,), the true toolface error rad, and the number of the drawn rig."""
        s = self._slots.records
        error = (s.truth[:, TOOL_FACE] - self._target + math.pi) % (2.0 * math.pi) - math.pi
        truth = {name: s.truth[:, column].copy() for column, name in enumerate(CHANNELS)}
        return {**truth, "error": error, "rig": s.rig.copy()}


def _limits(limits: Array, actions: str) -> tuple[Array, Array]:
    """Lowest and highest action; limits: (rigs, 3) of the top drives."""
    speed = float(np.max(limits[:, 1]))
    if actions == "speed":
        high = np.array([speed, MAX_BLOCK_SPEED])
        return (-high).astype(np.float32), high.astype(np.float32)
    high = np.array([np.inf, speed, MAX_BLOCK_SPEED, 60.0])
    return np.array([-np.inf, -speed, -MAX_BLOCK_SPEED, 0.0], np.float32), high.astype(np.float32)
