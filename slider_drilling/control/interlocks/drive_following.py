"""Drawworks and pump that do not do what is commanded, or whose sensors say so."""

from __future__ import annotations

import math

_BLOCK_WINDOW = 60.0     # s, after which a missing distance is forgotten while the block follows
_MISSING_DISTANCE, _FOUND_DISTANCE = 0.1, 0.03   # m by which the block lags behind its command: trips, releases
_PUMP_TOLERANCE = 0.03   # of the commanded speed: 5 % of the circulating pressure
_PUMP_TIME = 10.0        # s for a pump to reach its speed
_MAX_STEP_DISTANCE = 0.2   # m between two samples; more is a sensor that jumps
_JUMP_MEMORY = 600.0       # s for which such a jump is reported
# Distance commanded (m) over which the one that the block shows is compared with it, and how far (share) it may be off.
_SCALE_DISTANCE, _SCALE_TOLERANCE = 0.5, 0.1
_DRIVE_TIME, _DRIVE_TOLERANCE = 60.0, 0.5   # s, rad: mean of the top drive's distance from its reference


class DriveFollowing:
    """Compares block position and pump speed with what was commanded.

    Attributes:
        block_missing: Distance by which the block has moved less than commanded, m.
        block_follows: Whether the block moves as commanded.
        pump_follows: Whether the pump turns as commanded.
        block_fault: What else is wrong with the block's position; "" if nothing.
        drive_offset: Mean distance of the top drive from its reference, rad.
    """

    def __init__(self) -> None:
        self.block_missing = 0.0
        self.block_follows = True
        self.pump_follows = True
        self.block_fault = ""
        self.drive_offset = 0.0
        self._position = math.nan   # m
        self._commanded = self._moved = 0.0   # m, since the last comparison
        self._jump_left = 0.0       # s for which a jump is still reported
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
        self._jump_left -= step
        if abs(moved) < _MAX_STEP_DISTANCE:
            self.block_missing += commanded_speed * step - moved
            self._compare_distance(commanded_speed * step, moved)
        else:
            self._jump_left = _JUMP_MEMORY
            self.block_fault = f"the block's position jumped by {moved:+.2f} m between two samples: check its sensor"
        if self.block_follows:   # afterwards only a block that moves makes up for it
            self.block_missing *= math.exp(-step / _BLOCK_WINDOW)
        limit = _MISSING_DISTANCE if self.block_follows else _FOUND_DISTANCE
        self.block_follows = self.block_missing <= limit

    def _compare_distance(self, commanded: float, moved: float) -> None:
        """Compare the distances (m) of the block over half a metre: a sensor with a wrong gain, or one that drifts."""
        self._commanded += commanded
        self._moved += moved
        if abs(self._commanded) < _SCALE_DISTANCE:
            return
        share = self._moved / self._commanded
        self._commanded = self._moved = 0.0
        if abs(share - 1.0) > _SCALE_TOLERANCE:
            self.block_fault = (f"the block's position shows {share:.0%} of the distance that was commanded: check its "
                                "sensor and the drawworks")
        elif self._jump_left <= 0.0:
            self.block_fault = ""

    def update_drive(self, tracking_error: float, step: float) -> None:
        """Take one sample: angle of the top drive minus its reference, rad; time since the last sample, s."""
        if math.isfinite(tracking_error):
            self.drive_offset += (1.0 - math.exp(-step / _DRIVE_TIME)) * (tracking_error - self.drive_offset)

    @property
    def drive_follows(self) -> bool:
        """Whether the top drive is where its reference is on average."""
        return abs(self.drive_offset) <= _DRIVE_TOLERANCE

    def update_pump(self, speed: float, commanded_speed: float, step: float) -> None:
        """Take one sample: crank speed and its command rad/s, time since the last sample s."""
        off = math.isfinite(speed) and abs(speed - commanded_speed) > _PUMP_TOLERANCE * commanded_speed
        self._pump_off_for = self._pump_off_for + step if off else 0.0
        self.pump_follows = self._pump_off_for < _PUMP_TIME
