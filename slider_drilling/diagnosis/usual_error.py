"""The usual error of a model over a log: single events in it, such as an operation, do not count."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.model import Array
from slider_drilling.gap.problem.problem import Piece, Problem

_BLOCK_S = 20.0
_KEPT = 0.8  # of the blocks, those with the smallest errors
_MIN_BLOCKS = 5  # below which all count


def usual_square(piece: Piece, residual: Array) -> float:
    """Mean square of a channel's residual (N,) over blocks of 20 s, without the worst fifth of them."""
    own, time = residual[piece.rows] ** 2, piece.channel.time
    block = ((time - time[0]) // _BLOCK_S).astype(int)
    count = np.bincount(block)
    means = np.bincount(block, weights=own)[count > 0] / count[count > 0]
    if means.size < _MIN_BLOCKS:
        return float(np.mean(own))
    return float(np.mean(np.sort(means)[: round(_KEPT * means.size)]))


def usual_gaps(problem: Problem, residual: Array) -> dict[str, float]:
    """E by channel of a residual (N,) in noise units: the root of `usual_square`, over all runs."""
    squares: dict[str, list[tuple[float, int]]] = {}
    for piece in problem.pieces:
        squares.setdefault(piece.name, []).append((usual_square(piece, residual), piece.channel.time.size))
    return {
        name: float(np.sqrt(np.average([own for own, _ in values], weights=[size for _, size in values])))
        for name, values in squares.items()
    }


def usual_gap(problem: Problem, residual: Array) -> float:
    """E of a residual (N,) over all channels that count, each sample alike."""
    pieces = [piece for piece in problem.pieces if not piece.channel.accumulates] or list(problem.pieces)
    sizes = [piece.channel.time.size for piece in pieces]
    return float(np.sqrt(np.average([usual_square(piece, residual) for piece in pieces], weights=sizes)))


def counted(problem: Problem) -> NDArray[np.bool_]:
    """(N,) whether each sample counts in E: a channel in which an error stays has few samples and large errors.

    It counts in the likelihood, by its missed steps. All samples count where there is no other channel.
    """
    rows = np.zeros(problem.size, dtype=bool)
    for piece in problem.pieces:
        rows[piece.rows] = not piece.channel.accumulates
    return rows if rows.any() else ~rows
