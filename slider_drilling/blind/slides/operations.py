"""Operations of a slide that are no faults: what a driller does while the twin must stay calm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.control.interface import RigCommand
from slider_drilling.drillstring.drives import DriveState

DURATIONS = {"target": 0.0, "flow": 0.0, "pick_up": 60.0, "rotation": 90.0, "rest": 60.0, "connection": 240.0}
"""Operations, with the time in s for which each takes the drives from the slide's controller."""
_FIRST = 420.0  # s, before which the slide is set up
_PAUSE = (60.0, 260.0)  # s between operations
_TURNS_DEG = (-60.0, 45.0, 90.0)  # changes of the toolface target
_FLOWS = (0.85, 0.9, 1.05)  # shares of the reference flow
_ROTATION, _ROTATION_RAMP = 6.0, 5.0  # rad/s, and s to reach it
# (from s, to s, block speed m/s) within the operation.
_PICK_UP = ((0.0, 20.0, -0.05), (40.0, 58.0, 0.05))
_CONNECTION = ((0.0, 40.0, -0.1), (190.0, 225.0, 0.1))
_PUMPS_OFF = (45.0, 170.0)  # s within a connection


@dataclass(frozen=True)
class Operation:
    """One operation.

    Attributes:
        name: A key of `DURATIONS`.
        start: s of the slide.
        amount: Change of the target in rad, or flow as a share of the reference flow; 0 for the others.
    """

    name: str
    start: float
    amount: float = 0.0

    @property
    def end(self) -> float:
        """s of the slide at which the controller has the drives again."""
        return self.start + DURATIONS[self.name]

    def drives_at(self, time: float) -> bool:
        """Whether the operation moves the drives at a time of the slide, s."""
        return self.start <= time < self.end

    def command(self, time: float, drives: DriveState, held: RigCommand, interval: float) -> RigCommand:
        """What the driller commands during the operation.

        Args:
            time: s of the slide.
            drives: Where the drives are.
            held: What the controller would command; its pump speed and, while rotating, its block speed are kept.
            interval: s, between commands.
        """
        age = time - self.start
        still = replace(held, top_drive_angle=drives.top_drive_angle, top_drive_speed=0.0, block_speed=0.0)
        if self.name == "rotation":
            left = DURATIONS[self.name] - age
            speed = _ROTATION * min(age / _ROTATION_RAMP, 1.0, left / _ROTATION_RAMP)
            angle = drives.top_drive_angle + speed * interval
            return replace(held, top_drive_angle=angle, top_drive_speed=speed)
        if self.name == "pick_up":
            return replace(still, block_speed=_speed_at(_PICK_UP, age))
        if self.name == "connection":
            pump = 0.0 if _PUMPS_OFF[0] < age < _PUMPS_OFF[1] else held.pump_speed
            return replace(still, block_speed=_speed_at(_CONNECTION, age), pump_speed=pump)
        return still


def draw_operations(generator: np.random.Generator, duration: float) -> tuple[Operation, ...]:
    """Every operation once, in a random order, as far as a slide of this duration (s) has room for them."""
    operations, time = [], _FIRST
    for name in generator.permutation(list(DURATIONS)):
        time += float(generator.uniform(*_PAUSE))
        amount = 0.0
        if name == "target":
            amount = math.radians(float(generator.choice(_TURNS_DEG)))
        elif name == "flow":
            amount = float(generator.choice(_FLOWS))
        operation = Operation(str(name), time, amount)
        if operation.end < duration - _PAUSE[0]:
            operations.append(operation)
        time = operation.end
    return tuple(operations)


def _speed_at(parts: Sequence[tuple[float, float, float]], age: float) -> float:
    return next((speed for begin, end, speed in parts if begin <= age < end), 0.0)
