"""Axial drag from the hook load: weight that hangs on pipe which rocking does not rotate.

Rotating pipe has little axial drag. The hook load is tared off bottom while the string rocks. What it has fallen by
since, less the weight on bit, is the drag of the pipe that rocking does not reach.
"""

from __future__ import annotations

import dataclasses
import math
import statistics
from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from slider_drilling.effects import BucklingContact
from slider_drilling.wellbore.static_loads import static_loads

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

_TARE_TIME = 10.0      # s, the last of the time off bottom
_AVERAGING_TIME = 15.0   # s, one stroke or two
_QUICK_TIME, _STROKE_SPREAD = 3.0, 3e3   # s and N, while weight comes on: strokes move the average of seconds so far
_BIT_SIGMA = 0.1       # share, one standard deviation of the bit's weight per torque
_FREE_DRAG, _HANGING_DRAG = 0.3, 0.55   # shares of drag: below, all lowered weight arrives; above, none does
_ROOM_SHARE = 0.1      # of the weight limit: room for drag that lets go, below which lowering slows down


class DragMonitor:
    """Drag of the string, absolute and as a share of the drag of a string that does not rotate.

    Args:
        rig: Rig file.
        friction_factor: Assumed friction factor.
        weight_on_bit: Weight on bit for the reference drag, N.

    Attributes:
        drag: N; NaN before the first sample.
        share: Over the drag of a string that does not rotate.
        share_lower_bound: `share` less one standard deviation.
    """

    def __init__(self, rig: Rig, friction_factor: float, weight_on_bit: float):
        # Drag by buckling is lock-up; it must not raise the reference that drag is compared with.
        rig = dataclasses.replace(rig, effects=dataclasses.replace(rig.effects, buckling_contact=BucklingContact()))
        rotating = static_loads(rig, weight_on_bit=weight_on_bit)
        sliding = static_loads(rig, axial_speed=1.0, weight_on_bit=weight_on_bit, friction_coefficient=friction_factor)
        self._depth = sliding.measured_depth
        self._drag_below = rotating.tension - sliding.tension   # N, of the non-rotating pipe below each depth
        self._full_drag = max(float(self._drag_below[0]), 1.0)
        self._friction_scale = 1.0
        self._off_bottom_load = self._load = self._quick_load = math.nan   # N
        self._tared = False
        self._tare_samples: deque[tuple[float, float]] = deque()   # s, N
        self._tare_clock = 0.0   # s off bottom
        self._weight = 0.0   # N on the bit, from pressure
        self.drag = math.nan
        self.share = math.nan
        self.share_lower_bound = math.nan

    def start_tared(self, off_bottom_load: float) -> None:
        """Use a hook load (N) that was measured off bottom, free of drag; `tare` then changes nothing."""
        self._off_bottom_load, self._tared = off_bottom_load, True

    def tare(self, hook_load: float, step: float) -> None:
        """Take one sample off bottom: hook load N, time since the last one s."""
        if math.isfinite(hook_load) and not self._tared:
            self._tare_clock += step
            self._tare_samples.append((self._tare_clock, hook_load))
            while self._tare_samples[0][0] < self._tare_clock - _TARE_TIME:
                self._tare_samples.popleft()
            # The median: a jolt as the string is set in motion must not stay in the tare.
            self._off_bottom_load = statistics.median(load for _, load in self._tare_samples)

    def update(
        self, hook_load: float, weight_on_bit: float, motor_sigma: float, friction_scale: float, step: float
    ) -> None:
        """Take one sample.

        Drag is a difference of two large forces, and in a short well it is small. The uncertainty of motor and bit is
        then as large as the drag, however deep the string rocks: `share_lower_bound` takes it off.

        Args:
            hook_load: N; NaN where unknown.
            weight_on_bit: From pressure, N.
            motor_sigma: One standard deviation of the motor's torque, as a share.
            friction_scale: Friction over the assumed friction factor.
            step: Time since the last sample, s.
        """
        if not math.isfinite(hook_load):
            return
        if math.isnan(self._load):
            self._load = self._quick_load = hook_load
        self._load += (1.0 - math.exp(-step / _AVERAGING_TIME)) * (hook_load - self._load)
        self._quick_load += (1.0 - math.exp(-step / _QUICK_TIME)) * (hook_load - self._quick_load)
        self._friction_scale = friction_scale
        self._weight = weight_on_bit
        self.drag = self._off_bottom_load - self._load - weight_on_bit
        full_drag = self._full_drag * friction_scale
        self.share = self.drag / full_drag
        self.share_lower_bound = self.share - math.hypot(motor_sigma, _BIT_SIGMA) * weight_on_bit / full_drag

    def deficit(self, hook_load: float) -> float:
        """What has left the hook since the string hung off bottom: weight on bit and drag, N."""
        return self._off_bottom_load - hook_load

    @property
    def smooth_deficit(self) -> float:
        """The same, averaged over a stroke or two, N; NaN before the first sample."""
        return self._off_bottom_load - self._load

    @property
    def highest_deficit(self) -> float:
        """The same, averaged over seconds where that is more: while weight comes on, N; NaN before the first sample."""
        return self._off_bottom_load - min(self._load, self._quick_load + _STROKE_SPREAD)

    @property
    def full_drag(self) -> float:
        """Drag of a string that does not rotate, with the friction known so far, N."""
        return self._full_drag * self._friction_scale

    @property
    def held_below(self) -> float:
        """Measured depth (m) below which non-rotating pipe would have this drag; the string's end without drag.

        It complements the reach computed from torque, which cannot see a section with more axial drag than the rest.
        """
        drag = self.drag / self._friction_scale if math.isfinite(self.drag) else 0.0
        return float(np.interp(-drag, -self._drag_below, self._depth))

    def room(self, weight_limit: float) -> float:
        """Weight (N) that may still be lowered before drag that lets go could pass the limit (N); NaN if unknown."""
        return weight_limit - self._weight - self.drag

    def transmitted_share(self, weight_limit: float) -> float:
        """Share of the lowering that is allowed: the rest would hang on the wall and come down suddenly later.

        Drag that the weight limit (N) has room for may hang: a short string has less drag than the bit may carry.
        """
        if not math.isfinite(self.share):
            return 1.0
        by_drag = (_HANGING_DRAG - self.share) / (_HANGING_DRAG - _FREE_DRAG)
        by_room = self.room(weight_limit) / (_ROOM_SHARE * weight_limit)
        return min(max(by_drag, by_room, 0.0), 1.0)
