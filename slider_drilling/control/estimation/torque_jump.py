"""A mean surface torque that jumps while neither top drive nor motor change it: the sensor, not the string.

Three things change the mean over a rocking cycle: the centre of rocking, by its angle over the compliance; the reactive
torque; and a bit that the wall lets go, by half a turn at most over the compliance. A drive that turns only the upper
part of the string meets a stiffer one, so twice the first two may show.
"""

from __future__ import annotations

import math
from collections import deque

from slider_drilling.control.estimation.cycle_average import CycleAverage

JUMP_STROKES = 4  # strokes between two averages; one before the last shows part of a jump, the last all of it
_STIFFER = 2.0  # most that an upper part of the string is stiffer than the whole
_TURN = math.pi  # rad that a bit may turn between them
_UNEXPLAINED = 0.3  # of the target torque, besides


class TorqueJump:
    """Compares the averages of cycles, stroke by stroke.

    Attributes:
        size: Jump that the last average has shown, N m; 0 for none.
    """

    def __init__(self) -> None:
        self.size = 0.0
        self._cycles: deque[CycleAverage] = deque(maxlen=JUMP_STROKES + 1)
        self._seen = False  # in the last average

    def forget(self) -> None:
        """Start again, as after a cycle without measurement or after picking up."""
        self._cycles.clear()
        self.size, self._seen = 0.0, False

    def update(self, cycle: CycleAverage, compliance: float, target_torque: float) -> None:
        """Take the average of a cycle.

        Args:
            cycle: That has just ended.
            compliance: Of the string, rad/(N m).
            target_torque: Reactive torque at the target weight, N m.
        """
        self.size = 0.0
        self._cycles.append(cycle)
        if len(self._cycles) <= JUMP_STROKES:
            return
        change = self._unexplained(cycle, self._cycles[0 if self._seen else 1], compliance, target_torque)
        if change and self._seen:
            self._cycles.clear()
            self.size = change
        self._seen = bool(change) and not self._seen

    def _unexplained(
        self, cycle: CycleAverage, before: CycleAverage, compliance: float, target_torque: float
    ) -> float:  # fmt: skip
        """Change of the mean torque (N m) between two averages less what explains it; 0 where that may be all."""
        parts = ((cycle.angle - before.angle) / compliance, cycle.reactive_torque - before.reactive_torque)
        free = _TURN / compliance + _UNEXPLAINED * target_torque
        change = cycle.torque - before.torque
        least, most = (_STIFFER * sum(limit(0.0, part) for part in parts) for limit in (min, max))
        return 0.0 if least - free <= change <= most + free else change - 0.5 * sum(parts)
