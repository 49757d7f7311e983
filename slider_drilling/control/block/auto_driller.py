"""The auto-driller: block speed that holds a differential pressure, and with it the reactive torque."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

# Response time: a longer string lets weight go later, and all at once where it hung on the wall.
_TIME_PER_METRE, _SHORTEST_TIME = 5.4e-3, 18.0   # s/m, s


class AutoDriller:
    """PI on differential pressure about the block speed that the rig file's bit and motor need.

    The string is a spring between block and bit: lowering the block faster than the bit drills by v loads the bit by
    ``k v`` N/s. The proportional gain is the one with which an error of pressure decays over `response_time` s.
    """

    def __init__(self, rig: Rig, response_time: float, max_block_speed: float):
        motor_speed = 2.0 * math.pi * rig.hydraulics.reference_flow / rig.motor.displacement
        self.weight_per_pressure = rig.motor.torque_per_pressure / rig.bit.lever                     # N/Pa
        cutting = 2.0 * math.pi * rig.bit.depth_of_cut_stiffness / motor_speed               # N s/m
        self.speed_per_pressure = self.weight_per_pressure / cutting                         # m/(s Pa)
        self.configure(rig, response_time, max_block_speed)
        self._integral = 0.0     # m/s
        self.setpoint = 0.0      # Pa, ramped

    def pressure_for(self, rate_of_penetration: float) -> float:
        """Differential pressure (Pa) at which the rig file's bit drills at this rate (m/s)."""
        return rate_of_penetration / self.speed_per_pressure

    def configure(self, rig: Rig, response_time: float, max_block_speed: float) -> None:
        """Another response time (s, 0 for one that suits the string) and fastest lowering (m/s) from now on."""
        response_time = response_time or max(_TIME_PER_METRE * rig.string.length, _SHORTEST_TIME)
        self._gain = self.weight_per_pressure / (rig.string.axial_stiffness * response_time)      # m/(s Pa)
        self._integral_time = 10.0 * response_time
        self._max_block_speed = max_block_speed

    def restart(self) -> None:
        """Begin again from no weight on bit, as after picking up."""
        self.setpoint = 0.0
        self._integral = 0.0

    def follow(self, pressure: float) -> None:
        """Lowering is stopped: go on from the pressure (Pa) that is left, not from what was asked for before."""
        self.setpoint = min(self.setpoint, max(pressure, 0.0))
        self._integral = 0.0

    def update(self, pressure: float, wanted: float, ramp: float, step: float, arriving: float = 1.0) -> float:
        """Block speed (m/s) now. pressure, wanted: Pa; ramp: Pa/s, how fast the set point may rise; step: s; arriving:
        share of what would be lowered beyond what the bit drills that may be, below 0 what is to be taken back."""
        change = wanted - self.setpoint
        self.setpoint += min(change, max(arriving, 0.0) * ramp * step) if change > 0.0 else max(change, -ramp * step)
        error = self.setpoint - pressure
        feed_forward = self.speed_per_pressure * self.setpoint
        speed = feed_forward + self._gain * error + self._integral
        drilled = self.speed_per_pressure * max(pressure, 0.0)
        if speed > drilled:
            speed = drilled + arriving * (speed - drilled)
        if change == 0.0 and arriving == 1.0 and 0.0 < speed < self._max_block_speed:
            self._integral += self._gain * error * step / self._integral_time
            self._integral = min(max(self._integral, -feed_forward), feed_forward)
        return min(max(speed, 0.0), self._max_block_speed)
