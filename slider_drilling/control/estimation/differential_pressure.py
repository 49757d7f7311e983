"""What the motor takes: standpipe pressure less what circulation alone would need at this flow."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

_FLOW_EXPONENT = 1.8
_LEAST_FLOW = 0.8    # of the reference flow, to tare
_MOST_TARE = 0.06    # of the rig file's off-bottom pressure
_TARE_TIME = 8.0     # s


class DifferentialPressure:
    """Pressure across the motor (Pa) and the reactive torque (N m) that it means, filtered for two purposes.

    `quick` follows within a second or so and watches for stall; `smooth` feeds control. off_bottom_pressure: Pa at
    the reference flow, off bottom; 0 takes the rig file's until `tare` has seen the rig's own. Without a sample both
    hold their last value.
    """

    def __init__(self, rig: Rig, off_bottom_pressure: float, quick_time: float, smooth_time: float):
        self.configure(rig, off_bottom_pressure)
        self._reference_speed = rig.hydraulics.reference_flow / rig.mud_pump.displacement
        self._torque_per_pressure = rig.motor.torque_per_pressure
        self._times = (quick_time, smooth_time)
        self.quick = 0.0
        self.smooth = 0.0

    def configure(self, rig: Rig, off_bottom_pressure: float) -> None:
        """Another off-bottom pressure from now on."""
        self._given = off_bottom_pressure > 0.0
        self._believed = rig.circulating_pressure
        self._off_bottom = off_bottom_pressure or self._believed

    def tare(self, standpipe_pressure: float, pump_speed: float, step: float) -> None:
        """Take one sample without weight on bit, before `update`: what is measured is circulation. A string that drills
        already would show far more than a rig file is wrong by, and is not believed."""
        flow = pump_speed / self._reference_speed
        if self._given or not (math.isfinite(standpipe_pressure) and flow >= _LEAST_FLOW):
            return
        seen = standpipe_pressure / flow**_FLOW_EXPONENT
        if abs(seen / self._believed - 1.0) <= _MOST_TARE:
            self._off_bottom += (1.0 - math.exp(-step / _TARE_TIME)) * (seen - self._off_bottom)

    def update(self, standpipe_pressure: float, pump_speed: float, step: float) -> None:
        """Take one sample: Pa, rad/s of the pump's crank, s since the last one."""
        if not (math.isfinite(standpipe_pressure) and math.isfinite(pump_speed)):
            return
        flow = max(pump_speed, 0.0) / self._reference_speed
        pressure = standpipe_pressure - self._off_bottom * flow**_FLOW_EXPONENT
        self.quick += (1.0 - math.exp(-step / self._times[0])) * (pressure - self.quick)
        self.smooth += (1.0 - math.exp(-step / self._times[1])) * (pressure - self.smooth)

    @property
    def reactive_torque(self) -> float:
        """Torque (N m) with which the motor turns its housing to the left, from `smooth`."""
        return self._torque_per_pressure * max(self.smooth, 0.0)

    @property
    def quick_reactive_torque(self) -> float:
        """The same from `quick`, for what is averaged anyway."""
        return self._torque_per_pressure * self.quick
