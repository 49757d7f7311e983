"""Averages over whole rocking cycles, in which the rocking itself cancels."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

_MAX_STROKE_TIME = 30.0   # s, after which a stroke that does not end counts as one
_MIN_MEASURED_SHARE = 0.8   # of a stroke


@dataclass(frozen=True)
class CycleAverage:
    """Averages over two strokes.

    Attributes:
        angle: Of the top drive, rad.
        torque: At surface, N m.
        reactive_torque: Of the motor, N m.
        duration: Measured time, s.
    """

    angle: float
    torque: float
    reactive_torque: float
    duration: float


@dataclass
class _StrokeSums:
    measured: float = 0.0
    elapsed: float = 0.0
    angle: float = 0.0
    torque: float = 0.0
    reactive_torque: float = 0.0


class CycleAverager:
    """Returns the average over the last two strokes, one to either side, whenever a stroke has ended."""

    def __init__(self) -> None:
        self._stroke = _StrokeSums()
        self._completed: deque[_StrokeSums] = deque(maxlen=2)
        self._strokes = 0

    def update(
        self, step: float, angle: float, torque: float, reactive_torque: float, strokes: int
    ) -> CycleAverage | None:
        """Take one sample.

        Args:
            step: Time since the last sample, s.
            angle: Of the top drive, rad; NaN where unknown.
            torque: At surface, N m; NaN where unknown.
            reactive_torque: Of the motor, N m.
            strokes: Reversals so far.

        Returns:
            The average of the cycle that has just ended, or None.
        """
        cycle = None
        if strokes != self._strokes or self._stroke.elapsed >= _MAX_STROKE_TIME:
            self._strokes = strokes
            cycle = self._end_stroke()
        self._stroke.elapsed += step
        if math.isfinite(torque) and math.isfinite(angle):
            self._stroke.measured += step
            self._stroke.angle += step * angle
            self._stroke.torque += step * torque
            self._stroke.reactive_torque += step * reactive_torque
        return cycle

    def _end_stroke(self) -> CycleAverage | None:
        stroke, self._stroke = self._stroke, _StrokeSums()
        if stroke.measured <= 0.0 or stroke.measured < _MIN_MEASURED_SHARE * stroke.elapsed:
            self._completed.clear()
            return None
        self._completed.append(stroke)
        if len(self._completed) < 2:
            return None
        duration = sum(sums.measured for sums in self._completed)
        return CycleAverage(sum(sums.angle for sums in self._completed) / duration,
                            sum(sums.torque for sums in self._completed) / duration,
                            sum(sums.reactive_torque for sums in self._completed) / duration, duration)
