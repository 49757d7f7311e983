"""Recursive least squares on the tracked parameters: the trends."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from slider_drilling.gap.results.intervals import TWO_SIDED_95
from slider_drilling.twin.channels import COMPARED, SURFACE
from slider_drilling.twin.follower import Followed
from slider_drilling.twin.report import Trend
from slider_drilling.twin.samples import Array
from slider_drilling.twin.tracked import TrackedParameter

_REPEATED = 100.0  # samples in a row that the model's own error shares: it does not average out as noise does
_SMOOTH_S = 100.0  # memory of the lack of fit
_FIRST_MISFIT = 4.0  # noise variances: lack of fit before anything is known of it
_OUTLYING = 4.0  # times the usual square, from which a second is an outlier


class RecursiveCalibration:
    """Least squares with a prior and exponential forgetting, kept as its normal equations (an information filter).

    Args:
        parameters: p of them.
        noise: Noise level by channel.
        memory: s, after which a second of data counts 1 / e; infinity to forget nothing.

    Attributes:
        values: (p,) the estimate.
        covariance: (p, p) of it.
    """

    def __init__(
        self, parameters: Sequence[TrackedParameter], noise: Mapping[str, float], memory: float = math.inf
    ) -> None:
        self._parameters, self._noise, self._memory = tuple(parameters), dict(noise), memory
        self._nominal = np.array([parameter.nominal for parameter in parameters])
        self._precision = np.array([1.0 / parameter.spread**2 for parameter in parameters])
        self._information = np.zeros((len(parameters), len(parameters)))
        self._score = np.zeros(len(parameters))
        self._misfit = dict.fromkeys(SURFACE, _FIRST_MISFIT)
        self._solve()

    def add(self, followed: Followed, measured: Mapping[str, Array]) -> None:
        """Take one block; measured: by channel, (n,), NaN where nothing was measured."""
        interval = float(followed.time[1] - followed.time[0])
        kept = math.exp(-followed.time.size * interval / self._memory)
        self._information *= kept
        self._score *= kept
        share = 1.0 - math.exp(-followed.time.size * interval / _SMOOTH_S)
        for row, name in enumerate(COMPARED):
            known = np.isfinite(measured[name]) if name in SURFACE else np.zeros(followed.time.size, dtype=bool)
            if not known.any():
                continue
            slopes = followed.sensitivity[known, row] / self._noise[name]
            innovation = (measured[name] - followed.channels[:, row])[known] / self._noise[name]
            left = innovation - slopes @ (self.values - followed.centre)
            # A channel that fits badly counts less, and a second that fits much worse than others hardly at all.
            square, usual = float(np.mean(left**2)), self._misfit[name]
            weight = 1.0 / (_REPEATED * usual * max(square / (_OUTLYING * usual), 1.0))
            self._information += weight * (slopes.T @ slopes)
            self._score += weight * (slopes.T @ (innovation + slopes @ followed.centre))
            self._misfit[name] += share * (max(min(square, _OUTLYING * usual), 1.0) - usual)
        self._solve()

    def start_from(self, other: RecursiveCalibration) -> None:
        """Go on with what another calibration has learnt."""
        self._information, self._score = other._information.copy(), other._score.copy()
        self._misfit = dict(other._misfit)
        self._solve()

    def trend(self, weights: Array, unit: str = "-") -> Trend:
        """A combination of parameters, weights (p,), with its 95 % interval."""
        value = float(weights @ self.values)
        half = TWO_SIDED_95 * math.sqrt(float(weights @ self.covariance @ weights))
        return Trend(value, value - half, value + half, unit)

    def _solve(self) -> None:
        precision = self._information + np.diag(self._precision)
        self.covariance: Array = np.asarray(np.linalg.inv(precision), dtype=np.float64)
        estimate = self.covariance @ (self._score + self._precision * self._nominal)
        limits = ((parameter.lower, parameter.upper) for parameter in self._parameters)
        self.values: Array = np.array([min(max(v, low), high) for v, (low, high) in zip(estimate, limits, strict=True)])
