"""Likelihood of a residual: a model discrepancy with a finite memory, plus white noise (Kennedy and O'Hagan 2001).

A channel's residual in noise units is r_k = d_k + e_k, with e white of variance 1 and d a first-order autoregression
of standard deviation ``size`` and time constant ``memory``. One pass of a Kalman filter gives the log density, and the
same pass whitens the columns of a Jacobian. How many samples count as independent follows from the memory.

A channel that accumulates has another loss, see `slider_drilling.gap.problem.step_loss`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.model import Array
from slider_drilling.process.jit_cache import njit

# Grid of discrepancies: standard deviations in noise units, and the number of memories from the sampling interval to
# the longest allowed one.
_SIZES = np.concatenate([[0.0], np.geomspace(0.1, 400.0, 22)])
_MEMORIES = 7
# Sizes evaluated in one pass, for every memory.
_SIDE_BY_SIDE = 4
# Relative difference below which two intervals are equal.
_EVEN = 1e-3
# Weights (between 1e-6 and 1) that are multiplied before their logarithm is taken.
_MULTIPLIED = 16

_compiled = njit(cache=True, error_model="numpy", nogil=True)


@dataclass(frozen=True)
class Discrepancy:
    """Discrepancy of one channel.

    Attributes:
        size: Standard deviation in noise units, 0 for none.
        memory: Time constant, s.
    """

    size: float
    memory: float


@_compiled
def kalman_whiten(rows: Array, interval: Array, size: float, memory: float, white: Array, spread: Array) -> None:
    """Whiten rows with a Kalman filter, into given arrays.

    Args:
        rows: (M, n) in noise units.
        interval: (n,) s since the sample before; the first is not read.
        size: Standard deviation of the discrepancy, noise units.
        memory: Its time constant, s.
        white: (M, n) result: innovations over their standard deviation.
        spread: (n,) result: standard deviations of the innovations.
    """
    mean = np.zeros(rows.shape[0])
    power = size * size
    kept = 1.0
    for k in range(rows.shape[1]):
        if k > 0:
            if k == 1 or abs(interval[k] - interval[k - 1]) > _EVEN * interval[k]:
                kept = np.exp(-interval[k] / memory)
            for m in range(rows.shape[0]):
                mean[m] *= kept
            power = kept * kept * power + (1.0 - kept * kept) * size * size
        total = power + 1.0
        deviation = np.sqrt(total)
        spread[k] = deviation
        gain = power / total
        for m in range(rows.shape[0]):
            innovation = rows[m, k] - mean[m]
            white[m, k] = innovation / deviation
            mean[m] += gain * innovation
        power *= 1.0 - gain


@_compiled
def neg2_log_likelihood(residual: Array, interval: Array, sizes: Array, memories: Array) -> Array:
    """(C,) ``-2 log p`` of a residual under C discrepancies, without the constant ``n log 2 pi``.

    With even sampling the filters' variances soon become constant: from then on only the innovations change. The inner
    loops run over all discrepancies, so that the compiler vectorises them.

    Args:
        residual: (n,) in noise units.
        interval: (n,) s since the sample before.
        sizes: (C,) noise units.
        memories: (C,) s.
    """
    count = sizes.size
    squares, logs, product = np.zeros(count), np.zeros(count), np.ones(count)
    kept, fresh, innovation, fade = np.zeros(count), sizes * sizes, np.zeros(count), np.zeros(count)
    power, weight, repeated = np.zeros(count), np.ones(count), np.zeros(count)
    before, steps, repeats, settled = 0.0, 0, 0, False
    for k in range(residual.size):
        if k == 1 or (k > 1 and abs(interval[k] - interval[k - 1]) > _EVEN * interval[k]):
            kept[:] = np.exp(-interval[k] / memories)
            fresh[:] = (1.0 - kept * kept) * sizes * sizes
            settled = False
        here = residual[k]
        if settled:
            repeats += 1
            for m in range(count):
                innovation[m] = (here - kept[m] * before) + fade[m] * innovation[m]
                repeated[m] += innovation[m] * innovation[m]
        else:
            if repeats:
                _add_repeated(squares, logs, weight, repeated, repeats)
                repeats = 0
            for m in range(count):
                fade[m] = kept[m] * weight[m]
            moved = _advance_variances(power, weight, kept, fresh)
            for m in range(count):
                innovation[m] = (here - kept[m] * before) + fade[m] * innovation[m]
            for m in range(count):
                squares[m] += weight[m] * innovation[m] * innovation[m]
                product[m] *= weight[m]
            settled, steps = k > 1 and not moved, steps + 1
            if settled or steps == _MULTIPLIED:
                logs -= np.log(product)
                product[:], steps = 1.0, 0
            if settled:
                for m in range(count):
                    fade[m] = kept[m] * weight[m]
        before = here
    _add_repeated(squares, logs, weight, repeated, repeats)
    return squares + logs - np.log(product)


@_compiled
def _advance_variances(power: Array, weight: Array, kept: Array, fresh: Array) -> bool:
    """Advance the filters' variances by one sample, in place.

    Args:
        power: (C,) variance of the discrepancy after a sample.
        weight: (C,) one over the variance of an innovation.
        kept: (C,) factor on the discrepancy over an interval.
        fresh: (C,) variance that an interval adds.

    Returns:
        Whether any variance still changes.
    """
    moved = 0
    for m in range(power.size):
        weight[m] = 1.0 / (kept[m] * kept[m] * power[m] + fresh[m] + 1.0)
    for m in range(power.size):
        now = 1.0 - weight[m]
        moved += abs(now - power[m]) > 1e-9
        power[m] = now
    return moved > 0


@_compiled
def _add_repeated(squares: Array, logs: Array, weight: Array, repeated: Array, repeats: int) -> None:
    """Add so many samples of constant weight to squares and logs (C,); ``repeated`` (C,), their squares, becomes 0."""
    for m in range(weight.size):
        squares[m] += weight[m] * repeated[m]
        logs[m] -= repeats * np.log(weight[m])
        repeated[m] = 0.0


@_compiled
def _best(residual: Array, interval: Array, sizes: Array, memories: Array) -> tuple[float, float, float]:
    """The least ``-2 log p`` over the grid, its size and its memory; the first size is 0."""
    white = float(np.sum(residual * residual))
    found = (white, 0.0, memories[0])
    # For every memory the cost has one minimum over size, near the size of the residual itself. A few sizes around it
    # are evaluated in one pass, and further ones where the best is the first or the last of them.
    guess = int(np.searchsorted(sizes, np.sqrt(max(white / residual.size - 1.0, 0.0))))
    highest = max(sizes.size - _SIDE_BY_SIDE, 1)
    first = np.full(memories.size, min(max(guess - 2, 1), highest))
    least, left = np.full(memories.size, np.inf), np.arange(memories.size)
    while left.size:
        at = (first[left].reshape(-1, 1) + np.arange(_SIDE_BY_SIDE)).ravel()
        costs = neg2_log_likelihood(residual, interval, sizes[at], memories[left].repeat(_SIDE_BY_SIDE))
        moved = np.zeros(left.size, dtype=np.bool_)
        for row, memory in enumerate(left):
            own = costs[row * _SIDE_BY_SIDE : (row + 1) * _SIDE_BY_SIDE]
            best = int(np.argmin(own))
            if own[best] < found[0]:
                found = (own[best], sizes[first[memory] + best], memories[memory])
            if own[best] < least[memory] and best in (0, _SIDE_BY_SIDE - 1):
                least[memory] = own[best]
                beside = first[memory] + (_SIDE_BY_SIDE - 1 if best else 1 - _SIDE_BY_SIDE)
                first[memory] = min(max(beside, 1), highest)
                moved[row] = True
        left = left[moved]
    return found


def memory_grid(interval: Array, longest: float) -> Array:
    """(k,) memories that a discrepancy may have, s, from the sampling interval to the longest allowed one.

    Args:
        interval: (n,) s since the sample before.
        longest: Longest memory, s; a longer one would be a change of the model.
    """
    if interval.size < 2:
        return np.array([longest])
    shortest = min(float(np.median(interval[1:])), 0.5 * longest)
    return np.geomspace(shortest, longest, _MEMORIES)


def fit_discrepancy(residual: Array, interval: Array, memories: Array) -> tuple[float, Discrepancy]:
    """The likeliest discrepancy of a residual.

    Args:
        residual: (n,) in noise units.
        interval: (n,) s since the sample before.
        memories: (k,) s, the memories that it may have.

    Returns:
        ``-2 log p`` under it, and the discrepancy.
    """
    cost, size, memory = _best(np.ascontiguousarray(residual), interval, _SIZES, memories)
    return float(cost), Discrepancy(float(size), float(memory))


def whiten(rows: Array, interval: Array, discrepancy: Discrepancy) -> tuple[Array, Array]:
    """Whiten rows with the filter of a discrepancy.

    Args:
        rows: (M, n) in noise units.
        interval: (n,) s since the sample before.
        discrepancy: The discrepancy.

    Returns:
        (M, n) whitened rows, and (n,) log variances of the innovations.
    """
    rows = np.ascontiguousarray(rows)
    white, spread = np.empty_like(rows), np.empty(rows.shape[1])
    kalman_whiten(rows, interval, discrepancy.size, discrepancy.memory, white, spread)
    return white, 2.0 * np.log(spread)
