"""A block that comes down by itself, through a brake that slips: lifted back before its weight is on the bit.

Pipe along the wall holds what is lowered too fast for some seconds; then it arrives all at once, stalls the motor and
throws the toolface. The block's position shows it at once.
"""

from __future__ import annotations

import math

_SLIPPED, _BACK = 0.1, 0.02    # m below where it was told to be, from which it is lifted, and until which
_FORGOTTEN = 10.0              # s, over which drawworks that follow badly are forgiven
_FASTEST = 1.0                 # m/s; a position that leaps is a sensor's
_MOST = 1.0                    # m, that may have slipped; more is somebody else's doing


class BlockSlipInterlock:
    """below: m, of the block under where it was told to be; slips: how many there were."""

    def __init__(self) -> None:
        self.below = 0.0
        self.lifting = False
        self.slips = 0
        self._position = math.nan    # m

    def restart(self) -> None:
        """The block is being picked up or brought back: where it is, is where it should be."""
        self.below, self.lifting, self._position = 0.0, False, math.nan

    def update(self, position: float, told: float, step: float) -> bool:
        """Take a sample: m, NaN where there is none; m/s that the block was told since the last one, apart from being
        lifted; s. Whether it has to be lifted now: never without knowing where it is."""
        if step <= 0.0 or not math.isfinite(position):
            return False
        moved = position - self._position if math.isfinite(self._position) else 0.0
        self._position = position
        self.below += min(max(moved, -_FASTEST * step), _FASTEST * step) - told * step
        self.below = min(max(self.below * math.exp(-step / _FORGOTTEN), 0.0), _MOST)
        if self.below > _SLIPPED and not self.lifting:
            self.slips += 1
        self.lifting = self.below > (_BACK if self.lifting else _SLIPPED)
        return self.lifting
