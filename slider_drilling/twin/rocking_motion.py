"""How the top drive moves: parked, turning or rocking; period, centre and swing of the rocking."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.twin.samples import Array

DEFAULT_PERIOD_S = 20.0
"""Time to average over where nothing rocks."""
_MEMORY_S = 120.0
_STILL = 0.02  # rad/s, of a drive that is parked
_PARKED_S = 8.0  # without motion, after which a drive is parked
_TURNING_S, _TURNING_SHARE = 12.0, 0.7  # in one direction, and of the rocking period, after which a drive turns
_LONGER_STROKE = 1.4  # times the last stroke, for which a stroke may last
_LEAST_STROKE_S, _OTHER_STROKE = 1.0, 0.2  # share by which two strokes in a row differ from those before: other rocking
_PERIODS_S = (6.0, 80.0)  # of rocking
_CENTRE_S, _CENTRE_SHIFT = 30.0, 3.0  # s, and rad by which the centre of the rocking moves in it: steering
_SMALL_SHIFT = 1.0  # rad: smaller changes from period to period are jitter, and count by their squares
_LEAST_SWING, _WIDER = 0.1, 0.1  # rad; share by which a swing exceeds all before: it reaches what has not been seen yet


class RockingMotion:
    """Follows the top drive.

    Attributes:
        moved_at: s, when it moved last.
        turned_since: s, since when it turns one way.
        period: s, of the rocking; the last one where it does not rock.
        swing: Logarithm of how far it swings, rad.
        travel: How far the centre of the rocking has moved so far, rad; small moves count by their squares.
    """

    def __init__(self, start: float) -> None:
        self.moved_at = self.turned_since = start
        self.period = DEFAULT_PERIOD_S
        self.swing = self.travel = 0.0
        self._direction = 0.0
        self._reversals: deque[float] = deque()
        self._angles: deque[Array] = deque(maxlen=round(_PERIODS_S[1]) + 1)
        self._centres: deque[float] = deque(maxlen=round(_CENTRE_S))
        self._rocking_centres: deque[float] = deque(maxlen=round(_PERIODS_S[1]))
        self._widest = -math.inf

    def add(self, commands: Commands) -> None:
        """Take the motion of the last second."""
        for time, speed in zip(commands.time, commands.top_drive_speed, strict=True):
            if abs(speed) <= _STILL:
                continue
            self.moved_at = float(time)
            if speed * self._direction < 0.0:
                self._reverse(float(time))
            if speed * self._direction <= 0.0:
                self.turned_since = float(time)
                self._direction = float(np.sign(speed))
        while self._reversals and self._reversals[0] < commands.time[-1] - _MEMORY_S:
            self._reversals.popleft()
        self._angles.append(commands.top_drive_angle)

    def mode(self, now: float) -> str:
        """``parked``, ``turning`` or ``rocking``."""
        if now - self.moved_at > _PARKED_S:
            return "parked"
        last = self._reversals[-1] - self._reversals[-2] if len(self._reversals) > 1 else 0.0
        longest = max(_TURNING_S, _TURNING_SHARE * self.period, _LONGER_STROKE * last)
        return "turning" if now - self.turned_since > longest else "rocking"

    def follow_centre(self, rocking: bool, interval: float) -> bool:
        """Take the mean angle of the last period; whether it moves: steering.

        Args:
            rocking: Whether the drive rocks.
            interval: s between samples of the angle.
        """
        recent = np.concatenate(list(self._angles)[-math.ceil(self.period) - 1 :])
        recent = recent[-max(round(self.period / interval), 1) :]
        centre, self.swing = float(np.mean(recent)), math.log(max(float(np.ptp(recent)), _LEAST_SWING))
        steering = rocking and bool(self._centres) and abs(centre - self._centres[0]) > _CENTRE_SHIFT
        self._centres.append(centre)
        self._follow_travel(centre if rocking else None)
        return steering

    def swings_wider(self) -> bool:
        """Whether it swings wider than ever before."""
        wider = self.swing > self._widest + _WIDER
        first = math.isinf(self._widest)
        if wider:
            self._widest = self.swing
        return wider and not first

    def update_period(self, rocking: bool) -> float:
        """The period by the last reversals, s; `DEFAULT_PERIOD_S` where the drive does not rock."""
        if not rocking or len(self._reversals) < 3:
            return DEFAULT_PERIOD_S
        self.period = float(np.clip(2.0 * np.median(np.diff(self._reversals)), *_PERIODS_S))
        return self.period

    def _reverse(self, time: float) -> None:
        """Take a reversal; those of another way of rocking are forgotten. One stroke that differs is steering."""
        if self._reversals and time - self._reversals[-1] < _LEAST_STROKE_S:
            return
        self._reversals.append(time)
        strokes = np.diff(self._reversals)
        if strokes.size > 3:
            change = strokes[-2:] / np.median(strokes[:-2]) - 1.0
            if np.all(change > _OTHER_STROKE) or np.all(change < -_OTHER_STROKE):
                self._reversals = deque(list(self._reversals)[-3:])

    def _follow_travel(self, centre: float | None) -> None:
        """Add the change of the centre from one rocking period to the next; None where nothing rocks: begin anew."""
        if centre is None:
            self._rocking_centres.clear()
            return
        self._rocking_centres.append(centre)
        apart = max(round(self.period), 1)
        if len(self._rocking_centres) > apart:
            moved = centre - self._rocking_centres[-1 - apart]
            self.travel += moved**2 / (_SMALL_SHIFT + abs(moved)) / apart
