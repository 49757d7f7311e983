"""A block that slips through its brake: lifted back before the extra weight reaches the bit.

The wall holds pipe that is lowered too fast for some seconds. Then the weight arrives suddenly, stalls the motor and
throws the toolface. The block position shows the slip before that.
"""

from __future__ import annotations

import math

_TRIP_DISTANCE, _RELEASE_DISTANCE = 0.1, 0.02   # m below the commanded position
_FORGET_TIME = 10.0    # s; drawworks that follow inaccurately do not add up to a slip
_MAX_SPEED = 1.0       # m/s; a faster change of position is a sensor error
_MAX_DISTANCE = 1.0    # m; more is no slip of the brake


class BlockSlipInterlock:
    """Lifts a block that came down by itself.

    Attributes:
        below: Distance of the block below its commanded position, m.
        lifting: Whether the block has to be lifted now.
        slips: Slips so far.
    """

    def __init__(self) -> None:
        self.below = 0.0
        self.lifting = False
        self.slips = 0
        self._position = math.nan    # m

    def restart(self) -> None:
        """Take the present position as the commanded one, as after picking up."""
        self.below, self.lifting, self._position = 0.0, False, math.nan

    def update(self, position: float, commanded_speed: float, step: float) -> bool:
        """Take one sample.

        Args:
            position: Of the block, m, positive down; NaN where unknown.
            commanded_speed: Since the last sample, without lifting, m/s.
            step: Time since the last sample, s.

        Returns:
            Whether the block has to be lifted now; never while its position is unknown.
        """
        if step <= 0.0 or not math.isfinite(position):
            return False
        moved = position - self._position if math.isfinite(self._position) else 0.0
        self._position = position
        self.below += min(max(moved, -_MAX_SPEED * step), _MAX_SPEED * step) - commanded_speed * step
        self.below = min(max(self.below * math.exp(-step / _FORGET_TIME), 0.0), _MAX_DISTANCE)
        if self.below > _TRIP_DISTANCE and not self.lifting:
            self.slips += 1
        self.lifting = self.below > (_RELEASE_DISTANCE if self.lifting else _TRIP_DISTANCE)
        return self.lifting
