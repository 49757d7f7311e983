"""Lock-up: the weight that the block lowers no longer arrives at the bit.

The interlock stops lowering while weight hangs on pipe that rocking does not free and pressure stays below its target.
Once the drag has been low for a while the slide resumes, with less weight after each trip, because the same weight
would lock the string again. A string that locks up for the third time, or that rocking does not free, stays stopped
until an operator gives another target or other settings.
"""

from __future__ import annotations

import enum

# Drag is a share of the drag of a string that does not rotate.
_TRIP_DRAG, _RELEASE_DRAG = 0.6, 0.35
_SLOW_TRIP_DRAG = 0.37       # trips too, after a longer time
_ARRIVING_SHARE = 0.85       # of the target pressure, below which weight does not arrive
_TRIP_TIME, _SLOW_TRIP_TIME = 20.0, 120.0   # s
_RELEASE_TIME = 30.0         # s of low drag before lowering resumes
_MAX_HOLD_TIME = 240.0       # s in which rocking has to free the string
_WEIGHT_REDUCTION = 0.9      # factor on the target weight at each trip
_MAX_TRIPS = 3
_LITTLE_ARRIVES = 0.45       # of the target pressure; a second lock-up with less latches


class LockUpState(enum.Enum):
    """State of the interlock."""

    FREE = "weight arrives at the bit"
    LESS = "the slide goes on with less weight"
    HELD = "lowering stopped until rocking has freed the string"
    LATCHED = "lowering stays stopped"


class LockUpInterlock:
    """Stops lowering at lock-up.

    Attributes:
        state: State of the interlock.
        trips: Lock-ups since the last `release`.
        share_left: Share of the target pressure that is still used as setpoint.
        never_freed: Whether it latched because rocking did not free the string.
    """

    def __init__(self) -> None:
        self.release()

    def release(self) -> None:
        """Start again, as after an operator has given another target or other settings."""
        self.state = LockUpState.FREE
        self.trips = 0
        self.share_left = 1.0
        self.never_freed = False
        self._locked_for = self._hanging_for = self._held_for = self._freed_for = 0.0

    @property
    def stops(self) -> bool:
        """Whether the block must not be lowered."""
        return self.state in (LockUpState.HELD, LockUpState.LATCHED)

    def update(self, drag: float, pressure: float, target: float, step: float) -> None:
        """Take one sample of sliding.

        Args:
            drag: Share of the drag of a string that does not rotate; NaN where unknown.
            pressure: Across the motor, Pa.
            target: Pressure setpoint, Pa.
            step: Time since the last sample, s.
        """
        if self.state is LockUpState.LATCHED:
            return
        if self.state is LockUpState.HELD:
            self._update_held(drag, step)
            return
        low = pressure < _ARRIVING_SHARE * target
        self._locked_for = self._locked_for + step if low and drag > _TRIP_DRAG else 0.0
        self._hanging_for = self._hanging_for + step if low and drag > _SLOW_TRIP_DRAG else 0.0
        if self._locked_for >= _TRIP_TIME or self._hanging_for >= _SLOW_TRIP_TIME:
            self.trips += 1
            self.share_left *= _WEIGHT_REDUCTION
            hopeless = self.trips > 1 and pressure < _LITTLE_ARRIVES * target
            self._enter(LockUpState.LATCHED if hopeless or self.trips >= _MAX_TRIPS else LockUpState.HELD)

    def _update_held(self, drag: float, step: float) -> None:
        self._held_for += step
        self._freed_for = self._freed_for + step if drag < _RELEASE_DRAG else 0.0
        if self._freed_for >= _RELEASE_TIME:
            self._enter(LockUpState.LESS)
        elif self._held_for >= _MAX_HOLD_TIME:
            self.never_freed = True
            self._enter(LockUpState.LATCHED)

    def _enter(self, state: LockUpState) -> None:
        self.state = state
        self._locked_for = self._hanging_for = self._held_for = self._freed_for = 0.0
