"""The load on the bit: on bottom or off, hardly loaded, being loaded."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

_LOADING_S, _MEMORY_S = 300.0, 40  # after the bit came on bottom, in which it is loaded; seconds looked at
_LONGEST_LIFT_S = 20.0  # without weight, that a bit which stays on bottom may show within a rocking period
_STEADY = 0.15  # of the weight on bit, within which it is steady
_LIGHT, _LOADED = 0.12, 0.2  # of the largest load: the bit hardly drills below the first, until it exceeds the second


class BitLoad:
    """Follows the plant's weight on bit. Weight is compared over rocking periods: it swings within one.

    Attributes:
        share: Mean of the last rocking period, of the largest mean so far.
        light: Whether the bit hardly drills.
    """

    def __init__(self) -> None:
        self._loads: deque[float] = deque(maxlen=_MEMORY_S)
        self._on_bottom_at = self._on_bottom_since = -math.inf
        self._largest = 1.0
        self.share, self.light = 0.0, False

    def add(self, weight_on_bit: float, now: float, period: float) -> None:
        """Take the mean weight, N, of the second that ends now, s; period: of the rocking, s."""
        if weight_on_bit > 0.0:
            self._on_bottom_at = now
        if self.off_bottom(now, period):
            self._on_bottom_since = now
        self._loads.append(weight_on_bit)
        if math.isfinite(weight_on_bit):
            self._largest = max(self._largest, float(np.mean(self._loads)))
            self.share = float(np.mean(list(self._loads)[-max(round(period), 1) :])) / self._largest
            self.light = self.share < (_LOADED if self.light else _LIGHT)

    def off_bottom(self, now: float, period: float) -> bool:
        """Without weight for a whole rocking period: a momentary lift is none."""
        return now - self._on_bottom_at >= min(period, _LONGEST_LIFT_S)

    def is_rising(self, now: float) -> bool:
        """Whether the bit has come on bottom and is being loaded."""
        if now - self._on_bottom_since >= _LOADING_S:
            return False
        half = len(self._loads) // 2
        loads = np.array(self._loads)
        steady = half and abs(np.mean(loads[:half]) - np.mean(loads[half:])) < _STEADY * np.mean(loads)
        return not steady or half < _MEMORY_S // 2
