"""Several plants of one string that follow a rig side by side, with measured torque fed back, while it runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.drillstring import assemble
from slider_drilling.drillstring.initial_state import InitialState
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.lane_block import LaneBlock, PlantState, min_substeps
from slider_drilling.drillstring.observer import Observer
from slider_drilling.drillstring.recorded_channels import Commands
from slider_drilling.rig import Rig

_STIFFEST = 1.2  # times the shear modulus: the time step stays stable when a calibration stiffens the string


class PlantBank:
    """Plants whose rigs differ in numbers alone, stepped in single precision at a fixed interval.

    Args:
        rigs: The rigs, K of them.
        elements: Of the string.
        interval: s between two samples of the commands.
        start: State in which all of them begin.
        observer_gain, observer_smoothing: See `Observer`; a gain of 0 for free runs.
    """

    def __init__(
        self, rigs: Sequence[Rig], elements: int, interval: float, start: InitialState = InitialState(),
        observer_gain: float = 0.3, observer_smoothing: float = 0.0,
    ) -> None:  # fmt: skip
        self._interval, self._elements_count = interval, elements
        self._observer = Observer(np.empty(0), np.empty(0), observer_gain, smoothing=observer_smoothing)
        self._mesh = assemble.common_mesh(rigs, elements)
        stiff = [replace(r, string=replace(r.string, shear_modulus=_STIFFEST * r.string.shear_modulus)) for r in rigs]
        self._substeps = min_substeps(stiff, self._mesh, interval)
        self._lanes = self._build(rigs, [start] * len(rigs))

    @property
    def rigs(self) -> tuple[Rig, ...]:
        """The rigs as they are simulated now."""
        return tuple(self._lanes.rigs)

    @property
    def interval(self) -> float:
        """s between two samples of the commands."""
        return self._interval

    def advance(self, commands: Commands, measured_torque: Array | None = None) -> Array:
        """Follow commands that are sampled every ``interval``; see `Plant.advance`.

        Args:
            commands: (n,) each.
            measured_torque: Surface torque N m at the same times, (n,), NaN where none was measured; None for a free
                run, a forecast.

        Returns:
            Channels (n, channels, K), in the order of `kernel_arrays.CHANNELS`.
        """
        unknown = np.full(commands.time.size, np.nan)
        return self._lanes.advance(commands, unknown if measured_torque is None else measured_torque)

    def change_rigs(self, rigs: Sequence[Rig]) -> None:
        """Continue with other numbers from now on: as many rigs, of the same well and string.

        Raises:
            ValueError: The string got so stiff that the time step is unstable.
        """
        if min_substeps(rigs, self._mesh, self._interval) > self._substeps:
            raise ValueError("plant bank: these rigs need a shorter time step than those that it began with")
        self._lanes = self._lanes.with_rigs(rigs)

    def save(self) -> PlantState:
        """A copy of the state. Raises ValueError before the first `advance`."""
        return self._lanes.save()

    def restore(self, state: PlantState) -> None:
        """Go back to a saved state."""
        self._lanes.restore(state)

    def _build(self, rigs: Sequence[Rig], starts: Sequence[InitialState]) -> LaneBlock:
        extra = [assemble.Modifiers()] * len(rigs)
        return LaneBlock(rigs, self._mesh, self._interval, starts, extra, self._substeps, self._observer, single=True)
