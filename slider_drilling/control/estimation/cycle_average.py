"""Means over whole cycles of rocking: what is left of angle and torque where the rocking itself cancels."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

_LONGEST = 30.0       # s after which a stroke that does not end is taken as one
_LEAST_SHARE = 0.8    # of a stroke that must have been measured


@dataclass(frozen=True)
class CycleAverage:
    """angle: rad, of the top drive; torque: N m at surface; reactive_torque: N m of the motor; duration: s, of the
    two strokes that the means were taken over."""

    angle: float
    torque: float
    reactive_torque: float
    duration: float


@dataclass
class _Sums:
    measured: float = 0.0
    elapsed: float = 0.0
    angle: float = 0.0
    torque: float = 0.0
    reactive_torque: float = 0.0


class CycleAverager:
    """Gives the mean over the last two strokes, to either side, each time a stroke has ended."""

    def __init__(self) -> None:
        self._now = _Sums()
        self._whole: deque[_Sums] = deque(maxlen=2)
        self._strokes = 0

    def update(
        self, step: float, angle: float, torque: float, reactive_torque: float, strokes: int
    ) -> CycleAverage | None:
        """Take one sample: s since the last one, rad, N m (NaN where there is none), N m, reversals so far."""
        cycle = None
        if strokes != self._strokes or self._now.elapsed >= _LONGEST:
            self._strokes = strokes
            cycle = self._end_stroke()
        self._now.elapsed += step
        if math.isfinite(torque) and math.isfinite(angle):
            self._now.measured += step
            self._now.angle += step * angle
            self._now.torque += step * torque
            self._now.reactive_torque += step * reactive_torque
        return cycle

    def _end_stroke(self) -> CycleAverage | None:
        stroke, self._now = self._now, _Sums()
        if stroke.measured <= 0.0 or stroke.measured < _LEAST_SHARE * stroke.elapsed:
            self._whole.clear()
            return None
        self._whole.append(stroke)
        if len(self._whole) < 2:
            return None
        duration = sum(one.measured for one in self._whole)
        return CycleAverage(sum(one.angle for one in self._whole) / duration,
                         sum(one.torque for one in self._whole) / duration,
                         sum(one.reactive_torque for one in self._whole) / duration, duration)
