"""The budget for the model's own error: what no parameter and no effect of the catalogue can be blamed for.

No simulator is exact. Mesh, laws, sensors and drives of a real system differ from any model by some per cent
everywhere. `Channel.model_error` says by how much, as a share of what the channel moves. Kennedy and O'Hagan
(Journal of the Royal Statistical Society B 63, 2001) call it model inadequacy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from slider_drilling.gap.evidence.likelihood import Discrepancy, whiten
from slider_drilling.gap.model import Array
from slider_drilling.gap.problem.problem import Piece, Problem
from slider_drilling.gap.search.least_squares import Fit

# Independent numbers that the model's error has in one channel, however long the log: it repeats with the excitation.
INDEPENDENT_ERRORS = 10


def model_error_budget(problem: Problem, fitted: Fit) -> dict[str, float]:
    """By channel, E^2 that the model's own error may hold beside the noise.

    Args:
        problem: The problem.
        fitted: A fit, whose simulation shows how far every channel moves.

    Returns:
        ``(model_error * standard deviation of the channel / noise)^2``, averaged over the runs.
    """
    return _averaged_over_runs(problem, lambda piece: model_error_size(piece, fitted.simulated) ** 2)


def wander_budget(problem: Problem, fitted: Fit) -> dict[str, float]:
    """By channel, E^2 that the model's own error and slow changes of any system (`Channel.wander`) may hold.

    Args:
        problem: The problem.
        fitted: A fit, whose simulation shows how far every channel moves.
    """
    return _averaged_over_runs(
        problem,
        lambda piece: (
            model_error_size(piece, fitted.simulated) ** 2 + (piece.channel.wander / piece.noise) ** 2
        ),
    )


def _averaged_over_runs(problem: Problem, square: Callable[[Piece], float]) -> dict[str, float]:
    """By channel, the mean of a square over its runs."""
    squares: dict[str, list[float]] = {}
    for piece in problem.pieces:
        squares.setdefault(piece.name, []).append(square(piece))
    return {name: float(np.mean(values)) for name, values in squares.items()}


def model_error_covariance(problem: Problem, fitted: Fit, rows: Array, covariance: Array) -> Array:
    """Covariance of the parameters that the model's own error adds.

    An error of the model repeats with the excitation: it does not average out as noise does. In a channel of n samples
    it counts as `INDEPENDENT_ERRORS` numbers, each of which acts on its share of the samples together. It is as large
    as the budget says, or as what the fit leaves beyond the noise, if that is more. A time stamp may be wrong by up to
    half a sampling interval, for all samples of a channel alike: recorders stamp a sample when they read it, send it or
    store it.

    Args:
        problem: The problem.
        fitted: The fit.
        rows: (p, N) its Jacobian, whitened.
        covariance: (p, p) of the parameters by noise alone.

    Returns:
        (p, p), zero where no channel has a model error and the fit leaves noise alone.
    """
    information = np.zeros_like(covariance)
    for index, piece in enumerate(problem.pieces):
        weights = _weights_of_samples(piece, rows[:, piece.rows], fitted.discrepancy.get(index))
        repeated = max(piece.channel.time.size / INDEPENDENT_ERRORS, 1.0)
        error = max(model_error_size(piece, fitted.simulated) ** 2, _left_beyond_noise(piece, fitted))
        information += error * repeated * (weights @ weights.T)
        late = weights @ _half_a_sample_late(piece, fitted.simulated)
        information += np.outer(late, late)
    return np.asarray(covariance @ information @ covariance)


def _weights_of_samples(piece: Piece, rows: Array, discrepancy: Discrepancy | None) -> Array:
    """(p, n) by how much each sample of the residual moves the parameters, before the covariance.

    The fit whitens the Jacobian and the residual. What it does to the residual falls on the whitened Jacobian as the
    same filter that runs backwards in time. An error of a kind that the discrepancy holds moves the parameters less.

    Args:
        piece: One channel of one run.
        rows: (p, n) its part of the whitened Jacobian.
        discrepancy: Its discrepancy; None where the channel accumulates, which has none.
    """
    if discrepancy is None:
        return rows
    interval = np.concatenate([piece.interval[:1], piece.interval[:0:-1]])
    backwards, _ = whiten(rows[:, ::-1], interval, discrepancy)
    return backwards[:, ::-1]


def observed_model_error(problem: Problem, fitted: Fit) -> dict[str, float]:
    """By channel, the model's error as a share of what the channel moves: what a fit leaves, if more than the budget.

    Args:
        problem: The problem.
        fitted: The fit.
    """
    shares: dict[str, float] = {}
    for piece in problem.pieces:
        moved = float(np.std(fitted.simulated[piece.rows]))
        if piece.channel.accumulates or moved == 0.0:
            continue
        left = min(float(np.sqrt(_left_beyond_noise(piece, fitted))) / moved, 1.0)
        shares[piece.name] = max(shares.get(piece.name, piece.channel.model_error), left)
    return shares


def with_model_error(problem: Problem, shares: Mapping[str, float]) -> Problem:
    """The same problem with these shares, by channel, as the model's error."""
    pieces = tuple(
        replace(piece, channel=replace(piece.channel, model_error=shares.get(piece.name, piece.channel.model_error)))
        for piece in problem.pieces
    )
    return replace(problem, pieces=pieces)


def _half_a_sample_late(piece: Piece, simulated: Array) -> Array:
    """(n,) noise units: what stamps change that are wrong by one standard deviation of a uniform half sample."""
    time = piece.channel.time
    if piece.channel.model_error == 0.0 or time.size < 3:
        return np.zeros(time.size)
    deviation = float(np.median(np.diff(time))) / np.sqrt(12.0)
    return np.asarray(deviation * np.gradient(simulated[piece.rows], time))


def _left_beyond_noise(piece: Piece, fitted: Fit) -> float:
    """E^2 - 1 that the fit leaves in one channel of one run, 0 if it leaves no more than white noise would."""
    squares = fitted.residual[piece.rows] ** 2
    return max(float(np.mean(squares)) - 1.0 - 3.0 * float(np.sqrt(2.0 / squares.size)), 0.0)


def model_error_size(piece: Piece, simulated: Array) -> float:
    """Standard deviation, noise units, of the model's error in one channel of one run.

    What accumulates is counted in missed steps: how far it moves is no measure of that.
    """
    return 0.0 if piece.channel.accumulates else piece.channel.model_error * float(np.std(simulated[piece.rows]))
