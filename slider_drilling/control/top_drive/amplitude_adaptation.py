"""How deep to rock, from how the string answers: deeper where pipe drags, less where the bit swings.

The amplitude that the breakover test finds is as good as the belief of the string: 13 % of compliance shift it by 28 %.
What it must do shows while sliding. Too little leaves pipe above the bit that drags along the hole and holds the
toolface; too much swings the bit. Both are measured, and the amplitude follows: drag tells within a minute or two, the
swing says when it is enough.
"""

from __future__ import annotations

import math

_DRAG = 0.28               # share of the drag of a string that does not turn, that is aimed at
_DEEPER, _LESS = 0.010, 0.004      # of the amplitude per s and share of drag beyond, below
_SLACK = 0.16              # share of drag, below which rocking may reach less
_MOST_OFF, _LEAST_OFF = 0.4, -0.1  # shares of drag that count at most
_NEAR = 0.05               # share of drag beyond, up to which the swing has a say
_SWING, _ENOUGH = math.radians(1.8), math.radians(1.5)   # rad: less from here, no more from here
_PER_SWING = 0.0012 / math.radians(1.0)   # of the amplitude per s and rad of swing beyond
_FASTEST_LESS = 0.003      # of the amplitude per s, for the swing is known late
_STUCK = 0.002             # of the amplitude per s, while what pulls does not turn the bit and pipe drags
_SMALLEST, _LARGEST = 0.45, 1.8    # of the amplitude that the breakover test found
_WINDOW = 50.0             # s, over which what pulls is held against what turns
_PULLED = math.radians(18.0)       # rad in that window, that what pulls should have turned
_TURNED_SHARE = 0.35       # of it, below which the bit is stuck
_URGED = 20.0              # s, in which the urge comes and goes
_ASKED = math.radians(6.0)         # of error, which the pull is meant to mend


class AmplitudeAdaptation:
    """share: amplitude over the one that the breakover test found."""

    def __init__(self) -> None:
        self.factor = 1.0
        self.bit_stuck = False       # what pulls does not turn the bit
        self.gain_boost = 0.0          # 0 to 1: how long that has been so
        self._expected = 0.0     # rad/s, of the toolface, by what pulls
        self._turning = 0.0      # rad/s, as estimated
        self._tool_face = math.nan

    def check_response(self, pull: float, response_time: float, tool_face: float, error: float, step: float) -> None:
        """Take what pulls (rad), the time (s) in which the toolface should follow it, the toolface and by how much it
        should turn (rad). A pull that no error asked for says more of the sensors than of the string."""
        moved = tool_face - self._tool_face if math.isfinite(self._tool_face) else 0.0
        self._tool_face = tool_face
        if step <= 0.0:
            return
        kept = 1.0 - math.exp(-step / _WINDOW)
        self._expected += kept * (pull / response_time - self._expected)
        self._turning += kept * (moved / step - self._turning)
        along = math.copysign(self._turning, self._turning * self._expected)
        asked = error * self._expected > 0.0 and abs(error) > _ASKED
        expected = abs(self._expected)
        self.bit_stuck = asked and expected * _WINDOW > _PULLED and along < _TURNED_SHARE * expected
        self.gain_boost += (1.0 - math.exp(-step / _URGED)) * (float(self.bit_stuck) - self.gain_boost)

    def update(self, drag: float, certain: float, swing: float, swing_sigma: float, step: float) -> None:
        """Take the share of drag, as read and for certain, and the swing (rad) with its one-sigma. Deeper is asked for
        by what drags for certain alone."""
        if not math.isfinite(certain):
            return
        beyond, below = certain - _DRAG, drag - _DRAG + _SLACK
        rate = _DEEPER * min(beyond, _MOST_OFF) if beyond > 0.0 else _LESS * min(max(below, _LEAST_OFF), 0.0)
        # Drag may be believed here without being certain, but less of it than is aimed at holds no bit: what is rocked
        # deeper on its account is still there when the bit lets go, and throws it.
        if self.bit_stuck and drag > _DRAG:
            rate = max(rate, _STUCK)
        elif beyond < _NEAR:
            if swing - swing_sigma > _SWING:
                rate = min(rate, -min(_PER_SWING * (swing - swing_sigma - _SWING), _FASTEST_LESS))
            elif swing - 0.5 * swing_sigma > _ENOUGH:
                rate = min(rate, 0.0)
        self.factor = min(max(self.factor * (1.0 + rate * step), _SMALLEST), _LARGEST)
