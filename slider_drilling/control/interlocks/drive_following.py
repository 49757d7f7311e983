"""Drawworks and pump that do not do what is commanded, or whose sensors say so."""

from __future__ import annotations

import math

_BLOCK_WINDOW = 60.0     # s, after which a missing distance is forgotten while the block follows
_MISSING_DISTANCE, _FOUND_DISTANCE = 0.1, 0.03   # m by which the block lags behind its command: trips, releases
_PUMP_TOLERANCE = 0.03   # of the commanded speed: 5 % of the circulating pressure
_PUMP_TIME = 10.0        # s for a pump to reach its speed
_MAX_STEP_DISTANCE = 0.2   # m between two samples; more is a sensor that jumps


class DriveFollowing:
    """Compares block position and pump speed with what was commanded.

    Attributes:
        block_missing: Distance by which the block has moved less than commanded, m.
        block_follows: Whether the block moves as commanded.
        pump_follows: Whether the pump turns as commanded.
    """

    def __init__(self) -> None:
        self.block_missing = 0.0
        self.block_follows = True
        self.pump_follows = True
        self._position = math.nan   # m
        self._pump_off_for = 0.0    # s

    def update_block(self, position: float, commanded_speed: float, step: float) -> None:
        """Take one sample.

        Args:
            position: m; NaN where unknown.
            commanded_speed: Since the last sample, m/s.
            step: Time since then, s.
        """
        if step <= 0.0 or not math.isfinite(position):
            return
        moved = position - self._position if math.isfinite(self._position) else commanded_speed * step
        self._position = position
        if abs(moved) < _MAX_STEP_DISTANCE:
            self.block_missing += commanded_speed * step - moved
        if self.block_follows:   # afterwards only a block that moves makes up for it
            self.block_missing *= math.exp(-step / _BLOCK_WINDOW)
        limit = _MISSING_DISTANCE if self.block_follows else _FOUND_DISTANCE
        self.block_follows = self.block_missing <= limit

    def update_pump(self, speed: float, commanded_speed: float, step: float) -> None:
        """Take one sample: crank speed and its command rad/s, time since the last sample s."""
        off = math.isfinite(speed) and abs(speed - commanded_speed) > _PUMP_TOLERANCE * commanded_speed
        self._pump_off_for = self._pump_off_for + step if off else 0.0
        self.pump_follows = self._pump_off_for < _PUMP_TIME
