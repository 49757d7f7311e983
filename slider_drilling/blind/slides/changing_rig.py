"""A foreign rig in which something begins while it runs."""

from __future__ import annotations

from dataclasses import replace

from slider_drilling.blind.foreign.foreign_rig import ForeignRig
from slider_drilling.blind.foreign.plant import ForeignPlant
from slider_drilling.blind.foreign.structure import Structure
from slider_drilling.blind.slides.beginnings import Beginning
from slider_drilling.blind.slides.case import SlideCase
from slider_drilling.control.interface import Measurements, RigCommand
from slider_drilling.diagnosis.rig_values import rig_with
from slider_drilling.drillstring import GroundTruth, InitialState, Modifiers
from slider_drilling.rig import Rig

_UPDATE_S = 4.0  # s between two changes of the plant while something grows


class ChangingRig(ForeignRig):
    """Steps like `ForeignRig`.

    Args:
        rig: The rig as its file states it.
        nuisance: Multiples of its numbers, as the rig really is.
        structure: How its plant and instruments differ from the model.
        case: When what begins.
        beginning: What begins; None for nothing.
        elements: Of the string.
        start: State in which the run begins.
    """

    def __init__(
        self, rig: Rig, nuisance: dict[str, float], structure: Structure, case: SlideCase,
        beginning: Beginning | None, elements: int, start: InitialState,
    ) -> None:  # fmt: skip
        self._file, self._nuisance, self._case, self._beginning = rig, nuisance, case, beginning
        self._start, self._update = start, case.onset
        self._values: dict[str, float] = {}
        super().__init__(rig_with(rig, nuisance), structure, case.seed, elements, case.duration, start)

    def step(self, command: RigCommand) -> Measurements:
        """Follow a command for one sensor period and measure at its end."""
        time = self.truth.time + self.interval
        if self._beginning is not None and time >= self._update and time < self._case.duration:
            self._change(time)
            self._update = time + _UPDATE_S
        if self._beginning is not None:
            share = self._beginning.flow(self._case.share_at(time), time - self._case.onset)
            measured = super().step(replace(command, pump_speed=share * command.pump_speed))
            # The strokes of the pump are counted, the flow is not.
            return replace(measured, pump_speed=command.pump_speed)
        return super().step(command)

    def _change(self, time: float) -> None:
        """Put the rig as it is now in the place of the one before; the state of the string goes on."""
        assert self._beginning is not None
        values = self._beginning.values(self._case.share_at(time), time - self._case.onset)
        if values == self._values:
            return
        self._values = values
        now = dict(self._nuisance)
        for name, value in values.items():
            now[name] = value if "." in name else now.get(name, 1.0) * value
        plant: ForeignPlant = self._plant
        following = ForeignPlant(
            rig_with(self._file, now), plant.mesh.count, self.interval, self._start, Modifiers(), self._structure,
            self._changes, plant.substeps,
        )  # fmt: skip
        following.continue_from(plant)
        self._plant = following

    def _as_read(self, truth: GroundTruth) -> GroundTruth:
        seen = super()._as_read(truth)
        if self._beginning is None or truth.time < self._case.onset:
            return seen
        share, age = self._case.share_at(truth.time), truth.time - self._case.onset
        return replace(seen, hook_load=self._beginning.hook_load(share, age, seen.hook_load))
