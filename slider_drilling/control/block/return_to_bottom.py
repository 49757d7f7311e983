"""Return to bottom after picking up.

Where the bit touches bottom is known from drilling, so most of the way is quick. Lowering leaves weight hanging on the
wall. Rocking frees it onto the bit within seconds of touching, and the reactive torque then throws the toolface. So the
block rests just above bottom until drag has fallen.
"""

from __future__ import annotations

import math

_AVERAGING_TIME = 30.0   # s, of the touching point: a block that slips must not move it
_SLOW_DOWN_TIME = 2.0    # s, time constant with which the block slows down to its rest
_FAST_SPEED = 0.03       # m/s; a string that slides faster turns easily
_CREEP_SPEED = 0.004     # m/s, from the rest down to bottom
_REST_HEIGHT = 0.25      # m above the touching point
_FREE_DRAG = 0.2         # share of the drag of a string that does not rotate
_MAX_REST_TIME = 40.0    # s


class ReturnToBottom:
    """Brings the bit back to bottom after it was lifted.

    Args:
        stiffness: Of the string between block and bit, N/m.
        weight_per_pressure: Weight on bit over pressure across the motor, N/Pa.

    Attributes:
        under_way: The bit is off bottom.
        fast: The string slides fast, or has just done so.
    """

    def __init__(self, stiffness: float, weight_per_pressure: float):
        self._stiffness = stiffness
        self._weight_per_pressure = weight_per_pressure
        self._touching_position = math.nan    # m, of the block when the bit just touches
        self._rested = 0.0                    # s
        self.under_way = False
        self.fast = False

    def pick_up(self) -> None:
        """Record that the bit is lifted."""
        self.under_way = self.fast = True
        self._rested = 0.0

    def start_off_bottom(self, touching_position: float) -> None:
        """Record that a slide begins off bottom, and at which position of the block (m) the bit will touch it."""
        self._touching_position = touching_position
        self.pick_up()

    def touched(self) -> None:
        """Record that the bit is on bottom again."""
        self.under_way = self.fast = False

    def update_touching_position(self, block_position: float, pressure: float, step: float) -> None:
        """Take one sample of drilling: block position m, pressure across the motor Pa, time since the last one s."""
        touching = block_position - self._weight_per_pressure * max(pressure, 0.0) / self._stiffness
        if not math.isfinite(self._touching_position):
            self._touching_position = touching
        weight = 1.0 - math.exp(-step / _AVERAGING_TIME)
        self._touching_position += weight * (touching - self._touching_position)

    def speed(self, block_position: float, max_speed: float, drag: float, step: float) -> float:
        """Block speed: fast to just above bottom, a rest until drag has fallen, then a creep.

        Args:
            block_position: m.
            max_speed: m/s.
            drag: Share of the drag of a string that does not rotate; NaN where unknown.
            step: Time since the last sample, s.

        Returns:
            m/s, positive lowers.
        """
        left = self._touching_position - _REST_HEIGHT - block_position
        speed = left / _SLOW_DOWN_TIME if math.isfinite(left) else _CREEP_SPEED
        self.fast = speed > _FAST_SPEED
        if speed > _CREEP_SPEED:
            return min(max_speed, speed)
        if self._rested < _MAX_REST_TIME and not drag <= _FREE_DRAG:
            self._rested += step
            return 0.0
        return min(max_speed, _CREEP_SPEED)
