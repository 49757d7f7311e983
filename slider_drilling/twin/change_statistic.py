"""Generalised likelihood ratio of a change in a feature, against how that feature wanders without one.

Means over some tens of seconds are compared: over longer times a feature moves like a Gaussian process, from one value
to the next it does not. That process has an unknown level, a slow wander with a memory, a drift, what every stretch of
work has of its own and what is left of the operation before it, what load, steering and the way of rocking bring, and
what the numbers of the plant add that are uncertain or wander themselves. Its size is unknown: with an inverse-gamma
prior the evidence is a Student t ratio, and a rig that wanders little needs a smaller change. A change adds, from an
unknown time on, a step, a ramp, or a step of one of the plant's numbers, which shows as much as the work lets it
(Basseville and Nikiforov, Detection of Abrupt Changes, 1993, chapter 4). It may begin while nothing is compared: then
only what lies between two stretches dates it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from slider_drilling.twin.feature_means import FeatureMeans, FeatureSeries, means_of
from slider_drilling.twin.samples import Array

_LEVEL = 30.0  # noise levels: standard deviation of the unknown level
_RESOLUTION_S = 5.0  # between two values of a feature, which show an onset no better
_RECENT_S, _THINNED = 240.0, 2  # before which one in so many times of onset is tried
_FADE_S = 90.0  # in which what an operation leaves falls to 1 / e
# Of the logarithms of the drive's swing and of its period, within which what the model has wrong is alike.
_SWING, _PACE = 0.12, 0.2
_SEEN = 0.3  # noise levels of a number's wander, from which a step of it is tried


@dataclass(frozen=True)
class Wander:
    """How a feature moves on rigs that do not change: standard deviations in noise levels.

    Attributes:
        white: Of a full mean, whatever the others are.
        slow: Of the part with a memory.
        memory: s.
        drift: Of the drift in 10 min.
        jump: Of what the level of one stretch of work has of its own.
        fresh: Of what an operation leaves in each mean, when the stretch after it begins.
        weighed: Of what goes with the load on the bit, at all of it.
        steered: Of what stays when the centre of the rocking has moved by 1 rad.
        swung: Of what a way of rocking has of its own, beside others of another swing or period.
        slipped: Of what a mean has of its own for each noise level by which the hook load has moved: the string slips,
            and takes weight to the bit.
        threshold: Evidence that rigs without a change do not reach.
        smallest: Change that is worth a detection.
        values: Of the feature, one every five seconds, that make a mean.
        before: Means that are needed before a change.
        freedom: Means that the size of the wander, as other rigs show it, counts as.
        within: Whether a change within one stretch counts.
    """

    white: float
    slow: float
    memory: float
    drift: float
    jump: float
    fresh: float
    weighed: float
    steered: float
    swung: float
    threshold: float
    smallest: float
    slipped: float = 0.0
    values: int = 12
    before: int = 3
    freedom: float = 4.0
    within: bool = True

    def exceeded_by(self, change: FeatureChange) -> bool:
        """Whether a change is more than happens without one, and worth a detection.

        What rises while the bit is off bottom may be the bit that touches.
        """
        counts = change.in_operation or (self.within and not (change.unloaded and change.size > 0.0))
        return counts and change.evidence >= self.threshold and abs(change.size) >= self.smallest


@dataclass(frozen=True)
class Uncertainty:
    """What is not known of the tracked parameters.

    Attributes:
        covariance: (p, p) of their values.
        wanders: (p, k), k independent ways in which they wander, standard deviations.
    """

    covariance: Array
    wanders: Array


@dataclass(frozen=True)
class FeatureChange:
    """The likeliest change of a feature.

    Attributes:
        evidence: Logarithm of the likelihood ratio.
        since: s.
        interval: s, 95 % interval of `since`.
        kind: ``step`` or ``ramp``.
        size: The largest so far, noise levels, signed.
        in_operation: Whether it may have begun between two stretches of work.
        unloaded: Whether the bit was off bottom when it began.
    """

    evidence: float
    since: float
    interval: tuple[float, float]
    kind: str
    size: float
    in_operation: bool
    unloaded: bool = False


def likeliest_change(series: FeatureSeries, uncertain: Uncertainty, wander: Wander) -> FeatureChange | None:
    """The change that explains a feature best; None if there are too few values.

    Args:
        series: The feature.
        uncertain: Parameters of the plant.
        wander: How the feature moves without a change.
    """
    means = means_of(series, wander.values)
    begins = _begins(series, means, wander.before)
    if not begins.size:
        return None
    factor = np.linalg.cholesky(covariance(means, uncertain, wander))
    white = solve_triangular(factor, means.value, lower=True)
    shapes = means.average(_shapes(series, begins, series.sensitivity @ uncertain.wanders))
    shaped = solve_triangular(factor, shapes, lower=True)
    norm = np.maximum(np.einsum("nk,nk->k", shaped, shaped), 1e-12)
    size = white @ shaped / norm
    total = wander.freedom + float(white @ white)
    left = np.maximum(total - size**2 * norm, 1e-9)
    evidence = 0.5 * (wander.freedom + means.time.size) * np.log(total / left)
    best = int(np.argmax(evidence))
    low, since, high = _quantiles(np.tile(begins, shapes.shape[1] // begins.size), evidence)
    shape = size[best] * shapes[:, best]
    interval = (low - _RESOLUTION_S, high + _RESOLUTION_S)
    return FeatureChange(
        float(evidence[best]), since, interval, "ramp" if begins.size <= best < 2 * begins.size else "step",
        float(shape[np.argmax(np.abs(shape))]), _touches_operation(series, interval),
        bool(series.load[min(int(np.searchsorted(series.time, since)), series.time.size - 1)] == 0.0),
    )  # fmt: skip


def _touches_operation(series: FeatureSeries, interval: tuple[float, float]) -> bool:
    last = np.flatnonzero(np.diff(series.stretch))  # values before what lies between two stretches
    return bool(np.any((interval[0] < series.time[last + 1]) & (interval[1] > series.time[last])))


def covariance(means: FeatureMeans, uncertain: Uncertainty, wander: Wander) -> Array:
    """Of the means (n, n) of a feature without a change."""
    time = means.time
    kept = np.exp(-np.abs(time[:, None] - time[None, :]) / wander.memory)
    drifted = (time - time[0]) / 600.0
    same = means.stretch[:, None] == means.stretch[None, :]
    own = (
        wander.white**2 * wander.values / means.count + (wander.fresh * np.exp(-means.age / _FADE_S)) ** 2
        + (wander.slipped * means.hook_load_moved) ** 2
    )  # fmt: skip
    moved = means.sensitivity @ uncertain.wanders
    whole = (
        _LEVEL**2 + wander.slow**2 * kept + wander.drift**2 * np.outer(drifted, drifted) + wander.jump**2 * same
        + wander.weighed**2 * np.outer(means.load, means.load)
        + wander.steered**2 * (np.minimum.outer(means.steering, means.steering) - means.steering[0])
        + wander.swung**2 * _alike(means.swing, _SWING) * _alike(means.pace, _PACE)
        + means.sensitivity @ uncertain.covariance @ means.sensitivity.T + moved @ moved.T
    )  # fmt: skip
    return np.asarray(whole + np.diag(own + 1e-6))


def _alike(values: Array, width: float) -> Array:
    """(n, n) correlation of what goes with a value (n,): 1 where it is the same."""
    return np.asarray(np.exp(-0.5 * ((values[:, None] - values[None, :]) / width) ** 2))


def _begins(series: FeatureSeries, means: FeatureMeans, before: int) -> Array:
    """Times at which a change may have begun: an even grid, finer in the last minutes, with a mean on either side."""
    if means.time.size <= before:
        return np.empty(0)
    first, last = means.end[before - 1], max(means.end[-2], means.begin[-1] - _RESOLUTION_S)
    grid = last - _RESOLUTION_S * np.arange(max(np.floor((last - first) / _RESOLUTION_S), 0.0) + 1.0)
    old = grid < series.time[-1] - _RECENT_S
    return np.asarray(np.concatenate([grid[~old], grid[old][::_THINNED]])[::-1])


def _shapes(series: FeatureSeries, begins: Array, moved: Array) -> Array:
    """(n, m): steps, ramps of 1 a minute, and steps of those numbers (n, k) that are seen; all for every onset."""
    time, window = series.time[:, None], series.window[:, None]
    after = np.maximum(time - begins[None, :], 0.0)
    inside = np.minimum(after, window)
    step, ramp = inside / window, (after - 0.5 * inside) * inside / window / 60.0
    largest = np.max(np.abs(moved), axis=0, initial=0.0)
    acting = [step * (moved[:, [k]] / largest[k]) for k in np.flatnonzero(largest > _SEEN)]
    return np.concatenate([step, ramp, *acting], axis=1)


def _quantiles(onsets: Array, evidence: Array) -> tuple[float, float, float]:
    """Lower end, middle and upper end (95 %) of the posterior over the time of onset, whatever the shape.

    The times are tried on a grid that is not even: each counts with the time that it stands for.
    """
    times, index = np.unique(onsets, return_inverse=True)
    weight = np.zeros(times.size)
    np.add.at(weight, index, np.exp(evidence - evidence.max()))
    total = np.cumsum(weight * (np.gradient(times) if times.size > 1 else 1.0))
    found = np.searchsorted(total / total[-1], (0.025, 0.5, 0.975))
    low, middle, high = times[np.minimum(found, times.size - 1)]
    return float(low), float(middle), float(high)
