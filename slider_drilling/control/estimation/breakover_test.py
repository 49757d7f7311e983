"""Breakover test: friction from the torque at the ends of the first, slow strokes."""

from __future__ import annotations

import math
from collections import deque

from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag

SLOW_DOWN_TRAVEL_TIMES = 2.0   # time constant of the slow-down at stroke ends, in travel times of torsion
_END_SAMPLES, _SLOPE_SAMPLES = 10, 20   # at the end of a stroke: for the mean, for the rise of torque
_MEASUREMENT_SIGMA = 0.06   # of ln(friction scale): inertia that the closed form leaves out at the slow ends
_STROKES = 3                # two differences between stroke ends
_MIN_AMPLITUDE = 0.5        # rad


class BreakoverTest:
    """Corrects the friction of the torque-and-drag model by the torque at the ends of the first strokes.

    The test strokes slow down towards their ends because the closed form has no inertia, and so that a torque sensor
    with a lag has nearly caught up. The torque that it still lacks, its lag times the rise of torque, is added.

    Later strokes are quick and do not correct the friction: half of the torque at their ends is inertia, and near the
    amplitude that frees half of the string 1 % of torque stands for 4 % of friction. Their torque is only reported.

    Args:
        off_bottom_model: Torque and drag without weight on bit, as during the test.
        prior_sigma: One standard deviation of ln(friction scale) before the test.

    Attributes:
        breakover_torque: Half the torque difference of the last two stroke ends, N m.
    """

    def __init__(self, off_bottom_model: TorqueAndDrag, prior_sigma: float):
        self._model = off_bottom_model
        self._prior_sigma = prior_sigma
        self._samples: deque[tuple[float, float]] = deque(maxlen=_SLOPE_SAMPLES)   # rad, N m
        self._strokes: int | None = None   # reversals of the drive at the last sample
        self._completed = 0
        self._end: tuple[float, float] | None = None   # rad, N m: means at the end of the last stroke
        self._log_scales: list[float] = []
        self.breakover_torque = math.nan

    @property
    def friction_scale(self) -> float:
        """Friction over its assumed value: prior and measurements, weighted by their variances."""
        if not self._log_scales:
            return 1.0
        prior, measured = self._prior_sigma**-2, _MEASUREMENT_SIGMA**-2
        mean = sum(self._log_scales) / len(self._log_scales)
        return math.exp(mean * measured / (prior + measured))

    @property
    def running(self) -> bool:
        """Whether the slow strokes are still being made."""
        return self._completed < _STROKES

    @property
    def log_sigma(self) -> float:
        """One standard deviation of ln(friction scale)."""
        weight = self._prior_sigma**-2 + (_MEASUREMENT_SIGMA**-2 if self._log_scales else 0.0)
        return weight**-0.5

    def update(self, angle: float, torque: float, strokes: int, sensor_lag: float = 0.0) -> None:
        """Take one sample.

        Args:
            angle: Of the top drive, rad.
            torque: At surface, N m; NaN where unknown.
            strokes: Reversals so far.
            sensor_lag: Lag of the torque sensor, in samples.
        """
        if self._strokes is not None and strokes != self._strokes:
            self._end_stroke(sensor_lag)
            self._completed += 1
            self._samples.clear()
        self._strokes = strokes
        if math.isfinite(torque):
            self._samples.append((angle, torque))

    def _end_stroke(self, sensor_lag: float) -> None:
        before, self._end = self._end, None
        if len(self._samples) < _END_SAMPLES:
            return
        angles, torques = zip(*self._samples, strict=True)
        lagging = sensor_lag * _slope(torques) if self.running else 0.0
        self._end = (sum(angles[-_END_SAMPLES:]) / _END_SAMPLES, sum(torques[-_END_SAMPLES:]) / _END_SAMPLES + lagging)
        if before is None:
            return
        side = math.copysign(1.0, self._end[0] - before[0])
        amplitude, torque = 0.5 * abs(self._end[0] - before[0]), 0.5 * side * (self._end[1] - before[1])
        self.breakover_torque = torque
        if self.running and amplitude > _MIN_AMPLITUDE and torque > 0.0:
            self._log_scales.append(math.log(self._model.scale_from(amplitude, torque)))


def _slope(values: tuple[float, ...]) -> float:
    """Rise per sample of the least-squares line."""
    middle = 0.5 * (len(values) - 1)
    squares = sum((k - middle) ** 2 for k in range(len(values)))
    return sum((k - middle) * value for k, value in enumerate(values)) / squares
