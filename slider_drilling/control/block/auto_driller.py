"""Auto-driller: block speed that holds a differential pressure, and with it the reactive torque."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

# Default response time: a longer string releases weight later, and suddenly where the weight hung on the wall.
_TIME_PER_METRE, _MIN_TIME = 5.4e-3, 18.0   # s/m, s
_INTEGRAL_TIME_RATIO = 10.0                 # integral time over response time


class AutoDriller:
    """PI control of differential pressure, with the block speed of the rig file's bit and motor as feed-forward.

    The string is a spring of stiffness k between block and bit. A block that is faster than the bit drills by v loads
    the bit by ``k v`` N/s. The proportional gain makes a pressure error decay with the time constant `response_time`.

    Args:
        rig: Rig file.
        response_time: s; 0 for one that suits the length of the string.
        max_block_speed: m/s.

    Attributes:
        weight_per_pressure: Weight on bit over pressure across the motor, N/Pa.
        speed_per_pressure: Rate of penetration over pressure across the motor, m/(s Pa).
        setpoint: Ramped pressure setpoint, Pa.
    """

    def __init__(self, rig: Rig, response_time: float, max_block_speed: float):
        motor_speed = 2.0 * math.pi * rig.hydraulics.reference_flow / rig.motor.displacement   # rad/s
        self.weight_per_pressure = rig.motor.torque_per_pressure / rig.bit.lever
        cutting = 2.0 * math.pi * rig.bit.depth_of_cut_stiffness / motor_speed                 # N s/m
        self.speed_per_pressure = self.weight_per_pressure / cutting
        self.configure(rig, response_time, max_block_speed)
        self._integral = 0.0     # m/s
        self.setpoint = 0.0

    def pressure_for(self, rate_of_penetration: float) -> float:
        """Differential pressure (Pa) at which the rig file's bit drills at this rate (m/s)."""
        return rate_of_penetration / self.speed_per_pressure

    def configure(self, rig: Rig, response_time: float, max_block_speed: float) -> None:
        """Use another response time (s, 0 for the default) and maximum block speed (m/s) from now on."""
        response_time = response_time or max(_TIME_PER_METRE * rig.string.length, _MIN_TIME)
        self._gain = self.weight_per_pressure / (rig.string.axial_stiffness * response_time)      # m/(s Pa)
        self._integral_time = _INTEGRAL_TIME_RATIO * response_time
        self._max_block_speed = max_block_speed

    def restart(self) -> None:
        """Start again from no weight on bit, as after picking up."""
        self.setpoint = 0.0
        self._integral = 0.0

    def track(self, pressure: float) -> None:
        """Lower the setpoint to the present pressure (Pa) while lowering is stopped (bumpless transfer)."""
        self.setpoint = min(self.setpoint, max(pressure, 0.0))
        self._integral = 0.0

    def update(
        self, pressure: float, target: float, ramp: float, step: float, transmitted_share: float = 1.0
    ) -> float:
        """Return the block speed, m/s.

        Args:
            pressure: Across the motor, Pa.
            target: Final setpoint of the ramp, Pa.
            ramp: Fastest rise of the setpoint, Pa/s.
            step: Time since the last sample, s.
            transmitted_share: Factor on the speed beyond what the bit drills; below 0 it takes weight off the bit.
        """
        change = target - self.setpoint
        rise = min(change, max(transmitted_share, 0.0) * ramp * step)
        self.setpoint += rise if change > 0.0 else max(change, -ramp * step)
        error = self.setpoint - pressure
        feed_forward = self.speed_per_pressure * self.setpoint
        speed = feed_forward + self._gain * error + self._integral
        drilled = self.speed_per_pressure * max(pressure, 0.0)
        if speed > drilled:
            speed = drilled + transmitted_share * (speed - drilled)
        # Anti-windup: integrate only at the final setpoint and while nothing limits the speed.
        if change == 0.0 and transmitted_share == 1.0 and 0.0 < speed < self._max_block_speed:
            self._integral += self._gain * error * step / self._integral_time
            self._integral = min(max(self._integral, -feed_forward), feed_forward)
        return min(max(speed, 0.0), self._max_block_speed)
