"""Rocking by torque limits: a stroke reverses where surface torque meets its limit, or a bump beyond it."""

from __future__ import annotations


class TorqueLimitedReversal:
    """Decides where strokes reverse by torque.

    A stroke towards the side of the centre setpoint continues beyond the limit by the missing centre shift:
    the bump with which a directional driller turns the bit.

    Args:
        right: Torque at which strokes to the right reverse, N m; 0: they reverse at the amplitude.
        left: The same for strokes to the left, N m.
    """

    def __init__(self, right: float, left: float):
        self.right = right
        self.left = left
        self._side = 0.0
        self._limit_angle: float | None = None   # rad, where this stroke met its limit
        self._last_limit_angle: dict[float, float] = {}   # side -> rad, where its last stroke met its limit

    def must_reverse(self, angle: float, torque: float, side: float, centre: float) -> bool:
        """Return whether the stroke ends here.

        Args:
            angle: Of the top drive, rad.
            torque: At surface, N m; NaN where unknown.
            side: +1 for a stroke to the right, -1 to the left.
            centre: Setpoint of the centre of rocking, rad.
        """
        if side != self._side:
            self._side, self._limit_angle = side, None
        limit = self.right if side > 0.0 else self.left
        if self._limit_angle is None and limit > 0.0 and side * torque >= limit:
            self._limit_angle = self._last_limit_angle[side] = angle
        if self._limit_angle is None:
            return False
        both_met = len(self._last_limit_angle) == 2
        shift = centre - 0.5 * (self._last_limit_angle[1.0] + self._last_limit_angle[-1.0]) if both_met else 0.0
        return side * (angle - self._limit_angle) >= max(0.0, side * shift)
