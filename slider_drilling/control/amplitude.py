"""How far to rock: the amplitude from the breakover torque that surface sees."""

from __future__ import annotations

import math
from collections import deque

from slider_drilling.control.torque_and_drag import TorqueAndDrag

_AVERAGED = 3            # samples of torque averaged before its peak is taken
_MEASUREMENT_SPREAD = 0.06   # of ln(scale): what inertia leaves of the closed form at the test's slow strokes
_PAIRS = 2               # of strokes, in the test
TEST_PERIOD_SHARE = 2.0  # of the test to the period of rocking: slow, since the closed form has no inertia
SHORTEST_TEST_PERIOD = 16.0   # s


class AmplitudeFinder:
    """Corrects the torque-and-drag belief by the torque at which the first, slow strokes end.

    Later strokes are quick, their torque holds inertia, and half of it then tells little of friction (at the amplitude
    that frees half the string, 1 % of torque is 4 % of friction); they are measured and reported only.

    off_bottom: the belief without weight on bit, as the test is made. prior_spread: of ln(scale), how far the friction
    belief may be off before anything was measured.
    """

    def __init__(self, off_bottom: TorqueAndDrag, prior_spread: float):
        self._belief = off_bottom
        self._prior_spread = prior_spread
        self._latest: deque[float] = deque(maxlen=_AVERAGED)   # N m
        self._strokes = 0
        self._ends: dict[float, tuple[float, float]] = {}   # side -> (angle rad, torque N m) of its last end
        self._mean: float | None = None    # ln(scale) as measured
        self.pairs = 0
        self.breakover_torque = math.nan   # N m, half the difference of the two ends
        self.mean_torque = math.nan        # N m, half their sum: what the bit's reaction leaves at surface

    @property
    def scale(self) -> float:
        """Friction over its belief: prior and measurements weighed by their spreads."""
        if self._mean is None:
            return 1.0
        prior, measured = self._prior_spread**-2, _MEASUREMENT_SPREAD**-2
        return math.exp(self._mean * measured / (prior + measured))

    @property
    def testing(self) -> bool:
        """Whether the slow strokes are still being made."""
        return self.pairs < _PAIRS

    @property
    def spread(self) -> float:
        """One standard deviation of ln(scale)."""
        weight = self._prior_spread**-2 + (_MEASUREMENT_SPREAD**-2 if self._mean is not None else 0.0)
        return weight**-0.5

    def update(self, angle: float, torque: float, strokes: int, side: float) -> None:
        """Take one sample. angle: rad, torque: N m; strokes, side: of the drive, after this step."""
        if strokes != self._strokes:
            self._strokes = strokes
            self._measure()
            # The stroke towards `side` begins; what the one before left is kept for the next pair.
            self._ends.pop(side, None)
        if not math.isfinite(torque):
            return
        self._latest.append(torque)
        smooth = sum(self._latest) / len(self._latest)
        furthest = self._ends.get(side, (angle, smooth))
        self._ends[side] = (side * max(side * furthest[0], side * angle),
                            side * max(side * furthest[1], side * smooth))

    def _measure(self) -> None:
        if len(self._ends) < 2 or self._strokes < 2:
            return
        (right_angle, right), (left_angle, left) = self._ends[1.0], self._ends[-1.0]
        amplitude, torque = 0.5 * (right_angle - left_angle), 0.5 * (right - left)
        self.breakover_torque, self.mean_torque = torque, 0.5 * (right + left)
        if amplitude <= 0.5 or torque <= 0.0:
            return
        if not self.testing:
            return
        measured = math.log(self._belief.scale_from(amplitude, torque))
        self.pairs += 1
        self._mean = measured if self._mean is None else self._mean + (measured - self._mean) / self.pairs
