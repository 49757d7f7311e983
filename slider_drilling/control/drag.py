"""What the hook load tells of reach: weight that neither hook nor bit carries hangs on pipe that rocking left still.

Pipe that turns drags little along the hole. Off bottom, while it rocks, the hook load is tared; what it has fallen by
since, less the weight on bit, is the drag of the pipe that rocking does not reach. Where that grows while pressure
stays behind, what the block lowers no longer arrives: lock-up.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slider_drilling.wellbore.static_loads import static_loads

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

_TARE_TIME = 10.0      # s
_MEAN_TIME = 15.0      # s, a stroke or two
_LOCKED, _FREED = 0.6, 0.35   # share of the drag of a string that does not turn, on which lock-up trips and lets go
_ARRIVES = 0.85        # of the pressure asked for
_LOCKED_FOR = 10.0     # s


class DragMonitor:
    """weight_on_bit: N, and friction_factor: as believed, with which the drag of a string that does not turn is
    reckoned."""

    def __init__(self, rig: Rig, friction_factor: float, weight_on_bit: float):
        hanging = static_loads(rig).hook_load - weight_on_bit
        lowered = static_loads(rig, axial_speed=1.0, weight_on_bit=weight_on_bit, friction_coefficient=friction_factor)
        self._whole = max(hanging - lowered.hook_load, 1.0)
        self._hanging = self._hook = math.nan
        self._behind_for = 0.0
        self.drag = math.nan     # N
        self.share = math.nan    # of the drag of a string that does not turn
        self.locked = False      # weight no longer arrives

    def tare(self, hook_load: float, step: float) -> None:
        """Take a sample off bottom: N, s since the last one."""
        if math.isfinite(hook_load):
            if math.isnan(self._hanging):
                self._hanging = hook_load
            self._hanging += (1.0 - math.exp(-step / _TARE_TIME)) * (hook_load - self._hanging)

    def update(self, hook_load: float, weight_on_bit: float, friction: float, step: float) -> None:
        """Take a sample: N, N as believed from pressure, friction over its belief, s since the last one."""
        if not math.isfinite(hook_load):
            return
        if math.isnan(self._hook):
            self._hook = hook_load
        self._hook += (1.0 - math.exp(-step / _MEAN_TIME)) * (hook_load - self._hook)
        self.drag = self._hanging - self._hook - weight_on_bit
        self.share = self.drag / (self._whole * friction)

    def watch(self, pressure: float, asked: float, step: float) -> None:
        """Judge whether weight arrives: Pa across the motor, Pa that the auto-driller asks for."""
        behind = self.share > _LOCKED and pressure < _ARRIVES * asked
        self._behind_for = self._behind_for + step if behind else 0.0
        if self._behind_for >= _LOCKED_FOR:
            self.locked = True
        elif self.share < _FREED:
            self.locked = False
