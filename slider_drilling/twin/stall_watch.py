"""A stalled motor, by the pressure across it.

The plants beside the rig carry more than its motor, so that they do not stall with it: a stall is no change of the rig
that a comparison with them would show. The pressure across a motor that stalls is the one at which it stalls.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.rig import Rig
from slider_drilling.twin.samples import Array

_STALLED, _TURNS = 0.95, 0.8  # of the pressure at which the motor stalls, from which and up to which
_CONFIRM_S = 3  # of that pressure in a row
_PUMP_S = 30  # of the pump's past: pressure needs some time to follow a flow that is lowered


@dataclass(frozen=True)
class MotorStall:
    """A stall.

    Attributes:
        since: s, when the pressure came up.
        pressure: Pa, the most across the motor, as a mean over a second.
        limit: Pa, at which the rig file's motor stalls.
        ended: s, when the motor turned again; None before.
    """

    since: float
    pressure: float
    limit: float
    ended: float | None = None

    def pressures(self) -> str:
        """The two pressures in words."""
        return f"{1e-5 * self.pressure:.0f} bar across it, and it stalls at {1e-5 * self.limit:.0f} bar"


class StallWatch:
    """Watches the pressure across a motor second by second.

    Args:
        rig: The rig file.

    Attributes:
        stall: The latest; None before the first.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig, self._limit = rig, rig.motor.pressure_at_stall
        self._circulation: deque[float] = deque(maxlen=_PUMP_S)
        self._high: list[float] = []  # pressures of the seconds in a row that are high
        self.stall: MotorStall | None = None

    @property
    def stalls(self) -> bool:
        """Whether the motor stalls now."""
        return self.stall is not None and self.stall.ended is None

    def update(self, commands: Commands, pressure: Array, gain: float) -> None:
        """Take a second.

        Args:
            commands: Of that second, (n,).
            pressure: At the standpipe, Pa, (n,), NaN where it was not measured.
            gain: Circulating pressure over the rig file's.
        """
        self._circulation.append(float(np.max(self._rig.circulation_at(commands.pump_speed))))
        pumping = commands.pump_speed[-1] > 0.0
        across = float(np.mean(pressure)) - gain * max(self._circulation) if pumping else 0.0
        if math.isnan(across):
            self._high = []
            return
        begin, present = float(commands.time[0]), self.stall
        if present is not None and self.stalls:
            over = across < _TURNS * self._limit
            self.stall = replace(present, pressure=max(present.pressure, across), ended=begin if over else None)
            return
        self._high = [*self._high, across] if across >= _STALLED * self._limit else []
        if len(self._high) == _CONFIRM_S:
            self.stall = MotorStall(begin - (_CONFIRM_S - 1.0), max(self._high), self._limit)
            self._high = []
