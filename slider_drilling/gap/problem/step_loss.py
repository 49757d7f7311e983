"""Steps that a simulation missed in a channel that accumulates: one mistake each, not one for every later sample.

A bit that breaks free turns by an angle that hangs on everything before; a simulation that misses one such event is off
by that angle ever after, although it may be right about all else. The residual of such a channel is therefore split
into a path of steps, paid for by the logarithm of their size, and the rest, paid for by its square:

    min over p of  sum_k (r_k - p_k)^2 + 2 f^2 sum_k ln(1 + |p_k - p_(k-1)| / f),   p_(-1) = 0

A small step costs what the fused lasso (Tibshirani et al., J. R. Stat. Soc. B 67, 2005) with slope 2 f would charge;
the logarithm is approached by repeating that with each step's own slope (Candes, Wakin and Boyd, J. Fourier Anal. Appl.
14, 2008).
"""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.model import Array
from slider_drilling.process.jit_cache import njit

_TURNS = 50     # of the active set; it settles in a handful
_REPRICED = 4   # times that the slopes follow the steps found

# A search asks for thousands of these a second, each a few dozen samples long.
_compiled = njit(cache=True, error_model="numpy", nogil=True)


@_compiled
def step_loss(residual: Array, free: float) -> tuple[Array, Array]:
    """The loss (n,) of each sample, its own step's price included, and half the loss's derivative (n,).

    residual (n,) in noise floors; free: f, noise floors.
    """
    steps = np.zeros_like(residual)
    path = steps
    for _ in range(_REPRICED):
        path = step_path(residual, free / (1.0 + np.abs(steps) / free))
        if not path.any():
            break
        steps[0] = path[0]
        steps[1:] = np.diff(path)
    rest = residual - path
    return rest**2 + 2.0 * free**2 * np.log1p(np.abs(steps) / free), rest


@_compiled
def step_path(residual: Array, bound: Array) -> Array:
    """p (n,) that minimises ``|r - p|^2 / 2 + sum bound_k |p_k - p_(k-1)|`` with ``p_(-1) = 0``; bound (n,) above zero.

    Solved through its dual, ``min |r - D' u|^2`` with ``|u_k| <= bound_k``, by the primal-dual active-set method, which
    settles for sure since D D' is an M-matrix (Hintermueller, Ito and Kunisch, SIAM J. Optim. 13, 2002).
    """
    # Without bounds u is the sum of all residuals from k on: within them no step is worth its price.
    dual = np.cumsum(residual[::-1])[::-1].copy()
    if np.all(np.abs(dual) <= bound):
        return np.zeros_like(residual)
    slope = residual.copy()
    slope[1:] -= residual[:-1]
    held = np.where(np.abs(dual) > bound, np.sign(dual), 0.0)
    for _ in range(_TURNS):
        dual = _solve(slope, held, bound)
        pull = slope - _normal(dual)
        beyond = np.where(np.abs(dual) > bound, np.sign(dual), 0.0)
        now = np.where(held == 0.0, beyond, np.where(pull * held > 0.0, held, 0.0))
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

    Held ones cut the tridiagonal system into pieces, each solved by elimination from its left end to its right.
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
