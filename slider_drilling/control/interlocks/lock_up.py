"""Lock-up: what the block lowers no longer arrives at the bit. An interlock that learns, and in the end latches.

Weight that hangs on pipe which rocking does not free, while pressure stays behind what is asked for, stops lowering.
Once the drag has been low for a while the slide goes on, with less weight each time: what locked the string would lock
it again. A string that locks for the third time, or that rocking does not free, stays stopped until an operator gives
another target or other settings.
"""

from __future__ import annotations

import enum

_LOCKED, _FREED = 0.6, 0.35   # share of the drag of a string that does not turn, on which it trips and may let go
_HANGING = 0.4         # ... from which on pressure that stays behind is lock-up too, only slower
_ARRIVES = 0.85        # of the pressure asked for
_LOCKED_FOR, _HANGING_FOR = 20.0, 180.0   # s
_FREED_FOR = 30.0      # s
_LONGEST = 240.0       # s, in which rocking has to free the string
_BACK_OFF = 0.9        # of the weight that was asked for, at each trip
_TRIPS = 3


class LockUpState(enum.Enum):
    """Where it stands."""

    FREE = "weight arrives at the bit"
    LESS = "the slide goes on with less weight"
    HELD = "lowering stopped until rocking has freed the string"
    LATCHED = "lowering stays stopped"


class LockUpInterlock:
    """share_left: of the pressure wanted, that may be asked for."""

    def __init__(self) -> None:
        self.release()

    def release(self) -> None:
        """An operator has asked for something else: begin again."""
        self.state = LockUpState.FREE
        self.trips = 0
        self.share_left = 1.0
        self.never_freed = False    # whether it latched because rocking did not free the string
        self._locked_for = self._hanging_for = self._held_for = self._freed_for = 0.0

    @property
    def stops(self) -> bool:
        """Whether the block must not be lowered."""
        return self.state in (LockUpState.HELD, LockUpState.LATCHED)

    def update(self, drag: float, pressure: float, asked: float, step: float) -> None:
        """Take a sample of sliding. drag: share of that of a string that does not turn, NaN where unknown; pressure: Pa
        across the motor, asked: Pa that is wanted in the end; step: s since the last one."""
        if self.state is LockUpState.LATCHED:
            return
        if self.state is LockUpState.HELD:
            self._held_for += step
            self._freed_for = self._freed_for + step if drag < _FREED else 0.0
            if self._freed_for >= _FREED_FOR:
                self._enter(LockUpState.LESS)
            elif self._held_for >= _LONGEST:
                self.never_freed = True
                self._enter(LockUpState.LATCHED)
            return
        behind = pressure < _ARRIVES * asked
        self._locked_for = self._locked_for + step if behind and drag > _LOCKED else 0.0
        self._hanging_for = self._hanging_for + step if behind and drag > _HANGING else 0.0
        if self._locked_for >= _LOCKED_FOR or self._hanging_for >= _HANGING_FOR:
            self.trips += 1
            self.share_left *= _BACK_OFF
            self._enter(LockUpState.LATCHED if self.trips >= _TRIPS else LockUpState.HELD)

    def _enter(self, state: LockUpState) -> None:
        self.state = state
        self._locked_for = self._hanging_for = self._held_for = self._freed_for = 0.0
