"""Generalised likelihood ratio of a change in a feature, against how that feature wanders without one.

The feature is a Gaussian process: an unknown level, a slow wander with a memory, a short one over the window that the
feature is taken over, a drift, a new level after every change of what the rig does, and what the uncertain parameters
of the plant add. Its size is unknown: with an inverse-gamma prior the evidence is a Student t ratio. A change adds a
step or a ramp from an unknown time on (Basseville and Nikiforov, Detection of Abrupt Changes, 1993, chapter 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from slider_drilling.twin.samples import Array

_LEVEL = 30.0  # noise levels: standard deviation of the unknown level
_PRIOR_FREEDOM = 20.0  # samples that the population's size of the wander counts as
_LATEST_S = 5.0  # before now, until when a change can have begun
_RESOLUTION_S = 5.0  # between two values of a feature, which show an onset no better
_RECENT_S = 180.0
_MIN_BEFORE = 8  # values of the same work before a change


@dataclass(frozen=True)
class Wander:
    """How a feature moves on rigs that do not change: standard deviations in noise levels.

    Attributes:
        short: Of the part that is new in every window.
        slow: Of the part with a memory.
        memory: s.
        drift: Of the drift in 10 min.
        jump: Of the level after a change of what the rig does.
        smallest: Change that is worth a detection.
    """

    short: float
    slow: float
    memory: float
    drift: float
    jump: float
    smallest: float


@dataclass(frozen=True)
class Change:
    """The likeliest change of a feature.

    Attributes:
        evidence: Logarithm of the likelihood ratio.
        since: s.
        interval: s, 95 % interval of `since`.
        kind: ``step`` or ``ramp``.
        size: Of the change by now, noise levels, signed.
    """

    evidence: float
    since: float
    interval: tuple[float, float]
    kind: str
    size: float


def likeliest_change(
    time: Array, value: Array, work: Array, window: Array, sensitivity: Array, covariance: Array, wander: Wander
) -> Change | None:
    """The change that explains a feature best.

    Args:
        time: s, (n,), increasing.
        value: Noise levels, (n,).
        work: (n,) counter of what the rig does: another number, another level.
        window: s over which each value was taken, (n,).
        sensitivity: (n, p) to the tracked parameters.
        covariance: (p, p) of them.
        wander: How the feature moves without a change.

    Returns:
        None if there are too few values.
    """
    if time.size < 2 * _MIN_BEFORE:
        return None
    factor = np.linalg.cholesky(_covariance(time, work, window, sensitivity, covariance, wander))
    white = solve_triangular(factor, value, lower=True)
    candidates = _candidates(time, work)
    if not candidates.size:
        return None
    shapes = np.concatenate([_steps(time, window, candidates), _ramps(time, window, candidates)], axis=1)
    shaped = solve_triangular(factor, shapes, lower=True)
    norm = np.einsum("nk,nk->k", shaped, shaped)
    size = white @ shaped / np.maximum(norm, 1e-300)
    total = _PRIOR_FREEDOM + float(white @ white)
    left = np.maximum(total - size**2 * norm, 1e-9)
    evidence = 0.5 * (_PRIOR_FREEDOM + time.size) * np.log(total / left)
    best = int(np.argmax(evidence))
    begins = np.concatenate([candidates, candidates])
    return Change(
        float(evidence[best]), float(begins[best]), _interval(begins, evidence), _kind(best, candidates.size),
        float(size[best] * shapes[-1, best]),
    )  # fmt: skip


def _candidates(time: Array, work: Array) -> Array:
    """Times at which a change may have begun: all of the last minutes, every third of those before.

    Each has some values of the same work before it: what an operation left behind fades in the first of them.
    """
    begins = np.concatenate([[0], np.flatnonzero(np.diff(work) != 0.0) + 1])
    index = np.arange(time.size)
    in_work = index - begins[np.searchsorted(begins, index, side="right") - 1]
    possible = time[(in_work >= _MIN_BEFORE) & (time <= time[-1] - _LATEST_S)]
    recent = possible >= time[-1] - _RECENT_S
    return np.concatenate([possible[~recent][::3], possible[recent]])


def _kind(index: int, candidates: int) -> str:
    return "step" if index < candidates else "ramp"


def _interval(begins: Array, evidence: Array) -> tuple[float, float]:
    """95 % interval of the posterior over the time of onset, whatever the shape."""
    order = np.argsort(begins, kind="stable")
    weight = np.cumsum(np.exp(evidence[order] - evidence.max()))
    low, high = np.searchsorted(weight / weight[-1], (0.025, 0.975))
    first, last = float(begins[order][low]), float(begins[order][min(high, order.size - 1)])
    return first - _RESOLUTION_S, last + _RESOLUTION_S


def _covariance(
    time: Array, work: Array, window: Array, sensitivity: Array, covariance: Array, wander: Wander
) -> Array:  # fmt: skip
    apart = np.abs(time[:, None] - time[None, :])
    overlap = np.maximum(1.0 - apart / np.minimum(window[:, None], window[None, :]), 0.0)
    since = (time - time[0]) / 600.0
    jumps = np.where(work[:, None] == work[None, :], wander.jump**2, 0.0)
    whole = (
        _LEVEL**2 + wander.short**2 * overlap + wander.slow**2 * np.exp(-apart / wander.memory)
        + wander.drift**2 * np.outer(since, since) + jumps + sensitivity @ covariance @ sensitivity.T
    )  # fmt: skip
    return np.asarray(whole + 1e-6 * np.eye(time.size))


def _steps(time: Array, window: Array, begins: Array) -> Array:
    """(n, k): 0 before, 1 after, in between the share of the window that lies after."""
    return np.clip((time[:, None] - begins[None, :]) / window[:, None], 0.0, 1.0)


def _ramps(time: Array, window: Array, begins: Array) -> Array:
    """(n, k): mean over the window of a ramp of 1 a minute."""
    after = np.maximum(time[:, None] - begins[None, :], 0.0)
    inside = np.minimum(after, window[:, None])
    return np.asarray((after - 0.5 * inside) * inside / window[:, None] / 60.0)
