"""The top drive's reference: rocking between two turning points that may move while it rocks.

With everything constant this is the trajectory of `rocking.Rocking` (the paper's Fig. 22): straight lines of slope
+-4 D/T joined by parabolas of constant acceleration. Here amplitude, period and centre are wishes that can change at
any instant: they move the turning points and the cruising speed, and the motion goes on from the angle and the speed
it has, within the limits of acceleration and speed. A centre that moves makes the strokes towards it longer than those
back: the asymmetric bump at the reversal by which a directional driller turns the bit.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

_PARKING_SHARE = 0.1     # of the greatest speed
_PARKING_PIECE = 0.01    # s
_LANDING_PIECE = 0.02    # s
_LANDED = 0.05           # of the amplitude, before the end
_AT_REST = 0.005         # rad from the centre
_REST_SPEED = 0.3        # rad/s


class DriveMode(enum.Enum):
    """What the drive is asked for: rocking, coming to rest at the centre, or coming to rest where it is."""

    ROCK = "rocking"
    PARK = "parking at the centre"
    FREEZE = "stopping"


@dataclass(frozen=True)
class RockingSetpoint:
    """centre: rad; amplitude: rad and period: s, of the triangle wave whose peaks are rounded; landing: s, the time
    constant with which a stroke slows down towards its end, 0 for none."""

    centre: float
    amplitude: float
    period: float
    slow_down_time: float = 0.0


class RockingReference:
    """Angle (rad) and speed (rad/s) of the reference, advanced in time. max_speed: rad/s; acceleration: rad/s2."""

    def __init__(self, max_speed: float, acceleration: float, angle: float = 0.0):
        self._max_speed = max_speed
        self._acceleration = acceleration
        self.angle = angle
        self.speed = 0.0
        self.side = 1.0       # +1 while the stroke goes clockwise
        self.strokes = 0      # reversals so far

    def advance(self, step: float, wish: RockingSetpoint, motion: DriveMode = DriveMode.ROCK) -> None:
        """Move on by `step` s. The turn begins where braking must, to the instant, not to the sample."""
        left = step
        while left > 1e-9:
            left -= self._advance_piece(left, wish, motion)

    def set_limits(self, max_speed: float, acceleration: float) -> None:
        """Other limits from now on; a speed above is braked down to."""
        self._max_speed = max_speed
        self._acceleration = acceleration

    def reverse(self) -> None:
        """End this stroke now: brake and go the other way."""
        self.side = -self.side
        self.strokes += 1

    def cruise_speed(self, wish: RockingSetpoint) -> float:
        """rad/s, of a stroke between its reversals."""
        return min(4.0 * wish.amplitude / wish.period, self._max_speed)

    def _advance_piece(self, left: float, wish: RockingSetpoint, motion: DriveMode) -> float:
        """One stretch of constant acceleration; returns its length in s."""
        if motion is DriveMode.FREEZE:
            return self._ramp_to(0.0, left)
        if motion is DriveMode.PARK:
            return self._park(left, wish.centre)
        room = self._room(wish)
        landed = _LANDED * wish.amplitude if wish.slow_down_time > 0.0 else 0.0
        if room <= max(self._braking_distance(), landed) and self.side * self.speed >= 0.0:
            self.reverse()
            room = self._room(wish)
        cruise = self.cruise_speed(wish)
        if wish.slow_down_time > 0.0:
            return self._land(left, cruise, room, wish.slow_down_time)
        if self.speed != self.side * cruise:
            return self._ramp_to(self.side * cruise, left)
        if cruise == 0.0:
            return left
        until_turn = max((room - self._braking_distance()) / cruise, 1e-6)
        return self._move(min(left, until_turn), 0.0)

    def _room(self, wish: RockingSetpoint) -> float:
        """Way left (rad) to where this stroke turns: inside the triangle's corner by what rounds it."""
        rounded = 0.5 * self.cruise_speed(wish) ** 2 / self._acceleration
        return self.side * (wish.centre - self.angle) + max(wish.amplitude - rounded, 0.0)

    def _braking_distance(self) -> float:
        return 0.5 * self.speed * self.speed / self._acceleration

    def _land(self, left: float, cruise: float, room: float, landing: float) -> float:
        """A little of a stroke whose speed falls with the way that is left."""
        speed = self.side * min(cruise, max(room, 0.0) / landing)
        piece = min(left, _LANDING_PIECE)
        ramp = 0.0 if self.speed == speed else self._ramp_to(speed, piece)
        # On for the whole piece: every piece asks for a speed a little different.
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
        """A little on the way to rest at the centre, at a tenth of the drive's speed at most."""
        distance = centre - self.angle
        rest = abs(distance) < _AT_REST and abs(self.speed) < _REST_SPEED
        # Half of the acceleration there is, so that the speed can follow its way down.
        approach = min(_PARKING_SHARE * self._max_speed, math.sqrt(self._acceleration * abs(distance)))
        speed = 0.0 if rest else math.copysign(approach, distance)
        piece = min(left, _PARKING_PIECE)
        return self._move(piece, 0.0) if self.speed == speed else self._ramp_to(speed, piece)

    def _move(self, time: float, acceleration: float) -> float:
        self.angle += time * (self.speed + 0.5 * acceleration * time)
        self.speed += acceleration * time
        return time
