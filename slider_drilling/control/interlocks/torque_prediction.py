"""What torque a stroke may still meet where it is ended now.

The pipe takes ``Z v`` at the speed v that it is turned with, Z its wave impedance; the rest of the torque arrives from
below, whatever the drive does meanwhile. That is foretold by a straight line over the time that passes before braking
tells. From then on braking takes off ``Z a`` a second, which only what rises faster outruns.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from slider_drilling.control.estimation.torque_sensor_model import TorqueSensorModel
from slider_drilling.control.top_drive.rocking_reference import RockingReference, RockingSetpoint

_TREND = 1.0             # s
_LINE, _TELLS = 3, 8     # samples that make a straight line, that tell how rough it is
_ROUGH_TIME = 10.0       # s, over which that is averaged
_SURE = 1.5              # standard deviations of what is no straight line, that are kept clear of


@dataclass(frozen=True)
class Stroke:
    """A stroke under way. side: +1 right, -1 left; speed: rad/s to that side, the fastest before it could be braked, 0
    while it does not move there yet; acceleration: rad/s2, with which it is braked; impedance: N m s/rad, of the pipe;
    delay: s, until braking tells, the age of what was read in it."""

    side: float
    speed: float
    acceleration: float
    impedance: float
    delay: float


def stroke_of(
    drive: RockingReference, wish: RockingSetpoint, acceleration: float, reading: TorqueSensorModel
) -> Stroke:
    """The stroke that the drive makes towards this wish. acceleration: rad/s2, with which it brakes."""
    speed = drive.side * drive.speed
    next_one = min(speed + acceleration * reading.interval, drive.cruise_speed(wish))
    fastest = max(next_one, speed, drive.side * reading.speed) if speed > 0.0 else 0.0
    # A sample passes before the next one can end the stroke, another one until the drive has followed.
    return Stroke(drive.side, fastest, acceleration, reading.impedance, 2.0 * reading.interval + reading.lag)


class TorquePredictor:
    """A straight line through what arrived in the last second, and how far off it torque may be: noise must not cut
    strokes short, and what is no straight line must not go unseen."""

    def __init__(self) -> None:
        self._side = 0.0
        self._clock = 0.0
        self._rough = 0.0    # N2 m2, mean square of what is no straight line
        self._seen: deque[tuple[float, float]] = deque()   # s, N m

    def predict_peak(self, arriving: float, stroke: Stroke, step: float) -> float:
        """The most torque (N m) to its side that a stroke may still meet where it is ended now; NaN where nothing of it
        was measured. arriving: N m, of the torque, that comes from below."""
        side = stroke.side
        if side != self._side:
            self._side = side
            self._seen.clear()
        if step > 0.0:
            self._clock += step
            if math.isfinite(arriving):
                self._seen.append((self._clock, side * arriving))
        while self._seen and self._clock - self._seen[0][0] > _TREND:
            self._seen.popleft()
        if not self._seen:
            return math.nan
        count = len(self._seen)
        time = sum(one for one, _ in self._seen) / count
        level = sum(one for _, one in self._seen) / count
        turning = stroke.impedance * stroke.speed
        if count < _LINE:
            return level + turning
        spread = sum((one - time) ** 2 for one, _ in self._seen)
        rate = sum((one - time) * (other - level) for one, other in self._seen) / spread
        if count >= _TELLS and step > 0.0:
            left = sum((other - level - rate * (one - time)) ** 2 for one, other in self._seen) / (count - 2)
            self._rough += min(step / _ROUGH_TIME, 1.0) * (left - self._rough)
        doubt = _SURE * math.sqrt(self._rough)
        now, rising = level + rate * (self._clock - time), max(rate, 0.0)
        outrun = max(rising - stroke.impedance * stroke.acceleration, 0.0) * stroke.speed / stroke.acceleration
        return now + rising * stroke.delay + turning + outrun + doubt
