"""Collects the commands for one sample from the topics they come on."""

from __future__ import annotations

import math
from collections.abc import Iterable

from slider_drilling.signals import RigCommand

TOP_DRIVE, BLOCK, PUMP = "top_drive/command", "draw_works/command", "mud_pump/command"


class CommandInbox:
    """The last command of each topic and the stamp that it answers; a value that is not finite is refused."""

    def __init__(self, pump_speed: float) -> None:
        self._stamp = {TOP_DRIVE: -1, BLOCK: -1, PUMP: -1}
        self._top_drive: tuple[float, float] | None = None
        self._block_speed = 0.0
        self._pump_speed = pump_speed
        self.refused = 0

    def put(self, topic: str, stamp_ns: int, position: float, velocity: float) -> bool:
        """Keep a command; False where it is not finite, older than the last or lacks what its topic needs."""
        needed = (position, velocity) if topic == TOP_DRIVE else (velocity,)
        if not all(map(math.isfinite, needed)):
            self.refused += 1
            return False
        if stamp_ns < self._stamp[topic]:
            return False
        self._stamp[topic] = stamp_ns
        if topic == TOP_DRIVE:
            self._top_drive = (position, velocity)
        elif topic == BLOCK:
            self._block_speed = velocity
        else:
            self._pump_speed = velocity
        return True

    def missing(self, stamp_ns: int, awaited: Iterable[str]) -> list[str]:
        """Those of the awaited topics that have not answered the sample of this stamp."""
        return [topic for topic in awaited if self._stamp[topic] < stamp_ns]

    def command(self, stamp_ns: int, angle: float) -> RigCommand:
        """What the rig is to do next; angle: rad, where the top drive is, held until it is told otherwise.

        A top drive whose last command answered an earlier sample stands at that command's angle: a slope says
        nothing of what comes after its own interval.
        """
        if self._top_drive is None:
            return RigCommand(angle, 0.0, self._block_speed, self._pump_speed)
        target, speed = self._top_drive
        fresh = self._stamp[TOP_DRIVE] >= stamp_ns
        return RigCommand(target, speed if fresh else 0.0, self._block_speed, self._pump_speed)
