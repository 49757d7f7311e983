"""The usual error of a model over a log: single events in it, such as an operation, do not count."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.model import Array, Model
from slider_drilling.gap.problem.noise import NoiseFloor
from slider_drilling.gap.problem.problem import Piece, Problem, build_problem

_BLOCK_S = 20.0
_KEPT = 0.8  # of the blocks, those with the smallest errors
_MIN_BLOCKS = 5  # below which all count


def problem_in_units(model: Model, noise: Mapping[str, NoiseFloor]) -> Problem:
    """The problem of a model whose channels count in these units, by channel."""
    return build_problem(model, [{each.name: noise[each.name].sigma for each in run.channels} for run in model.runs])


def usual_square(problem: Problem, piece: Piece, residual: Array) -> float:
    """Mean square of a channel's residual (N,) over blocks of 20 s, without the worst fifth of them."""
    counts = counts_of(problem, piece)
    own, time = residual[piece.rows][counts] ** 2, piece.channel.time[counts]
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
        size = int(np.sum(counts_of(problem, piece)))
        if size:
            squares.setdefault(piece.name, []).append((usual_square(problem, piece, residual), size))
    return {
        name: float(np.sqrt(np.average([own for own, _ in values], weights=[size for _, size in values])))
        for name, values in squares.items()
    }


def usual_gap(problem: Problem, residual: Array) -> float:
    """E of a residual (N,) over all channels that count, each sample alike."""
    counting = [piece for piece in problem.pieces if np.any(counts_of(problem, piece))]
    pieces = [piece for piece in counting if not piece.channel.accumulates] or counting
    sizes = [np.sum(counts_of(problem, piece)) for piece in pieces]
    return float(np.sqrt(np.average([usual_square(problem, piece, residual) for piece in pieces], weights=sizes)))


def counts_of(problem: Problem, piece: Piece) -> NDArray[np.bool_]:
    """(n,) whether each sample of a channel counts in the reported errors."""
    return np.asarray(piece.channel.time >= problem.model.runs[piece.run].counts_from)


def counted(problem: Problem) -> NDArray[np.bool_]:
    """(N,) whether each sample counts in E: a channel in which an error stays has few samples and large errors.

    It counts in the likelihood, by its missed steps. All samples count where there is no other channel.
    """
    counts, steady = np.zeros(problem.size, dtype=bool), np.zeros(problem.size, dtype=bool)
    for piece in problem.pieces:
        counts[piece.rows], steady[piece.rows] = counts_of(problem, piece), not piece.channel.accumulates
    return counts & steady if np.any(counts & steady) else counts
