"""Loss of a channel that accumulates: a missed step counts once, not again in every later sample.

A body that sticks and breaks free moves by an amount that depends on everything before. A simulation that misses one
such event is off by that amount ever after, although it may be right about all else. The residual r of such a channel
is therefore split into a path of steps p, which costs the logarithm of their size, and the rest, which costs its
square:

    min over p of  sum_k (r_k - p_k)^2 + 2 f^2 sum_k ln(1 + |p_k - p_(k-1)| / f),   p_(-1) = 0

A small step costs as in the fused lasso (Tibshirani et al., J. R. Stat. Soc. B 67, 2005) with slope 2 f. The logarithm
is approximated by repeating that with each step's own slope (Candes, Wakin and Boyd, J. Fourier Anal. Appl. 14, 2008).
"""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.model import Array
from slider_drilling.process.jit_cache import njit

_MAX_ACTIVE_SETS = 50  # it takes a handful
_REWEIGHTED = 4  # times that the slopes follow the steps found

# Compiled: a search evaluates thousands a second, each a few dozen samples long.
_compiled = njit(cache=True, error_model="numpy", nogil=True)


@_compiled
def step_loss(residual: Array, free: float) -> tuple[Array, Array]:
    """The loss of each sample, and its derivative.

    Args:
        residual: (n,) in noise units.
        free: f, the step size in noise units beyond which a step costs by its logarithm.

    Returns:
        (n,) loss of each sample with its own step, and (n,) half the derivative of the total loss.
    """
    steps = np.zeros_like(residual)
    path = steps
    for _ in range(_REWEIGHTED):
        path = step_path(residual, free / (1.0 + np.abs(steps) / free))
        if not path.any():
            break
        steps[0] = path[0]
        steps[1:] = np.diff(path)
    rest = residual - path
    return rest**2 + 2.0 * free**2 * np.log1p(np.abs(steps) / free), rest


@_compiled
def step_path(residual: Array, bound: Array) -> Array:
    """(n,) path p that minimises ``|r - p|^2 / 2 + sum bound_k |p_k - p_(k-1)|`` with ``p_(-1) = 0``.

    Solved through its dual, ``min |r - D' u|^2`` with ``|u_k| <= bound_k``, by the primal-dual active-set method. It
    converges since D D' is an M-matrix (Hintermueller, Ito and Kunisch, SIAM J. Optim. 13, 2002).

    Args:
        residual: (n,) r.
        bound: (n,) above zero.
    """
    # Without bounds u_k is the sum of all residuals from k on. If all lie within the bounds, no step lowers the cost.
    dual = np.cumsum(residual[::-1])[::-1].copy()
    if np.all(np.abs(dual) <= bound):
        return np.zeros_like(residual)
    slope = residual.copy()
    slope[1:] -= residual[:-1]
    held = np.where(np.abs(dual) > bound, np.sign(dual), 0.0)
    for _ in range(_MAX_ACTIVE_SETS):
        dual = _solve(slope, held, bound)
        gradient = slope - _normal(dual)
        beyond = np.where(np.abs(dual) > bound, np.sign(dual), 0.0)
        now = np.where(held == 0.0, beyond, np.where(gradient * held > 0.0, held, 0.0))
        if np.array_equal(now, held):
            break
        held = now
    dual = np.minimum(np.maximum(dual, -bound), bound)
    path = residual - dual
    path[:-1] += dual[1:]
    return path


@_compiled
def _solve(slope: Array, held: Array, bound: Array) -> Array:
    """u with ``(D D' u)_k = slope_k`` where it is free, and at its bound where it is held.

    Held elements cut the tridiagonal system into pieces, each solved by elimination from left to right.
    """
    size = slope.size
    dual, pivot = bound * held, np.ones(size)
    for k in range(size):
        if held[k] != 0.0:
            continue
        dual[k] = slope[k]
        pivot[k] = 1.0 if k == 0 else 2.0
        if k > 0:
            dual[k] += dual[k - 1] / pivot[k - 1]
            if held[k - 1] == 0.0:
                pivot[k] -= 1.0 / pivot[k - 1]
    for k in range(size - 1, -1, -1):
        if held[k] == 0.0:
            dual[k] = (dual[k] + (dual[k + 1] if k + 1 < size else 0.0)) / pivot[k]
    return dual


@_compiled
def _normal(dual: Array) -> Array:
    """D D' u."""
    product = 2.0 * dual
    product[0] = dual[0]
    product[1:] -= dual[:-1]
    product[:-1] -= dual[1:]
    return product
