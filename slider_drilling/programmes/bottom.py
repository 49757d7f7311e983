"""Where bottom is at least, and whether the bit is off it for certain, from block and hook load.

The string hangs free at the start; there the bit is as deep as the block says. Later, with ``D`` what has left the hook
since, every element carries at most ``D`` less than then, so the string of stiffness k is shorter by at most ``D / k``
while it is lowered, and longer by at most ``-D / k`` after it was lifted:

* lowered to a new depth z of the block, the bit has been at ``z - D / k`` at least, and bottom is not above that;
* the bit is at ``z + U / k`` at most, with U the largest upward drag since the block was lifted.
"""

from __future__ import annotations

import math

_MARGIN = 0.15  # m: stretch by temperature and pressure, waves, play of the block's encoder
_LAG = 2.0  # s by which the smoothed hook load is behind the block
_NEW_DEPTH = 1e-3  # m


class BottomTracker:
    """Bounds of bottom and bit.

    Args:
        stiffness: Of the string between block and bit, N/m.
        block: Position of the block at the start, m lowered.
        bit_height: Of the bit above bottom at the start, m.

    Attributes:
        deepest: Position of the block at which the bit was deepest so far, or bottom at the start, m.
        touching: Position of the block at which the bit touches bottom without weight, as far as pressure tells, m.
        surely_off: Whether the bit cannot touch bottom.
    """

    def __init__(self, stiffness: float, block: float, bit_height: float) -> None:
        self._stiffness = stiffness
        self._highest_bottom = block + bit_height
        self._up_drag = 0.0  # N, largest since the block was lifted
        self.deepest = self.touching = block + bit_height
        self.surely_off = False

    def update(self, block: float, speed: float, deficit: float, weight: float | None) -> None:
        """Take one sample.

        Args:
            block: Position, m lowered.
            speed: Of the block, m/s.
            deficit: What has left the hook since the string hung free, smoothed, N; negative where it carries more.
            weight: On the bit by pressure, N; None where pressure does not show it now.
        """
        if not (math.isfinite(block) and math.isfinite(deficit)):
            return
        if block >= self.deepest - _NEW_DEPTH:
            moving = _LAG * max(speed, 0.0)
            shorter = max(deficit, 0.0) / self._stiffness
            self._highest_bottom = max(self._highest_bottom, block - moving - shorter - _MARGIN)
            self.deepest = max(self.deepest, block)
            self._up_drag = 0.0
            if weight is not None:
                self.touching = max(self.touching, block - weight / self._stiffness)
        self._up_drag = max(self._up_drag, -deficit)
        lowest_bit = block + _LAG * max(speed, 0.0) + self._up_drag / self._stiffness
        self.surely_off = lowest_bit + _MARGIN < self._highest_bottom
