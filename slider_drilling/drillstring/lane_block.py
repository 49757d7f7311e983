"""Rigs that are stepped side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring import assemble, kernel
from slider_drilling.drillstring.assemble import Modifiers
from slider_drilling.drillstring.depth_profile import DepthProfile, compute_profile
from slider_drilling.drillstring.initial_state import InitialState, initial_kernel_state
from slider_drilling.drillstring.kernel_arrays import CHANNELS, Array, KernelState, to_single_precision
from slider_drilling.drillstring.observer import Observer
from slider_drilling.drillstring.recorded_channels import Commands
from slider_drilling.process.jit_cache import announce_compilation
from slider_drilling.rig import Rig


@dataclass(frozen=True)
class PlantState:
    """A copy of everything that changes in a plant, for `Plant.restore`."""

    arrays: KernelState
    last_command: Array


class LaneBlock:
    """Rigs that are stepped side by side: their constants, state and last command."""

    def __init__(
        self,
        rigs: Sequence[Rig],
        mesh: assemble.Mesh,
        interval: float,
        starts: Sequence[InitialState],
        modifiers: Sequence[Modifiers],
        substeps: int,
        observer: Observer | None = None,
        single: bool = False,
    ) -> None:
        self.rigs, self.starts, self.interval = list(rigs), list(starts), interval
        self.mesh, self.substeps, self.dt = mesh, substeps, interval / substeps
        self._modifiers, self._observer = list(modifiers), observer
        self.elements = assemble.elements(rigs, self.mesh, self.dt, modifiers)
        self._nominal = self.elements.per_sliding_length.copy()
        self.lanes = assemble.lanes(rigs, self.mesh, self.dt, observer)
        self.curve = assemble.friction_curve(rigs[0].contact)
        e = self.elements
        self.speed_dependent = bool(np.any(e.stribeck_drop) or np.any(e.drift_rate) or np.any(e.turning_difference))
        self.rest_dependent = bool(np.any(self.elements.aging_growth))
        self.single = single
        self.state: KernelState | None = None
        self.last: Array | None = None

    def advance(
        self,
        commands: Commands,
        measured: Array | None = None,
        friction_factor: Array | None = None,
        acceleration: Array | None = None,
        bit_torque_factor: Array | None = None,
        block_offset: Array | None = None,
    ) -> Array:
        """Channels (n, channels, lanes) at the times of the commands.

        Args:
            measured: Surface torque for the observer, N m, (n,).
            friction_factor, bit_torque_factor: (n,).
            acceleration: Of the top drive, rad/s2, (n,).
            block_offset: m that the blocks are lower, (n, lanes).
        """
        columns = (
            0.0 if measured is None else measured,
            1.0 if friction_factor is None else friction_factor,
            self._slope(commands.top_drive_speed) if acceleration is None else acceleration,
            1.0 if bit_torque_factor is None else bit_torque_factor,
        )
        commanded = commands.rows()
        rows = np.empty((len(commanded), commanded.shape[1] + len(columns)))
        rows[:, : commanded.shape[1]] = commanded
        for place, values in enumerate(columns, commanded.shape[1]):
            rows[:, place] = values
        gaps = commands.time[1:] - commands.time[:-1]
        if len(gaps) and np.abs(gaps - self.interval).max() > 1e-3 * self.interval:
            raise ValueError(f"commands: samples must be {self.interval:g} s apart; `simulate` takes uneven ones")
        width = len(self.rigs)
        offset = np.zeros((len(rows), 0)) if block_offset is None else np.ascontiguousarray(block_offset)
        out = np.empty((len(rows), len(CHANNELS), width))
        if self.state is None:
            self.state = initial_kernel_state(
                self.rigs, self.mesh, self.elements, self.lanes, self.curve, self.dt, rows[0], self.starts,
                0.0 if block_offset is None else offset[0],
            )  # fmt: skip
            if self.single:
                self.elements, self.state = to_single_precision(self.elements, self.state, width)
        else:
            rows = np.concatenate([self._started()[1][None], rows])
            offset = np.concatenate([offset[:1], offset])
        advance = kernel.advance_single if self.single else kernel.advance
        what = "the step of the drill string" + (", in single precision," if self.single else "")
        with announce_compilation(advance, what):
            advance(
                width, self.mesh.count, self.substeps, self.dt, self.speed_dependent,
                self.rest_dependent, rows, offset,
                self.elements, self.curve, self.lanes, self.state, out,
            )  # fmt: skip
        self.last = rows[-1].copy()
        return out

    def _slope(self, speed: Array) -> Array:
        """Central differences of the speed (n,), rad/s2; the last one is backward."""
        before = speed[0] if self.last is None else self.last[1]
        if speed.size == 1:  # a rig that is stepped: called once a sample, so fast
            return np.asarray((speed - before) / self.interval)
        if self.last is None:
            return np.asarray(np.gradient(speed, self.interval))
        return np.asarray(np.gradient(np.concatenate([[before], speed]), self.interval)[1:])

    def scale_friction(self, factor: Array) -> None:
        state, _ = self._started()
        rows = np.repeat(np.maximum(factor, assemble.MIN_FRICTION_FACTOR), len(self.rigs))
        self.elements.per_sliding_length[: len(rows)] = self._nominal[: len(rows)] / rows
        # The kernel reads friction from the state, and resets it from the elements only where it varies in time.
        state.per_sliding_length[:] = self.elements.per_sliding_length

    def with_rigs(self, rigs: Sequence[Rig]) -> LaneBlock:
        """The same block with other numbers from now on, for as many rigs of the same well and string."""
        changed = LaneBlock(
            rigs, self.mesh, self.interval, self.starts, self._modifiers, self.substeps, self._observer, self.single
        )
        if self.state is None or self.last is None:
            return changed
        if self.single:
            changed.elements, _ = to_single_precision(changed.elements, self.state, len(rigs))
        changed.state, changed.last = self.state, self.last
        # The kernel reads friction from the state.
        changed.state.per_sliding_length[:] = changed.elements.per_sliding_length
        return changed

    def save(self) -> PlantState:
        state, last = self._started()
        return PlantState(KernelState(*(array.copy() for array in state)), last.copy())

    def restore(self, saved: PlantState) -> None:
        self.state = KernelState(*(array.copy() for array in saved.arrays))
        self.last = saved.last_command.copy()

    def profile(self) -> DepthProfile:
        return compute_profile(self.mesh, self.elements, self.curve, self._started()[0])

    def _started(self) -> tuple[KernelState, Array]:
        if self.state is None or self.last is None:
            raise ValueError("plant: has no state before the first advance")
        return self.state, self.last


def min_substeps(rigs: Sequence[Rig], mesh: assemble.Mesh, interval: float) -> int:
    """Fewest steps per interval that are stable for all rigs."""
    return max(1, math.ceil(interval / min(assemble.longest_step(rig, mesh) for rig in rigs)))
