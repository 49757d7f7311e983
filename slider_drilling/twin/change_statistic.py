"""Generalised likelihood ratio of a change in a feature, against how that feature wanders without one.

The feature is a Gaussian process: an unknown level, a slow wander with a memory, a short one, a drift, what every
stretch of work has of its own and what is left of the operation before it, and what the numbers of the plant add that
are uncertain or wander themselves. Its size is unknown: with an inverse-gamma prior the evidence is a Student t ratio.
A change adds, from an unknown time on, a step, a ramp, or a step of one of the plant's numbers, which shows as much as
the work lets it (Basseville and Nikiforov, Detection of Abrupt Changes, 1993, chapter 4). It may begin while nothing is
compared: then only what lies between two stretches dates it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from slider_drilling.twin.samples import Array

_LEVEL = 30.0  # noise levels: standard deviation of the unknown level
PRIOR_FREEDOM = 20.0
"""Samples that the population's size of the wander counts as."""
_LATEST_S = 5.0  # before now, until when a change can have begun
_RESOLUTION_S = 5.0  # between two values of a feature, which show an onset no better
_RECENT_S, _THINNED = 240.0, 2  # before which one in so many times of onset is tried
_LATE, _LATE_S, _LATE_MEMORY_S = 3.0, 30.0, 40.0  # standard deviations of a number that act so late, for so long
_WELL_KNOWN_S, _JUST_S = 45.0, 180.0  # width of the interval of a step that is well known; for which it is new
_SWING = 0.12  # of the logarithm of the drive's swing, within which what the model has wrong is alike
_SEEN = 0.3  # noise levels of a number's wander, from which a step of it is tried


@dataclass(frozen=True)
class Thresholds:
    """Evidence that a change needs, by how it began.

    Attributes:
        sudden: A step during work that has just happened.
        gradual: A ramp that began during work.
        long_ago: A step during work that is seen late, or whose time is poorly known.
        after_operation: Whatever may have begun during an operation, or soon after it: that leaves more than work does.
    """

    sudden: float
    gradual: float
    long_ago: float
    after_operation: float


@dataclass(frozen=True)
class Wander:
    """How a feature moves on rigs that do not change: standard deviations in noise levels.

    Attributes:
        short: Of the part with a brief memory.
        brief: s.
        slow: Of the part with a memory.
        memory: s.
        drift: Of the drift in 10 min.
        jump: Of what the level of one stretch of work has of its own.
        fresh: Of what an operation leaves, when the stretch after it begins.
        fade: s, in which that falls to 1 / e.
        burst: s, memory of that; infinite if it only fades.
        weighed: Of what goes with the load on the bit, at all of it.
        loaded: Of what a change of the load on the bit by all of it brings for a while.
        settling: s, memory of that.
        steered: Of what stays when the centre of the rocking has moved by 1 rad.
        swung: Of what a swing of the drive has of its own, beside other swings.
        thresholds: Evidence that rigs without a change do not reach.
        smallest: Change that is worth a detection.
        before: Values that are needed before a change.
        relaxing: s after an operation, in which what it left still relaxes.
        fall: Evidence that a fall needs, where that is less; None if falls are as usual as rises.
    """

    short: float
    brief: float
    slow: float
    memory: float
    drift: float
    jump: float
    fresh: float
    fade: float
    burst: float
    weighed: float
    loaded: float
    settling: float
    steered: float
    swung: float
    thresholds: Thresholds
    smallest: float
    before: int = 12
    relaxing: float = 150.0
    fall: Thresholds | None = None

    def exceeded_by(self, change: FeatureChange) -> bool:
        """Whether a change is more than happens without one, and worth a detection."""
        thresholds = self.thresholds if self.fall is None or change.size >= 0.0 else self.fall
        needed: float = getattr(thresholds, change.beginning)
        return change.evidence >= needed and abs(change.size) >= self.smallest


