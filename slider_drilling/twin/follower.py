"""The plant beside the rig, and beside it one plant for each tracked parameter: what a change of it would show."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.diagnosis.readings import direction_of_block
from slider_drilling.drillstring import Commands, InitialState
from slider_drilling.drillstring.kernel_arrays import CHANNELS as PLANT_CHANNELS
from slider_drilling.drillstring.plant_bank import PlantBank
from slider_drilling.rig import Rig
from slider_drilling.twin.channels import COMPARED
from slider_drilling.twin.samples import Array
from slider_drilling.twin.tracked import TrackedParameter, rig_at

_ROWS = [PLANT_CHANNELS.index(name) for name in COMPARED]
_WEIGHT = PLANT_CHANNELS.index("weight_on_bit")
_STRONGER, _MOST_LEAK = 1.5, 0.8  # times the stall pressure; share of the flow that bypasses there, at most


@dataclass(frozen=True)
class Followed:
    """What the plants did.

    Attributes:
        time: s, (n,).
        channels: Of the plant at the centre, (n, channels), in the order of `channels.COMPARED`.
        sensitivity: Change of a channel per unit of a parameter, (n, channels, p).
        centre: (p,) values of the parameters that the centre has.
    """

    time: Array
    channels: Array
    sensitivity: Array
    centre: Array

    def at(self, values: Array) -> Array:
        """The channels (n, channels) for other values (p,), to first order."""
        return np.asarray(self.channels + self.sensitivity @ (values - self.centre))


class Follower:
    """Steps the plants.

    Args:
        rig: The rig file.
        parameters: What is tracked, p of them.
        elements, interval, observer_gain, observer_smoothing: See `PlantBank`.
        start: State in which the rig begins.

    Attributes:
        centre: Values of the parameters (p,) that the plant in the middle has.
        weight_on_bit, mean_weight: Of that plant at the last sample, and over the last block, N.
    """

    def __init__(
        self, rig: Rig, parameters: Sequence[TrackedParameter], elements: int, interval: float, observer_gain: float,
        observer_smoothing: float, start: InitialState,
    ) -> None:  # fmt: skip
        self._rig, self._parameters = rig, tuple(parameters)
        self.centre = np.array([parameter.nominal for parameter in parameters])
        self.weight_on_bit = self.mean_weight = 0.0
        self.bank = PlantBank(self._rigs(), elements, interval, start, observer_gain, observer_smoothing)

    def advance(self, commands: Commands, torque: Array | None = None) -> Followed:
        """Follow the drives; torque: measured at surface, N m, (n,), or None for a forecast."""
        out = self.bank.advance(commands, torque)
        self.weight_on_bit, self.mean_weight = float(out[-1, _WEIGHT, 0]), float(np.mean(out[:, _WEIGHT, 0]))
        lanes = out[:, _ROWS, :]
        sensitivity = np.zeros((*lanes.shape[:2], len(self._parameters)))
        lane = 0
        for index, parameter in enumerate(self._parameters):
            if parameter.step:
                lane += 1
                sensitivity[:, :, index] = (lanes[:, :, lane] - lanes[:, :, 0]) / parameter.step
            else:
                row = list(COMPARED).index(parameter.channel)
                sensitivity[:, row, index] = _reading(parameter, commands)
        centre = np.where([parameter.step > 0.0 for parameter in self._parameters], self.centre, 0.0)
        return Followed(commands.time, lanes[:, :, 0], sensitivity, centre)

    def move_centre(self, values: Array) -> None:
        """Go on with the plants around other values (p,)."""
        limits = ((parameter.lower, parameter.upper) for parameter in self._parameters)
        self.centre = np.array([min(max(v, low), high) for v, (low, high) in zip(values, limits, strict=True)])
        self.bank.change_rigs(self._rigs())

    def _rigs(self) -> list[Rig]:
        values = self.values(self.centre)
        changed = [{**values, p.name: values[p.name] + p.step} for p in self._parameters if p.step]
        return [_without_stall(rig_at(self._rig, each)) for each in (values, *changed)]

    def values(self, numbers: Array) -> Mapping[str, float]:
        """Values (p,) by parameter."""
        return {parameter.name: float(v) for parameter, v in zip(self._parameters, numbers, strict=True)}


def _without_stall(rig: Rig) -> Rig:
    """The rig with a motor that carries more: the same below the stall.

    A plant that stalls stays so until it is picked up, though the rig, a little less loaded, may have drilled on.
    """
    motor = rig.motor
    most = motor.max_pressure * math.sqrt(_MOST_LEAK / motor.leak) if motor.leak > 0.0 else math.inf
    stall = max(motor.pressure_at_stall, min(_STRONGER * motor.pressure_at_stall, most))
    return replace(rig, motor=replace(motor, stall_pressure=stall))


def _reading(parameter: TrackedParameter, commands: Commands) -> Array:
    if parameter.name == "sheave_friction":
        return -direction_of_block(commands, commands.time)
    return np.ones(commands.time.size)
