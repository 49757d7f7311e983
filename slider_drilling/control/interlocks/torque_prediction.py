"""Peak torque that a stroke will still meet if it is ended now.

At speed v the pipe takes the torque ``Z v``, with Z its torsional wave impedance. The rest of the torque arrives from
below, whatever the drive does meanwhile. A straight line through the last second extrapolates it over the delay until
braking takes effect. From then on braking reduces the torque by ``Z a`` per second, so only a faster rise from below
still increases it.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

_FIT_WINDOW = 1.0        # s
_MIN_LINE, _MIN_RESIDUAL = 3, 8   # samples needed for a straight line, for its residual variance
_RESIDUAL_TIME = 10.0    # s, over which the residual variance is averaged
_SIGMA_MARGIN = 1.5      # standard deviations of the residual that are added


@dataclass(frozen=True)
class Stroke:
    """A stroke in progress.

    Attributes:
        side: +1 right, -1 left.
        speed: Highest speed to that side before braking can start, rad/s; 0 while it does not yet move there.
        acceleration: Braking acceleration, rad/s2.
        impedance: Torsional wave impedance of the pipe, N m s/rad.
        delay: Time until braking takes effect, including the age of the torque reading, s.
    """

    side: float
    speed: float
    acceleration: float
    impedance: float
    delay: float


class TorquePredictor:
    """Extrapolates the torque from below, with a margin for noise.

    The margin keeps clear of torque that does not follow a straight line, without cutting strokes short on noise.
    """

    def __init__(self) -> None:
        self._side = 0.0
        self._clock = 0.0
        self._residual_variance = 0.0    # N2 m2
        self._samples: deque[tuple[float, float]] = deque()   # s, N m

    def predict_peak(self, torque_from_below: float, stroke: Stroke, step: float) -> float:
        """Predict the peak torque of the stroke if it is ended now.

        Args:
            torque_from_below: Surface torque less what the pipe takes at its present speed, N m, positive right.
            stroke: The stroke in progress.
            step: Time since the last sample, s.

        Returns:
            Torque to the stroke's side, N m; NaN where this stroke has no measurement yet.
        """
        side = stroke.side
        if side != self._side:
            self._side = side
            self._samples.clear()
        if step > 0.0:
            self._clock += step
            if math.isfinite(torque_from_below):
                self._samples.append((self._clock, side * torque_from_below))
        while self._samples and self._clock - self._samples[0][0] > _FIT_WINDOW:
            self._samples.popleft()
        if not self._samples:
            return math.nan
        count = len(self._samples)
        mean_time = sum(time for time, _ in self._samples) / count
        mean_torque = sum(torque for _, torque in self._samples) / count
        impedance_torque = stroke.impedance * stroke.speed
        if count < _MIN_LINE:
            return mean_torque + impedance_torque
        spread = sum((time - mean_time) ** 2 for time, _ in self._samples)
        slope = sum((time - mean_time) * (torque - mean_torque) for time, torque in self._samples) / spread
        if count >= _MIN_RESIDUAL and step > 0.0:
            squares = sum((torque - mean_torque - slope * (time - mean_time)) ** 2 for time, torque in self._samples)
            variance = squares / (count - 2)
            self._residual_variance += min(step / _RESIDUAL_TIME, 1.0) * (variance - self._residual_variance)
        margin = _SIGMA_MARGIN * math.sqrt(self._residual_variance)
        now, rise = mean_torque + slope * (self._clock - mean_time), max(slope, 0.0)
        while_braking = max(rise - stroke.impedance * stroke.acceleration, 0.0) * stroke.speed / stroke.acceleration
        return now + rise * stroke.delay + impedance_torque + while_braking + margin
