"""The top drive's reference: rocking between two turning points that may move while it rocks.

With a constant setpoint this is the trajectory of `rocking.Rocking` (paper Fig. 22): straight lines of slope +-4 D/T
joined by parabolas of constant acceleration. Amplitude, period and centre may change at any instant. They move the
turning points and the cruise speed; angle and speed stay continuous within the limits of speed and acceleration. While
the centre moves, strokes towards it are longer than strokes back. This asymmetry is the bump at the reversal with which
a directional driller turns the bit.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from slider_drilling.control.estimation.torque_sensor_model import TorqueSensorModel
from slider_drilling.control.interlocks.torque_prediction import Stroke

_PARKING_SPEED_SHARE = 0.1   # of the maximum speed
_PARKING_STEP = 0.01         # s
_SLOW_DOWN_STEP = 0.02       # s
_STROKE_END_SHARE = 0.05     # of the amplitude: a slowed-down stroke reverses this far before its end
_REST_DISTANCE = 0.005       # rad from the centre
_REST_SPEED = 0.3            # rad/s


class DriveMode(enum.Enum):
    """What the top drive does: rock, come to rest at the centre, or come to rest where it is."""

    ROCK = "rocking"
    PARK = "parking at the centre"
    FREEZE = "stopping"


@dataclass(frozen=True)
class RockingSetpoint:
    """A triangle wave whose peaks are rounded.

    Attributes:
        centre: rad.
        amplitude: Of the triangle, to either side, rad.
        period: s.
        slow_down_time: Time constant with which a stroke slows down towards its end, s; 0 for none.
    """

    centre: float
    amplitude: float
    period: float
    slow_down_time: float = 0.0


class RockingReference:
    """Angle and speed of the reference, advanced in time.

    Args:
        max_speed: rad/s.
        acceleration: Magnitude at reversals, rad/s2.
        angle: Start angle, rad.

    Attributes:
        angle: rad.
        speed: rad/s.
        side: +1 during a clockwise stroke, -1 otherwise.
        strokes: Reversals so far.
    """

    def __init__(self, max_speed: float, acceleration: float, angle: float = 0.0):
        self._max_speed = max_speed
        self._acceleration = acceleration
        self.angle = angle
        self.speed = 0.0
        self.side = 1.0
        self.strokes = 0

    def advance(self, step: float, setpoint: RockingSetpoint, mode: DriveMode = DriveMode.ROCK) -> None:
        """Advance by `step` s. A reversal starts at the exact instant, not at the next sample."""
        left = step
        while left > 1e-9:
            left -= self._advance_piece(left, setpoint, mode)

    def set_limits(self, max_speed: float, acceleration: float) -> None:
        """Use other limits (rad/s, rad/s2) from now on; a higher speed is braked down."""
        self._max_speed = max_speed
        self._acceleration = acceleration

    def reverse(self) -> None:
        """End this stroke now: brake and turn the other way."""
        self.side = -self.side
        self.strokes += 1

    def cruise_speed(self, setpoint: RockingSetpoint) -> float:
        """Speed of a stroke between its reversals, rad/s."""
        return min(4.0 * setpoint.amplitude / setpoint.period, self._max_speed)

    def _advance_piece(self, left: float, setpoint: RockingSetpoint, mode: DriveMode) -> float:
        """One stretch of constant acceleration; returns its length in s."""
        if mode is DriveMode.FREEZE:
            return self._ramp_to(0.0, left)
        if mode is DriveMode.PARK:
            return self._park(left, setpoint.centre)
        room = self._room(setpoint)
        margin = _STROKE_END_SHARE * setpoint.amplitude if setpoint.slow_down_time > 0.0 else 0.0
        if room <= max(self._braking_distance(), margin) and self.side * self.speed >= 0.0:
            self.reverse()
            room = self._room(setpoint)
        cruise = self.cruise_speed(setpoint)
        if setpoint.slow_down_time > 0.0:
            return self._slow_down(left, cruise, room, setpoint.slow_down_time)
        if self.speed != self.side * cruise:
            return self._ramp_to(self.side * cruise, left)
        if cruise == 0.0:
            return left
        until_reversal = max((room - self._braking_distance()) / cruise, 1e-6)
        return self._move(min(left, until_reversal), 0.0)

    def _room(self, setpoint: RockingSetpoint) -> float:
        """Angle left (rad) to the turning point, which lies inside the triangle's corner by its rounding."""
        rounding = 0.5 * self.cruise_speed(setpoint) ** 2 / self._acceleration
        return self.side * (setpoint.centre - self.angle) + max(setpoint.amplitude - rounding, 0.0)

    def _braking_distance(self) -> float:
        return 0.5 * self.speed * self.speed / self._acceleration

    def _slow_down(self, left: float, cruise: float, room: float, time_constant: float) -> float:
        """A short piece of a stroke whose speed falls in proportion to the angle left."""
        speed = self.side * min(cruise, max(room, 0.0) / time_constant)
        piece = min(left, _SLOW_DOWN_STEP)
        ramp = 0.0 if self.speed == speed else self._ramp_to(speed, piece)
        # Use the whole piece: the required speed differs slightly at every piece.
        return ramp + self._move(max(piece - ramp, 0.0), 0.0)

    def _ramp_to(self, speed: float, left: float) -> float:
        change = speed - self.speed
        if change == 0.0:
            return left
        time = min(left, abs(change) / self._acceleration)
        self._move(time, math.copysign(self._acceleration, change))
        if time < left:
            self.speed = speed
        return max(time, 1e-9)

    def _park(self, left: float, centre: float) -> float:
        """A short piece of the way to rest at the centre, at a tenth of the maximum speed at most."""
        distance = centre - self.angle
        rest = abs(distance) < _REST_DISTANCE and abs(self.speed) < _REST_SPEED
        # Half of the available acceleration, so that the speed can follow this profile down to zero.
        approach = min(_PARKING_SPEED_SHARE * self._max_speed, math.sqrt(self._acceleration * abs(distance)))
        speed = 0.0 if rest else math.copysign(approach, distance)
        piece = min(left, _PARKING_STEP)
        return self._move(piece, 0.0) if self.speed == speed else self._ramp_to(speed, piece)

    def _move(self, time: float, acceleration: float) -> float:
        self.angle += time * (self.speed + 0.5 * acceleration * time)
        self.speed += acceleration * time
        return time


def stroke_of(
    reference: RockingReference, setpoint: RockingSetpoint, acceleration: float, sensor: TorqueSensorModel
) -> Stroke:
    """The stroke in progress, for the prediction of its peak torque.

    Args:
        reference: The top drive's reference.
        setpoint: What it rocks towards.
        acceleration: With which it brakes, rad/s2.
        sensor: Lag of the torque reading and impedance of the pipe.
    """
    speed = reference.side * reference.speed
    next_speed = min(speed + acceleration * sensor.interval, reference.cruise_speed(setpoint))
    highest = max(next_speed, speed, reference.side * sensor.speed) if speed > 0.0 else 0.0
    # One interval passes before the next sample can end the stroke, another until the drive has followed.
    return Stroke(reference.side, highest, acceleration, sensor.impedance, 2.0 * sensor.interval + sensor.lag)
