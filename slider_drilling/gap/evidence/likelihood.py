"""One likelihood for a residual: a discrepancy that forgets, plus white noise (Kennedy and O'Hagan 2001).

A channel's residual in noise units is r_k = d_k + e_k with e white of variance 1 and d a first-order autoregression of
standard deviation `size` and memory `memory`. One pass of a Kalman filter gives the log density, and the same pass
whitens a Jacobian's columns. How many samples count as independent follows from the memory; nothing else has to.

A channel that accumulates keeps what was missed once: its residual is a path of few steps plus white noise, see
`slider_drilling.gap.problem.step_loss`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.model import Array
from slider_drilling.process.jit_cache import njit

# The grid on which the discrepancy is looked for: its standard deviation in noise units, and its memory as shares of
# the longest allowed one, down to the sampling interval.
_SIZES = np.concatenate([[0.0], np.geomspace(0.1, 400.0, 22)])
_MEMORIES = 7
_SIDE_BY_SIDE = 4  # sizes looked at in one pass, for every memory
_EVEN = 1e-3  # intervals that differ by less are one
_MULTIPLIED = 16  # weights, between 1e-6 and 1, that are multiplied before their logarithm is taken

_compiled = njit(cache=True, error_model="numpy", nogil=True)


@dataclass(frozen=True)
class Discrepancy:
    """size: standard deviation in noise units, 0 for none; memory: s."""

    size: float
    memory: float


@_compiled
def kalman_whiten(rows: Array, interval: Array, size: float, memory: float, white: Array, spread: Array) -> None:
    """Whitened innovations of rows (M, n) into white (M, n), and their standard deviations into spread (n,).

    interval: (n,) s since the sample before (the first is not read).
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
            surprise = rows[m, k] - mean[m]
            white[m, k] = surprise / deviation
            mean[m] += gain * surprise
        power *= 1.0 - gain


@_compiled
def neg2_log_likelihood(residual: Array, interval: Array, sizes: Array, memories: Array) -> Array:
    """(C,) ``-2 log p`` of a residual (n,) under C discrepancies side by side.

    Without the constant of white noise alone, ``n log 2 pi``. Evenly sampled, the filters soon repeat themselves: from
    then on nothing changes but the surprises. Loops of few arrays, over all discrepancies, are what a compiler makes
    vector instructions of.
    """
    count = sizes.size
    squares, logs, product = np.zeros(count), np.zeros(count), np.ones(count)
    kept, fresh, surprise, fade = np.zeros(count), sizes * sizes, np.zeros(count), np.zeros(count)
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
                surprise[m] = (here - kept[m] * before) + fade[m] * surprise[m]
                repeated[m] += surprise[m] * surprise[m]
        else:
            if repeats:
                _add_repeated(squares, logs, weight, repeated, repeats)
                repeats = 0
            for m in range(count):
                fade[m] = kept[m] * weight[m]
            moved = _renewed(power, weight, kept, fresh)
            for m in range(count):
                surprise[m] = (here - kept[m] * before) + fade[m] * surprise[m]
            for m in range(count):
                squares[m] += weight[m] * surprise[m] * surprise[m]
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
def _renewed(power: Array, weight: Array, kept: Array, fresh: Array) -> bool:
    """One step of the filters' variances (C,): of what is known of the discrepancy, and one over that of a sample.
    fresh: (C,) what an interval adds. Whether any of them is still on the move.
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
    """What so many samples of the same weight add to squares and logs (C,); repeated: (C,) their squares, emptied."""
    for m in range(weight.size):
        squares[m] += weight[m] * repeated[m]
        logs[m] -= repeats * np.log(weight[m])
        repeated[m] = 0.0


@_compiled
def _best(residual: Array, interval: Array, sizes: Array, memories: Array) -> tuple[float, float, float]:
    """The least ``-2 log p``, its size and its memory; sizes: white noise first."""
    white = float(np.sum(residual * residual))
    found = (white, 0.0, memories[0])
    # One valley in the size, near that which the residual would have were all of it discrepancy: for every memory
    # some neighbouring sizes are looked at in one pass, and those beside them where the best is the first or last.
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
    """Memories s that a discrepancy may have: from the sampling interval to the longest allowed.

    longest: s; a discrepancy that remembers longer would be a change of the model.
    """
    if interval.size < 2:
        return np.array([longest])
    shortest = min(float(np.median(interval[1:])), 0.5 * longest)
    return np.geomspace(shortest, longest, _MEMORIES)


def fit_discrepancy(residual: Array, interval: Array, memories: Array) -> tuple[float, Discrepancy]:
    """``-2 log p`` of a residual (n,) in noise units under the discrepancy that suits it best, and that discrepancy."""
    cost, size, memory = _best(np.ascontiguousarray(residual), interval, _SIZES, memories)
    return float(cost), Discrepancy(float(size), float(memory))


def whiten(rows: Array, interval: Array, discrepancy: Discrepancy) -> tuple[Array, Array]:
    """Rows (M, n) through the filter of a discrepancy: whitened (M, n), and (n,) the innovations' log variance."""
    rows = np.ascontiguousarray(rows)
    white, spread = np.empty_like(rows), np.empty(rows.shape[1])
    kalman_whiten(rows, interval, discrepancy.size, discrepancy.memory, white, spread)
    return white, 2.0 * np.log(spread)
