"""Back to bottom after picking up: where the bit touches is known from drilling, so most of the way can be quick.

Lowering leaves weight hanging on the wall, which rocking frees onto the bit within seconds of its touching: the
reactive torque then throws the toolface. So the block rests just above bottom until drag has fallen.
"""

from __future__ import annotations

import math

_MEMORY = 30.0    # s, over which the touching point is averaged: a block that slips must not move it
_LANDING = 2.0    # s, time constant with which the block slows down to there
_FAST = 0.03      # m/s, above which sliding string turns easily
_CREEP = 0.004    # m/s, on from there
_ABOVE = 0.25     # m, above the touching point, where the string is rocked free of what drag has stored in it
_FREE = 0.2       # share of the drag of a string that does not turn
_LONGEST = 40.0   # s


class ReturnToBottom:
    """stiffness: N/m, of the string between block and bit; weight_per_pressure: N/Pa, of the bit and the motor."""

    def __init__(self, stiffness: float, weight_per_pressure: float):
        self._stiffness = stiffness
        self._weight_per_pressure = weight_per_pressure
        self._touching = math.nan    # m, position of the block at which the bit just touches
        self._waited = 0.0
        self.under_way = False
        self.fast = False    # the string slides fast, or has just done so

    def pick_up(self) -> None:
        """The bit is lifted."""
        self.under_way = self.fast = True
        self._waited = 0.0

    def touched(self) -> None:
        """The bit is on bottom again."""
        self.under_way = self.fast = False

    def drilling(self, block_position: float, pressure: float, step: float) -> None:
        """Take one sample of drilling: m, Pa across the motor, s since the last one."""
        touching = block_position - self._weight_per_pressure * max(pressure, 0.0) / self._stiffness
        if not math.isfinite(self._touching):
            self._touching = touching
        self._touching += (1.0 - math.exp(-step / _MEMORY)) * (touching - self._touching)

    def speed(self, block_position: float, fastest: float, drag: float, step: float) -> float:
        """Block speed, m/s, up to `fastest`: down to above the touching point, a rest until rocking has freed what
        drag (share of that of a string that does not turn) holds, then a creep. step: s."""
        left = self._touching - _ABOVE - block_position
        wanted = left / _LANDING if math.isfinite(left) else _CREEP
        self.fast = wanted > _FAST
        if wanted > _CREEP:
            return min(fastest, wanted)
        if self._waited < _LONGEST and not drag <= _FREE:
            self._waited += step
            return 0.0
        return min(fastest, _CREEP)
