"""What the hook load tells of reach: weight that neither hook nor bit carries hangs on pipe that rocking left still.

Pipe that turns drags little along the hole. Off bottom, while it rocks, the hook load is tared; what it has fallen by
since, less the weight on bit, is the drag of the pipe that rocking does not reach.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from slider_drilling.effects import BucklingContact
from slider_drilling.wellbore.static_loads import static_loads

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

_TARE_TIME = 10.0      # s
_MEAN_TIME = 15.0      # s, a stroke or two
_BIT = 0.1             # share, one sigma of a bit's weight per torque
_ARRIVES, _HANGS = 0.3, 0.55   # shares of drag, up to which all that is lowered arrives, and from which on nothing does


class DragMonitor:
    """weight_on_bit: N, and friction_factor: as believed, with which the drag of a string that does not turn is
    reckoned."""

    def __init__(self, rig: Rig, friction_factor: float, weight_on_bit: float):
        # What buckling holds is lock-up, not the drag to measure it by.
        rig = dataclasses.replace(rig, effects=dataclasses.replace(rig.effects, buckling_contact=BucklingContact()))
        turned = static_loads(rig, weight_on_bit=weight_on_bit)
        lowered = static_loads(rig, axial_speed=1.0, weight_on_bit=weight_on_bit, friction_coefficient=friction_factor)
        self._depth = lowered.measured_depth
        self._below = turned.tension - lowered.tension   # N, drag of the pipe below each depth where it does not turn
        self._whole = max(float(self._below[0]), 1.0)
        self._friction = 1.0
        self._hanging = self._hook = math.nan
        self.drag = math.nan     # N
        self.share = math.nan    # of the drag of a string that does not turn
        self.certain = math.nan  # the same, less one sigma

    def tare(self, hook_load: float, step: float) -> None:
        """Take a sample off bottom: N, s since the last one."""
        if math.isfinite(hook_load):
            if math.isnan(self._hanging):
                self._hanging = hook_load
            self._hanging += (1.0 - math.exp(-step / _TARE_TIME)) * (hook_load - self._hanging)

    def update(
        self, hook_load: float, weight_on_bit: float, motor_sigma: float, friction: float, step: float
    ) -> None:
        """Take a sample: N, N as believed from pressure, one sigma of the motor's torque as a share, friction over its
        belief, s since the last one.

        Drag is a difference of two large forces, and in a short well it is small: what motor and bit leave open of the
        weight is then as large, and does not fall however deep the string is rocked.
        """
        if not math.isfinite(hook_load):
            return
        if math.isnan(self._hook):
            self._hook = hook_load
        self._hook += (1.0 - math.exp(-step / _MEAN_TIME)) * (hook_load - self._hook)
        self._friction = friction
        self.drag = self._hanging - self._hook - weight_on_bit
        whole = self._whole * friction
        self.share = self.drag / whole
        self.certain = self.share - math.hypot(motor_sigma, _BIT) * weight_on_bit / whole

    @property
    def held_below(self) -> float:
        """Measured depth (m) below which pipe that does not turn would drag as much: the string's end where none is
        known of. What torque says of the reach of rocking is blind to pipe that drags more than the rest."""
        drag = self.drag / self._friction if math.isfinite(self.drag) else 0.0
        return float(np.interp(-drag, -self._below, self._depth))

    @property
    def arriving(self) -> float:
        """Share of what is lowered that may be lowered: the rest would hang on the wall, to come down all at once."""
        if not math.isfinite(self.share):
            return 1.0
        return min(max((_HANGS - self.share) / (_HANGS - _ARRIVES), 0.0), 1.0)
