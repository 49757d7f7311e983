"""Noise of the MWD, learnt from its own readings: two readings in a row share the noise of the one between them.

The turn from one sample to the next, less the turn that the model expects, is ``d = w + n1 - n0``: the toolface's own
walk, and the noise of both samples. Consecutive turns share a sample, so their covariance is minus the variance of the
noise, whatever the walk. A model that turns too fast or too slow makes the covariance positive, and so never noise.
Half the mean square of d is noise and walk together, and bounds the noise.
"""

from __future__ import annotations

import math

_PRIOR_SAMPLES = 8.0  # samples that the rig file's noise counts for
_MEMORY = 60.0  # samples
_SWING_SAMPLES = 12  # the first, from which the swing is learnt: until then it looks like noise
_SWING_SHARE = 9.0  # of the rig file's variance, up to which it may be a swing of the bit that is not periodic
_MAX_TURN = math.radians(40.0)  # rad between two samples; more is a wrong sample or a bit that came loose


class MwdNoise:
    """Variance of one MWD sample: the rig file's, or the learnt one where that is several times as large.

    Args:
        variance: By the rig file, rad2.
    """

    def __init__(self, variance: float):
        self._rig_file = variance
        self._last: float | None = None  # rad, the last sample less the turn that was expected up to it
        self._turn: float | None = None  # rad, d of the last two samples
        self._covariance = self._square = self._samples = 0.0  # sums: rad2, rad2, samples
        self._ignored = 0  # samples

    def forget_last(self) -> None:
        """Start again from the next sample, as after a clock that has jumped; the noise stays."""
        self._last = self._turn = None

    def observe(self, tool_face: float, expected: float) -> None:
        """Take an accepted sample.

        Args:
            tool_face: Without its swing, rad.
            expected: Turn that the model expects up to it, rad.
        """
        if self._ignored < _SWING_SAMPLES:
            self._ignored += 1
            return
        now = tool_face - expected
        if self._last is not None:
            turn = math.remainder(now - self._last, 2.0 * math.pi)
            if abs(turn) > _MAX_TURN:
                self.forget_last()
            else:
                if self._turn is not None:
                    kept = 1.0 - 1.0 / _MEMORY
                    self._covariance = kept * self._covariance - turn * self._turn
                    self._square = kept * self._square + 0.5 * turn * turn
                    self._samples = kept * self._samples + 1.0
                self._turn = turn
        self._last = now

    @property
    def variance(self) -> float:
        """Of one sample, rad2."""
        prior = _PRIOR_SAMPLES * self._rig_file
        learnt = (min(self._covariance, self._square) + prior) / (self._samples + _PRIOR_SAMPLES)
        return learnt if learnt > _SWING_SHARE * self._rig_file else self._rig_file
