"""Rocking by torque limits: a stroke ends where surface torque meets its limit, or a bump beyond."""

from __future__ import annotations


class TorqueLimitedReversal:
    """right, left: N m at which a stroke to that side ends; 0 leaves that side to the amplitude.

    A stroke towards the side on which the centre is wanted goes on beyond the limit by the missing shift: the bump
    that turns the bit.
    """

    def __init__(self, right: float, left: float):
        self.right = right
        self.left = left
        self._side = 0.0
        self._met: float | None = None          # rad, where this stroke met its limit
        self._turned: dict[float, float] = {}   # side -> rad, where its last stroke met its limit

    def must_reverse(self, angle: float, torque: float, side: float, centre: float) -> bool:
        """Whether the stroke towards `side` ends here. angle, wanted centre: rad; torque: N m, NaN if unknown."""
        if side != self._side:
            self._side, self._met = side, None
        limit = self.right if side > 0.0 else self.left
        if self._met is None and limit > 0.0 and side * torque >= limit:
            self._met = self._turned[side] = angle
        if self._met is None:
            return False
        both = len(self._turned) == 2
        shift = centre - 0.5 * (self._turned[1.0] + self._turned[-1.0]) if both else 0.0
        return side * (angle - self._met) >= max(0.0, side * shift)
