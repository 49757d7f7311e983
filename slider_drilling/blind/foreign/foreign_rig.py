"""A rig of foreign structure to test controllers on: the drives of `VirtualRig`, another plant and its instruments."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from slider_drilling.blind.foreign.instruments import sheave_friction
from slider_drilling.blind.foreign.plant import ForeignPlant, slow_changes
from slider_drilling.blind.foreign.structure import Structure
from slider_drilling.drillstring import GroundTruth, InitialState, Modifiers, VirtualRig
from slider_drilling.rig import Rig


class ForeignRig(VirtualRig):
    """Steps like `VirtualRig`.

    Args:
        rig: The rig as it really is, effects included.
        structure: How its plant and instruments differ from the model.
        seed: Of noise and slow changes.
        elements: Of the string.
        duration: s, of the slow changes; afterwards they stay.
        start: State in which the run begins.
    """

    def __init__(
        self, rig: Rig, structure: Structure, seed: int = 0, elements: int = 60, duration: float = 3600.0,
        start: InitialState = InitialState(),
    ) -> None:  # fmt: skip
        self._structure = structure
        self._changes = slow_changes(structure, duration, np.random.default_rng((seed, 1)))
        self._held, self._held_until = math.nan, -math.inf  # N and s, of the hook load reading
        super().__init__(rig, seed, elements, start)

    def _make_plant(self, elements: int, start: InitialState, modifiers: Modifiers, substeps: int | None) -> Any:
        return ForeignPlant(
            self.rig, elements, self.interval, start, modifiers, self._structure, self._changes, substeps
        )

    def _as_read(self, truth: GroundTruth) -> GroundTruth:
        structure = self._structure
        if truth.time >= self._held_until:
            friction = structure.deadline_hysteresis * float(sheave_friction(np.asarray(self._drives.block_speed)))
            self._held = truth.hook_load * (1.0 + structure.hook_load_gain) + structure.hook_load_offset - friction
            self._held_until = truth.time + structure.held_hook_load - 0.5 * self.interval
        return replace(truth, hook_load=self._held)

    def _driven(self) -> tuple[float, float]:
        angle, speed = self._plant.drive_state
        step = self._structure.encoder_step
        return (round(angle / step) * step if step > 0.0 else angle), speed
