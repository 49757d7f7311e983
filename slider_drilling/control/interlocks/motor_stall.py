"""Motor stall: pressure spike, stop lowering, pick up, wait, resume."""

from __future__ import annotations

import enum

_CONFIRM_TIME = 0.5       # s of stall pressure before picking up
_CLEARED_SHARE = 0.9      # of the stall limit, below which an unconfirmed stall is dropped
_RELEASE_TIME = 2.0       # s for the motor to turn again
_PICK_UP_TIMEOUT = 120.0  # s


class StallState(enum.Enum):
    """Stage in the handling of a motor stall."""

    NONE = "no stall"
    SUSPECTED = "pressure spike: lowering stopped"
    PICKING_UP = "motor stalled: picking up"
    LETTING_GO = "bit is free: waiting for the motor to turn"


class StallGuard:
    """Detects a motor stall and steps through its handling.

    Args:
        limit: Pressure across the motor that counts as stall, Pa.
        released: Pressure below which the bit is off bottom, Pa.

    Attributes:
        state: Stage of the handling.
        count: Stalls so far.
    """

    def __init__(self, limit: float, released: float):
        self.limit = limit
        self.released = released
        self.state = StallState.NONE
        self.count = 0
        self._since = 0.0

    def update(self, pressure: float, known: bool, step: float) -> None:
        """Take one sample.

        Args:
            pressure: Across the motor, Pa.
            known: Whether the pressure is measured now; while it is not, the state stays.
            step: Time since the last sample, s.
        """
        self._since += step
        if not known:
            return
        if self.state is StallState.NONE and pressure >= self.limit:
            self._enter(StallState.SUSPECTED)
        elif self.state is StallState.SUSPECTED:
            if pressure < _CLEARED_SHARE * self.limit:
                self._enter(StallState.NONE)
            elif self._since >= _CONFIRM_TIME:
                self.count += 1
                self._enter(StallState.PICKING_UP)
        elif self.state is StallState.PICKING_UP and (pressure <= self.released or self._since >= _PICK_UP_TIMEOUT):
            self._enter(StallState.LETTING_GO)
        elif self.state is StallState.LETTING_GO and self._since >= _RELEASE_TIME:
            self._enter(StallState.NONE)

    def _enter(self, state: StallState) -> None:
        self.state, self._since = state, 0.0
