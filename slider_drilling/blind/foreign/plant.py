"""A plant of foreign structure: the interface of `slider_drilling.drillstring.Plant`, none of its physics code.

It takes the same rig, commands and effects and gives the same channels. What differs is in `Structure`: the law of the
contact's memory, tool joints, bending stiffness, added mass, slow changes of friction, bit and pressure, a top drive
with a speed loop; and it integrates in another way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from slider_drilling.blind.foreign import kernel
from slider_drilling.blind.foreign.constants import (
    element_constants,
    friction_over_direction,
    longest_step,
    run_constants,
)
from slider_drilling.blind.foreign.structure import Structure
from slider_drilling.drillstring import Commands, InitialState, Modifiers, Response
from slider_drilling.drillstring.kernel_arrays import CHANNELS, Array
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import build_mesh


@dataclass
class ForeignState:
    """Everything that changes: per element (n,), scalars as `kernel` numbers them, and pulses on their way up.

    Attributes:
        position: m, along the hole.
        speed: m/s.
        rotation: rad.
        rotation_speed: rad/s.
        stretch_axial: m, of the contact along the hole.
        stretch_tangential: m, around it.
        rest: s, for which the contact has rested.
        scalars: (13,).
        pulses: Pa, motor pressure of the steps whose sound has not arrived yet.
    """

    position: Array
    speed: Array
    rotation: Array
    rotation_speed: Array
    stretch_axial: Array
    stretch_tangential: Array
    rest: Array
    scalars: Array
    pulses: Array

    def copy(self) -> ForeignState:
        """A copy that shares nothing."""
        return ForeignState(*(getattr(self, column.name).copy() for column in fields(ForeignState)))


class ForeignPlant:
    """One drill string of foreign structure.

    Args:
        rig: the rig as it really is, effects included.
        elements: of the mesh.
        interval: s, between samples of the commands.
        start: how the run begins; of a string at rest only twist and toolface offset are known here.
        modifiers: friction and curvature along the hole.
        structure: how this plant differs from the model.
        slow_changes: (m, 4) time s, then factors of friction, bit torque per weight and circulating pressure.
        substeps: of an interval; as few as are stable by default.
    """

    def __init__(
        self, rig: Rig, elements: int, interval: float, start: InitialState, modifiers: Modifiers,
        structure: Structure, slow_changes: Array, substeps: int | None = None,
    ) -> None:  # fmt: skip
        self.rig, self.interval, self._start, self._structure = rig, interval, start, structure
        self._slow_changes, self.mesh = slow_changes, build_mesh(rig, elements)
        self._elements = element_constants(rig, self.mesh, modifiers, structure)
        self._friction = friction_over_direction(rig, structure)
        self.substeps = substeps or math.ceil(interval / longest_step(self._elements))
        self._state: ForeignState | None = None
        self._last_row: Array | None = None
        self._driven: list[Array] = []
        self._hanging = np.zeros(self.mesh.count)  # m, positions of the string that hangs at rest

    @property
    def step(self) -> float:
        """The plant's own time step, s."""
        return self.interval / self.substeps

    @property
    def driven(self) -> Array:
        """(n, 2) angle rad and speed rad/s of the top drive at every sample so far, as its speed loop made them."""
        return np.concatenate(self._driven)

    @property
    def drive_state(self) -> tuple[float, float]:
        """Angle rad and speed rad/s of the top drive at the last sample, as its speed loop made them."""
        angle, speed = self._driven[-1][-1]
        return float(angle), float(speed)

    def advance(self, commands: Commands) -> Response:
        """Follow commands sampled every `interval`.

        The first call starts the string at rest at its first sample; later calls continue one interval before theirs.

        Args:
            commands: (n,) each.

        Returns:
            The response at their times.
        """
        changes = (np.interp(commands.time, self._slow_changes[:, 0], self._slow_changes[:, k]) for k in (1, 2, 3))
        rows = np.column_stack([commands.time, commands.rows(), *changes])
        fresh = self._state is None
        if self._state is None or self._last_row is None:
            self._state = self.initial_state(rows[0])
        else:
            rows = np.concatenate([self._last_row[None], rows])
        state = self._state
        depth_offset = self.rig.string.length - self._hanging[-1]
        constants = run_constants(
            self.rig, self.mesh, self._structure, self.step, depth_offset, self._start.tool_face_offset
        )
        out = np.empty((commands.time.size, len(CHANNELS) + 2))
        kernel.advance(
            rows, self.substeps, self.step, self._elements, self._friction, constants, state.position, state.speed,
            state.rotation, state.rotation_speed, state.stretch_axial, state.stretch_tangential, state.rest,
            state.scalars, state.pulses, out, fresh,
        )  # fmt: skip
        self._last_row = rows[-1].copy()
        self._driven.append(out[:, len(CHANNELS) :])
        return Response(commands.time, *out[:, : len(CHANNELS)].T)

    def continue_from(self, other: ForeignPlant) -> None:
        """Go on where another plant of the same mesh and interval stands: the rig has changed meanwhile."""
        assert other._state is not None and other._last_row is not None
        self._state, self._last_row = other._state.copy(), other._last_row.copy()
        self._hanging, self._driven = other._hanging, list(other._driven)

    def initial_state(self, row: Array) -> ForeignState:
        """Hanging at rest without friction, twisted evenly, the bit just on bottom.

        Args:
            row: (9,) time s, the commands, and the slow factors of friction, bit torque and pressure.
        """
        e, heave = self._elements, self.rig.effects.heave
        top = row[3] + heave.amplitude * math.sin(heave.phase)
        carried = np.cumsum(e.axial_load[::-1])[::-1]
        position = top + np.cumsum(carried / e.axial_spring)
        compliance = np.cumsum(1.0 / e.torsional_spring)
        rotation = row[1] + compliance / compliance[-1] * self._start.twist
        self._hanging = position.copy()
        zeros = np.zeros(self.mesh.count)
        scalars = np.zeros(kernel.SCALARS)
        scalars[kernel.TIME], scalars[kernel.BOTTOM] = row[0], position[-1]
        scalars[kernel.DRIVE_ANGLE], scalars[kernel.DRIVE_SPEED] = row[1], row[2]
        torque = e.torsional_spring[0] * (row[1] - rotation[0])
        scalars[[kernel.QUILL_TORQUE, kernel.READ_TORQUE, kernel.LAGGED_TORQUE]] = torque
        flow = max(row[5] * self.rig.mud_pump.displacement, 0.0) / self.rig.hydraulics.reference_flow
        scalars[kernel.STANDPIPE] = self.rig.circulating_pressure * row[8] * flow**1.8
        delay = max(round(self.rig.string.length / self.rig.mud.sound_speed / self.step), 1)
        return ForeignState(
            position, zeros.copy(), rotation, zeros.copy(), zeros.copy(), zeros.copy(), zeros.copy(), scalars,
            np.zeros(delay),
        )  # fmt: skip


def slow_changes(structure: Structure, duration: float, generator: np.random.Generator) -> Array:
    """Slow random factors (Ornstein-Uhlenbeck processes) of friction, bit torque per weight and circulating pressure.

    Args:
        structure: their standard deviations and memory.
        duration: s, of the run.
        generator: source of randomness.

    Returns:
        (m, 4) time s and the three factors, a row a second.
    """
    time = np.arange(0.0, duration + 2.0, 1.0)
    kept = math.exp(-1.0 / structure.slow_memory)
    sizes = np.array([structure.slow_friction, structure.slow_bit, structure.slow_pressure])
    level, rows = generator.normal(size=3), np.empty((time.size, 4))
    for k, now in enumerate(time):
        rows[k] = now, *(1.0 + sizes * level)
        level = kept * level + math.sqrt(1.0 - kept * kept) * generator.normal(size=3)
    return rows
