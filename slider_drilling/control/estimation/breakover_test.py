"""How far to rock: the amplitude from the breakover torque that surface sees."""

from __future__ import annotations

import math
from collections import deque

from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag

_AVERAGED, _LINE = 10, 20   # samples at the end of a stroke: for the mean, for how torque rises
_MEASUREMENT_SPREAD = 0.06   # of ln(scale): what inertia leaves of the closed form at the test's slow ends
_STROKES = 3             # of the test: two differences between ends
SLOW_DOWN_TRAVEL_TIMES = 2.0   # time constant of the slow-down at stroke ends, in travel times of torsion


class BreakoverTest:
    """Corrects the torque-and-drag belief by the torque at which the first strokes end.

    The test's strokes come to their ends slowly, for the closed form has no inertia, and so that a torque sensor that
    lags has nearly caught up: torque still rises there, and what it rises by within the lag is added. Later strokes
    are quick and half of the torque at their ends tells little of friction (at the amplitude that frees half the
    string, 1 % of torque is 4 % of friction); they are measured and reported only.

    off_bottom: the belief without weight on bit, as the test is made. prior_spread: of ln(scale), how far the friction
    belief may be off before anything was measured.
    """

    def __init__(self, off_bottom: TorqueAndDrag, prior_spread: float):
        self._belief = off_bottom
        self._prior_spread = prior_spread
        self._latest: deque[tuple[float, float]] = deque(maxlen=_LINE)   # rad, N m
        self._strokes: int | None = None   # of the drive
        self._made = 0
        self._end: tuple[float, float] | None = None   # rad, N m: means at the end of the last stroke
        self._measured: list[float] = []   # ln(scale)
        self.breakover_torque = math.nan   # N m, half the difference of the last two ends

    @property
    def friction_scale(self) -> float:
        """Friction over its belief: prior and measurements weighed by their spreads."""
        if not self._measured:
            return 1.0
        prior, measured = self._prior_spread**-2, _MEASUREMENT_SPREAD**-2
        mean = sum(self._measured) / len(self._measured)
        return math.exp(mean * measured / (prior + measured))

    @property
    def running(self) -> bool:
        """Whether the slow strokes are still being made."""
        return self._made < _STROKES

    @property
    def log_sigma(self) -> float:
        """One standard deviation of ln(scale)."""
        weight = self._prior_spread**-2 + (_MEASUREMENT_SPREAD**-2 if self._measured else 0.0)
        return weight**-0.5

    def update(self, angle: float, torque: float, strokes: int, late: float = 0.0) -> None:
        """Take one sample. angle: rad, torque: N m, NaN where there is none; strokes: reversals so far; late: samples
        that the sensor of torque lags by."""
        if self._strokes is not None and strokes != self._strokes:
            self._stroke_ends(late)
            self._made += 1
            self._latest.clear()
        self._strokes = strokes
        if math.isfinite(torque):
            self._latest.append((angle, torque))

    def _stroke_ends(self, late: float) -> None:
        before, self._end = self._end, None
        if len(self._latest) < _AVERAGED:
            return
        angles, torques = zip(*self._latest, strict=True)
        hidden = late * _rise(torques) if self.running else 0.0
        self._end = (sum(angles[-_AVERAGED:]) / _AVERAGED, sum(torques[-_AVERAGED:]) / _AVERAGED + hidden)
        if before is None:
            return
        side = math.copysign(1.0, self._end[0] - before[0])
        amplitude, torque = 0.5 * abs(self._end[0] - before[0]), 0.5 * side * (self._end[1] - before[1])
        self.breakover_torque = torque
        if self.running and amplitude > 0.5 and torque > 0.0:
            self._measured.append(math.log(self._belief.scale_from(amplitude, torque)))


def _rise(values: tuple[float, ...]) -> float:
    """By how much they rise from one to the next, by a straight line."""
    middle = 0.5 * (len(values) - 1)
    squares = sum((k - middle) ** 2 for k in range(len(values)))
    return sum((k - middle) * value for k, value in enumerate(values)) / squares