@dataclass(frozen=True)
class FeatureSeries:
    """A feature over time.

    Attributes:
        time: s, (n,), increasing.
        value: Noise levels, (n,).
        stretch: Number of the stretch of work, (n,).
        stretch_start: s, when that stretch began, (n,).
        window: s over which each value was taken, (n,).
        load, loading, steering, swing: The load, how it and the centre change, and the swing of the drive, see
            `activity.Activity`, (n,).
        sensitivity: (n, p) to the tracked parameters.
    """

    time: Array
    value: Array
    stretch: Array
    stretch_start: Array
    window: Array
    load: Array
    loading: Array
    steering: Array
    swing: Array
    sensitivity: Array


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
        beginning: ``sudden``, ``gradual``, ``long_ago`` or ``after_operation``, see `Thresholds`.
    """

    evidence: float
    since: float
    interval: tuple[float, float]
    kind: str
    size: float
    beginning: str


def likeliest_change(series: FeatureSeries, uncertain: Uncertainty, wander: Wander) -> FeatureChange | None:
    """The change that explains a feature best; None if there are too few values.

    Args:
        series: The feature.
        uncertain: Parameters of the plant.
        wander: How the feature moves without a change.
    """
    begins = _begins(series.time, wander.before)
    if not begins.size:
        return None
    factor = np.linalg.cholesky(covariance(series, uncertain, wander))
    white = solve_triangular(factor, series.value, lower=True)
    shapes = _shapes(series, begins, series.sensitivity @ uncertain.wanders)
    shaped = solve_triangular(factor, shapes, lower=True)
    norm = np.einsum("nk,nk->k", shaped, shaped)
    size = white @ shaped / np.maximum(norm, 1e-300)
    total = PRIOR_FREEDOM + float(white @ white)
    left = np.maximum(total - size**2 * norm, 1e-9)
    evidence = 0.5 * (PRIOR_FREEDOM + series.time.size) * np.log(total / left)
    best = int(np.argmax(evidence))
    onsets = np.tile(begins, shapes.shape[1] // begins.size)
    low, since, high = _quantiles(onsets, evidence)
    shape = size[best] * shapes[:, best]
    kind = "ramp" if begins.size <= best < 2 * begins.size else "step"
    interval = (low - _RESOLUTION_S, high + _RESOLUTION_S)
    return FeatureChange(
        float(evidence[best]), since, interval, kind, float(shape[np.argmax(np.abs(shape))]),
        _beginning(series, kind, interval, wander.relaxing),
    )  # fmt: skip


def _beginning(series: FeatureSeries, kind: str, interval: tuple[float, float], relaxing: float) -> str:
    """How a change began (`FeatureChange.beginning`); what an operation left relaxes for so many seconds."""
    last = np.flatnonzero(np.diff(series.stretch))  # values before what lies between two stretches
    ended, relaxed = series.time[last], series.stretch_start[last + 1] + relaxing
    if np.any((interval[0] < relaxed) & (interval[1] > ended)):
        return "after_operation"
    if kind == "ramp":
        return "gradual"
    known = interval[1] - interval[0] <= _WELL_KNOWN_S and series.time[-1] - interval[0] <= _JUST_S
    return "sudden" if known else "long_ago"


def covariance(series: FeatureSeries, uncertain: Uncertainty, wander: Wander) -> Array:
    """Of the values (n, n) of a feature without a change."""
    time = series.time
    apart = np.abs(time[:, None] - time[None, :])
    drifted = (time - time[0]) / 600.0
    same = series.stretch[:, None] == series.stretch[None, :]
    fresh = wander.fresh * np.exp(-(time - series.stretch_start) / wander.fade)
    kept = np.exp(-apart / wander.memory)
    whole = (
        _LEVEL**2 + wander.short**2 * np.exp(-apart / wander.brief) + wander.slow**2 * kept
        + wander.drift**2 * np.outer(drifted, drifted)
        + same * (wander.jump**2 + np.outer(fresh, fresh) * np.exp(-apart / wander.burst))
        + wander.weighed**2 * np.outer(series.load, series.load)
        + np.outer(wander.loaded * series.loading, wander.loaded * series.loading) * np.exp(-apart / wander.settling)
        + wander.steered**2 * _random_walk(series.steering)
        + wander.swung**2 * np.exp(-0.5 * ((series.swing[:, None] - series.swing[None, :]) / _SWING) ** 2)
        + series.sensitivity @ uncertain.covariance @ series.sensitivity.T
    )  # fmt: skip
    for moved in (series.sensitivity @ uncertain.wanders).T:
        late = _LATE * (moved - np.interp(time - _LATE_S, time, moved))
        whole += kept * np.outer(moved, moved) + np.exp(-apart / _LATE_MEMORY_S) * np.outer(late, late)
    return np.asarray(whole + 1e-6 * np.eye(time.size))


def _random_walk(travel: Array) -> Array:
    """Covariance (n, n) of a walk that goes on as far as the work moves something; travel: variance so far, (n,)."""
    return np.minimum.outer(travel, travel) - travel[0]


def _begins(time: Array, before: int) -> Array:
    """Times at which a change may have begun: an even grid that is finer in the last minutes."""
    if time.size <= before:
        return np.empty(0)
    first, last = time[before - 1], time[-1] - _LATEST_S
    grid = last - _RESOLUTION_S * np.arange(max(np.floor((last - first) / _RESOLUTION_S), -1.0) + 1.0)
    old = grid < time[-1] - _RECENT_S
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
