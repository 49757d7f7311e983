"""Rocking amplitude adapted to the response of the string: larger where pipe drags, smaller where the bit swings.

The amplitude from the breakover test is only as good as the string model: 13 % of compliance error shifts it by 28 %.
Sliding shows whether it is right. Too small an amplitude leaves pipe above the bit unrotated; that pipe drags along the
hole and holds the toolface. Too large an amplitude swings the bit. Drag shows within a minute or two, and the swing
shows when the amplitude is large enough.
"""

from __future__ import annotations

import math

# Drag is a share of the drag of a string that does not rotate.
_TARGET_DRAG = 0.28
_GROWTH, _DECAY = 0.010, 0.004     # of the amplitude per s and share of drag above, below the target
_DRAG_BAND = 0.16                  # width below the target in which the amplitude stays
_MAX_EXCESS, _MIN_EXCESS = 0.4, -0.1   # largest drag errors that are acted on
_NEAR_TARGET = 0.05                # excess below which the swing may reduce the amplitude
_SWING_REDUCES, _SWING_HOLDS = math.radians(1.8), math.radians(1.5)   # rad: reduce above, stop growing above
_DECAY_PER_SWING = 0.0012 / math.radians(1.0)   # of the amplitude per s and rad of excess swing
_MAX_SWING_DECAY = 0.003           # of the amplitude per s; slow, because the swing is known late
_STUCK_GROWTH = 0.002              # of the amplitude per s, while the bit is stuck and pipe drags
_MIN_FACTOR, _MAX_FACTOR = 0.45, 1.8
# Detection of a stuck bit: expected against actual turning of the toolface.
_WINDOW = 50.0                     # s, time constant of both averages
_MIN_EXPECTED_TURN = math.radians(18.0)   # rad within the window
_STUCK_SHARE = 0.35                # of the expected turn, below which the bit is stuck
_MIN_ERROR = math.radians(6.0)     # rad: only a lead that corrects an error counts
_BOOST_TIME = 20.0                 # s, time constant of `gain_boost`
# A stuck bit is torn loose by strokes that grow until it answers: growth per s, largest factor, and time constant (s)
# with which they shrink again.
_RELEASE_GROWTH, _MAX_RELEASE, _RELEASE_DECAY = 0.006, 1.6, 15.0
_LOOSE = 1.1   # above which it may come loose at any stroke
_RELEASE_ERROR = math.radians(15.0)   # rad of error, from which on it is worth that


class AmplitudeAdaptation:
    """Correction of the rocking amplitude while sliding.

    Attributes:
        factor: Amplitude over that of the breakover test.
        bit_stuck: Whether the bit does not turn although the string drives it.
        gain_boost: 0 to 1, grows while the bit is stuck.
        release: Temporary factor on the amplitude that tears a stuck bit loose, at least 1.
    """

    def __init__(self) -> None:
        self.factor = 1.0
        self.bit_stuck = False
        self.gain_boost = 0.0
        self.release = 1.0
        self._expected_rate = 0.0   # rad/s of the toolface, from the driving twist
        self._actual_rate = 0.0     # rad/s, as estimated
        self._tool_face = math.nan  # rad

    def check_response(
        self, driving_twist: float, response_time: float, tool_face: float, error: float, may_tear_loose: bool,
        step: float,
    ) -> None:  # fmt: skip
        """Compare how the toolface turns with how it should.

        A driving twist that does not correct an error is ignored: it says more of the sensors than of the string.

        Args:
            driving_twist: Twist that drives the bit, rad.
            response_time: Time constant with which the toolface should follow it, s.
            tool_face: Estimate, rad.
            error: Target minus toolface, rad.
            may_tear_loose: Whether strokes may grow until a stuck bit answers.
            step: Time since the last sample, s.
        """
        moved = tool_face - self._tool_face if math.isfinite(self._tool_face) else 0.0
        self._tool_face = tool_face
        if step <= 0.0:
            return
        weight = 1.0 - math.exp(-step / _WINDOW)
        self._expected_rate += weight * (driving_twist / response_time - self._expected_rate)
        self._actual_rate += weight * (moved / step - self._actual_rate)
        along = math.copysign(self._actual_rate, self._actual_rate * self._expected_rate)
        corrects = error * self._expected_rate > 0.0 and abs(error) > _MIN_ERROR
        expected = abs(self._expected_rate)
        self.bit_stuck = corrects and expected * _WINDOW > _MIN_EXPECTED_TURN and along < _STUCK_SHARE * expected
        if self.bit_stuck and abs(error) > _RELEASE_ERROR:
            if may_tear_loose:
                self.release = min(self.release * (1.0 + _RELEASE_GROWTH * step), _MAX_RELEASE)
        else:
            self.release = 1.0 + math.exp(-step / _RELEASE_DECAY) * (self.release - 1.0)
        self.gain_boost += (1.0 - math.exp(-step / _BOOST_TIME)) * (float(self.bit_stuck) - self.gain_boost)

    @property
    def tears_loose(self) -> bool:
        """Whether strokes are being made larger to tear the bit loose."""
        return self.release > _LOOSE

    def update(self, drag: float, drag_lower_bound: float, swing: float, swing_sigma: float, step: float) -> None:
        """Adapt the amplitude to one sample of drag and swing.

        Args:
            drag: Measured share of the drag of a string that does not rotate.
            drag_lower_bound: The same less one standard deviation; only this can ask for more amplitude.
            swing: Amplitude of the bit's swing, rad.
            swing_sigma: One standard deviation of it, rad.
            step: Time since the last sample, s.
        """
        if not math.isfinite(drag_lower_bound):
            return
        excess, below = drag_lower_bound - _TARGET_DRAG, drag - _TARGET_DRAG + _DRAG_BAND
        rate = _GROWTH * min(excess, _MAX_EXCESS) if excess > 0.0 else _DECAY * min(max(below, _MIN_EXCESS), 0.0)
        # A stuck bit justifies more amplitude only while drag exceeds its target: less drag does not hold a bit, and
        # the extra amplitude would throw the bit when it frees itself. Here the measured drag counts.
        if self.bit_stuck and drag > _TARGET_DRAG:
            rate = max(rate, _STUCK_GROWTH)
        elif excess < _NEAR_TARGET:
            if swing - swing_sigma > _SWING_REDUCES:
                rate = min(rate, -min(_DECAY_PER_SWING * (swing - swing_sigma - _SWING_REDUCES), _MAX_SWING_DECAY))
            elif swing - 0.5 * swing_sigma > _SWING_HOLDS:
                rate = min(rate, 0.0)
        self.factor = min(max(self.factor * (1.0 + rate * step), _MIN_FACTOR), _MAX_FACTOR)
