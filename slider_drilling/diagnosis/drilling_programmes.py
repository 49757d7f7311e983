"""The test programmes of a drill string, as the engine plans them: numbers, the run that they make, and its limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from slider_drilling.diagnosis.programme_numbers import BY_HAND, GENTLE, ROUTINE, programme_of, programme_variables
from slider_drilling.diagnosis.programme_words import in_one_line, programme_in_words
from slider_drilling.diagnosis.replay import channel_of
from slider_drilling.diagnosis.run_inputs import RunInputs
from slider_drilling.drillstring import Commands, Response
from slider_drilling.files.installed_files import installed_file
from slider_drilling.gap.model import Array, Channel, LoggedRun, Manoeuvre, Model, Parameter, Values
from slider_drilling.programmes import Programme, load_programme, open_loop_commands
from slider_drilling.programmes.limit_guard import KEPT_CLEAR, STOPPING_TIME
from slider_drilling.programmes.limits import CompleteLimits, StepLimits, complete
from slider_drilling.rig import Rig

# Standard deviations of the hook load's noise that a guard adds.
_SIGMAS = 3.0


class SimulatedRig(Model, Protocol):
    """A model of a rig that can take another run in the place of its logs."""

    @property
    def rig(self) -> Rig:
        """The rig file."""

    @property
    def inputs(self) -> tuple[RunInputs, ...]:
        """What drives each run."""

    def with_run(self, run: LoggedRun, inputs: RunInputs) -> SimulatedRig:
        """The same rig with one run."""

    def responses(self, run: int, sets: Sequence[Values]) -> list[Response]:
        """What the rig does in a run, for K parameter sets, in the cheapest simulation."""


@dataclass(frozen=True)
class ProgrammeLimits:
    """What a whole run must not exceed.

    Attributes:
        steps: Torque, weight on bit and pressure.
        tool_face_swing: rad to either side of the first toolface; infinite if the toolface may be lost.
    """

    steps: CompleteLimits
    tool_face_swing: float = float("inf")

    def use(self, response: Response) -> dict[str, float]:
        """The share of each limit that a response uses, by name."""
        torque, swing = response.surface_torque, np.abs(response.tool_face - response.tool_face[0])
        return {
            "torque to the right": float(torque.max()) / self.steps.right_torque,
            "torque to the left": -float(torque.min()) / self.steps.left_torque,
            "weight on bit": float(response.weight_on_bit.max()) / self.steps.weight_on_bit,
            "standpipe pressure": float(response.standpipe_pressure.max()) / self.steps.pressure,
            "toolface": float(swing.max()) / self.tool_face_swing,
        }

    def use_by_guard(self, response: Response, lowering: Array, rig: Rig) -> dict[str, float]:
        """The share of the weight and pressure limits that a controller's guard sees.

        It counts all that has left the hook since the string hung free as weight that may come to the bit, wherever
        friction holds it now (`slider_drilling.programmes.limit_guard`), and keeps some of each limit clear.

        Args:
            response: What the rig does, from hanging free on.
            lowering: (n,) commanded speed of the block, m/s.
            rig: The rig file.
        """
        coming = rig.string.axial_stiffness * np.maximum(lowering, 0.0) * STOPPING_TIME
        weight = float(np.max(response.hook_load[0] - response.hook_load + coming))
        weight += _SIGMAS * rig.sensors.hook_load.noise
        circulating = float(response.standpipe_pressure[0])
        by_weight = weight * rig.bit.lever / rig.motor.torque_per_pressure
        room = max(self.steps.pressure - circulating, 1.0)
        return {
            "weight on bit": weight / ((1.0 - KEPT_CLEAR) * self.steps.weight_on_bit),
            "standpipe pressure": by_weight / ((1.0 - KEPT_CLEAR) * room),
        }


def programme_limits(rig: Rig, limits: StepLimits = StepLimits(), swing: float = float("inf")) -> ProgrammeLimits:
    """The limits of a test on a rig: those given, else those that the rig file implies."""
    return ProgrammeLimits(complete(limits, StepLimits(), rig), swing)


@dataclass(frozen=True)
class DrillingManoeuvre(Manoeuvre):
    """A run that could be made next, with its programme.

    Attributes:
        programme: What the crew does.
    """

    programme: Programme


@dataclass(frozen=True)
class DrillingProgrammes:
    """See `slider_drilling.gap.model.Programmes`.

    Attributes:
        model: The drill string that makes the run.
        duration: Longest time of a programme, s.
        channels: What the run's log will hold, at any times.
        limits: What no run may exceed.
    """

    model: SimulatedRig = field(repr=False)
    duration: float
    channels: tuple[Channel, ...] = field(repr=False)
    limits: ProgrammeLimits

    @property
    def variables(self) -> tuple[Parameter, ...]:
        """See `Programmes`."""
        return programme_variables(self.model.rig)

    @property
    def starts(self) -> Sequence[Values]:
        """See `Programmes`."""
        return tuple(self.complete(design) for design in (ROUTINE, BY_HAND, GENTLE))

    @property
    def fixed(self) -> Mapping[str, Manoeuvre]:
        """See `Programmes`."""
        commissioning = load_programme(installed_file("config/programmes/commissioning.yaml"))
        return {"routine": self.programme(ROUTINE), "commissioning": self.run_of(commissioning, {})}

    def complete(self, values: Values) -> dict[str, float]:
        """All numbers of a programme; those that are not given have their nominal value."""
        return {each.name: float(values.get(each.name, each.nominal)) for each in self.variables}

    def programme(self, values: Values) -> DrillingManoeuvre:
        """See `Programmes`."""
        design = self.complete(values)
        return self.run_of(programme_of(design, self.model.rig, self.duration), design)

    def run_of(self, programme: Programme, settings: Values) -> DrillingManoeuvre:
        """The run that a programme makes; settings: its numbers, for reports."""
        commands = open_loop_commands(programme, self.model.rig)
        time = commands.time
        channels = tuple(replace(each, time=_times(each, time), measured=_times(each, time)) for each in self.channels)
        run = LoggedRun("planned", time, commands.top_drive_angle, channels, (), "the top drive's angle", "rad")
        model = self.model.with_run(run, RunInputs(commands))
        words = str(in_one_line(programme_in_words(programme, self.model.rig)))
        return DrillingManoeuvre(words, dict(settings), model, programme)

    def limit_use(self, manoeuvre: Manoeuvre, sets: Sequence[Values]) -> Array:
        """See `Programmes`."""
        return np.array([max(shares.values()) for shares in self.shares_of_limits(manoeuvre, sets)])

    def shares_of_limits(self, manoeuvre: Manoeuvre, sets: Sequence[Values]) -> list[dict[str, float]]:
        """For each parameter set, the largest share of each limit, by name: that used, or that a guard sees."""
        lowering = self.commands(manoeuvre).block_speed
        shares = []
        for response in self.responses(manoeuvre, sets):
            used, seen = self.limits.use(response), self.limits.use_by_guard(response, lowering, self.model.rig)
            shares.append({name: max(used[name], seen.get(name, used[name])) for name in used})
        return shares

    def commands(self, manoeuvre: Manoeuvre) -> Commands:
        """What drives the rig in a run."""
        model: SimulatedRig = manoeuvre.model  # type: ignore[assignment]
        return model.inputs[0].commands

    def responses(self, manoeuvre: Manoeuvre, sets: Sequence[Values]) -> Sequence[Response]:
        """What the rig does in a run, for K parameter sets."""
        model: SimulatedRig = manoeuvre.model  # type: ignore[assignment]
        return model.responses(0, sets)


def surface_channels(rig: Rig) -> tuple[Channel, ...]:
    """The channels that a rig's recorder has, with their declared noise, at two times one sample apart."""
    fast = np.array([0.0, 1.0 / rig.sensors.rate])
    slow = np.array([0.0, rig.sensors.mwd.period])
    names = ("surface_torque", "standpipe_pressure", "hook_load")
    return (*(channel_of(rig, name, fast, fast) for name in names), channel_of(rig, "tool_face", slow, slow))


def _times(channel: Channel, time: Array) -> Array:
    """Sampling times of a channel in a run, as often as in the log that it comes from."""
    interval = float(time[1] - time[0])
    every = max(round(float(np.median(np.diff(channel.time))) / interval), 1)
    return time[every::every] if every > 1 else time
