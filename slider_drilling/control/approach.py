"""Back to bottom after picking up: where the bit touches is known from drilling, so most of the way can be quick."""

from __future__ import annotations

import math

_MEMORY = 30.0    # s, over which the touching point is averaged: a block that slips must not move it
_LANDING = 2.0    # s, time constant with which the block slows down to there
_FAST = 0.03      # m/s, above which sliding string turns easily
_CREEP = 0.006    # m/s, on from there


class Approach:
    """stiffness: N/m, of the string between block and bit; weight_per_pressure: N/Pa, of the bit and the motor."""

    def __init__(self, stiffness: float, weight_per_pressure: float):
        self._stiffness = stiffness
        self._weight_per_pressure = weight_per_pressure
        self._touching = math.nan    # m, position of the block at which the bit just touches
        self.under_way = False
        self.fast = False    # the string slides fast, or has just done so

    def pick_up(self) -> None:
        """The bit is lifted."""
        self.under_way = self.fast = True

    def touched(self) -> None:
        """The bit is on bottom again."""
        self.under_way = self.fast = False

    def drilling(self, block_position: float, pressure: float, step: float) -> None:
        """Take one sample of drilling: m, Pa across the motor, s since the last one."""
        touching = block_position - self._weight_per_pressure * max(pressure, 0.0) / self._stiffness
        if not math.isfinite(self._touching):
            self._touching = touching
        self._touching += (1.0 - math.exp(-step / _MEMORY)) * (touching - self._touching)

    def speed(self, block_position: float, fastest: float) -> float:
        """Block speed, m/s, up to `fastest`: down to the touching point, then a creep."""
        # Fast down to that point itself: drag of the string makes the bit touch later.
        left = self._touching - block_position
        wanted = max(left / _LANDING, _CREEP) if math.isfinite(left) else _CREEP
        self.fast = wanted > _FAST
        return min(fastest, wanted)
