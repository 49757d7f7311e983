"""Cross-validated score of a fit: the density that it predicts of held-out stretches, and the gap that it leaves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.model import Array, Parameter
from slider_drilling.gap.problem.cycles import block_length
from slider_drilling.gap.problem.problem import STEP_SIZE, Problem
from slider_drilling.gap.problem.step_loss import step_loss
from slider_drilling.gap.search.least_squares import Fit, KnownStart, fit
from slider_drilling.process.parallel_map import parallel_map

# Stretches of a run that are held out in turn.
FOLDS = 6


@dataclass(frozen=True)
class Folds:
    """How samples are held out and resampled.

    Attributes:
        fold: (N,) fold of each sample: contiguous stretches of time, the same for every channel.
        instant: (N,) time of each sample, counted in samples of its run's densest channel, one run after the other.
        instants: Per run, the number of instants.
        block: Per run, how many instants are resampled together.
    """

    fold: NDArray[np.int_] = field(repr=False)
    instant: NDArray[np.int_] = field(repr=False)
    instants: tuple[int, ...]
    block: tuple[int, ...]


@dataclass(frozen=True)
class HeldOutScore:
    """Cross-validated score of a fit.

    Attributes:
        density: (N,) held-out ``-2 log p`` of each sample.
        residual: (N,) held-out residual, noise units.
        squares: (N,) each sample's share of E^2 before averaging. A missed step of a channel that accumulates counts
            once.
        gap: E, over all samples, so that a dozen samples of one channel do not weigh as much as thousands of another.
        by_channel: E of each channel.
        unrefitted_folds: Folds whose refit failed, so that they are scored by the fit to the whole log.
    """

    density: Array = field(repr=False)
    residual: Array = field(repr=False)
    squares: Array = field(repr=False)
    gap: float
    by_channel: dict[str, float]
    unrefitted_folds: int

    @property
    def held_out_deviance(self) -> float:
        """``-2 log p`` of all held-out samples."""
        return float(np.sum(self.density))


def make_folds(problem: Problem) -> Folds:
    """Folds of equal length in every run, and blocks of a few cycles of the excitation."""
    fold_of, instant_of = np.zeros(problem.size, dtype=int), np.zeros(problem.size, dtype=int)
    instants: list[int] = []
    block = []
    for index, run in enumerate(problem.model.runs):
        own = [piece for piece in problem.pieces if piece.run == index]
        count = max([FOLDS, *(piece.channel.time.size for piece in own)])
        for piece in own:
            elapsed = (piece.channel.time - run.time[0]) / run.duration
            fold_of[piece.rows] = np.clip((elapsed * FOLDS).astype(int), 0, FOLDS - 1)
            instant_of[piece.rows] = sum(instants) + np.clip((elapsed * count).astype(int), 0, count - 1)
        instants.append(count)
        block.append(max(round(block_length(run) / run.duration * count), 1))
    return Folds(fold_of, instant_of, tuple(instants), tuple(block))


def score_held_out(problem: Problem, whole: Fit, folds: Folds) -> HeldOutScore:
    """Score each fold by a refit without it.

    Parameters that belong to a run keep the value of the whole log. A refit takes one iteration; where none of its
    trial steps lowers the cost although the linear prediction says so, the fold is counted as not refitted.

    Args:
        problem: The problem.
        whole: Fit to the whole log.
        folds: The folds.
    """
    freed, rows = _shared_parameters(whole), whole.jacobian_rows

    def refit_without(fold: int) -> Fit:
        weights = (folds.fold != fold).astype(float)
        known = KnownStart(whole.simulated, rows)
        return fit(problem, freed, whole.values, iterations=1, sample_weights=weights, known=known)

    residual = np.empty(problem.size)
    missing = 0
    for fold, refit in enumerate(parallel_map(refit_without, range(FOLDS))):
        inside = folds.fold == fold
        residual[inside] = refit.residual[inside]
        missing += not refit.converged and refit.values == whole.values
    return score_residual(problem, residual, whole, missing)


def score_left_out_runs(problem: Problem, whole: Fit) -> HeldOutScore:
    """Score each run by a refit to the other runs: another excitation tests a model harder than more of the same.

    Parameters that belong to a run keep their value.
    """
    freed, rows, runs = _shared_parameters(whole), whole.jacobian_rows, range(len(problem.model.runs))

    def residual_of(run: int) -> Array:
        others = problem.restricted_to([other for other in runs if other != run])
        refit = fit(others, freed, whole.values, known=KnownStart(whole.simulated, rows))
        return problem.restricted_to([run]).residuals([refit.values])[0]

    return score_residual(problem, np.sum(parallel_map(residual_of, runs), axis=0), whole)


def score_residual(problem: Problem, residual: Array, whole: Fit, unrefitted: int = 0) -> HeldOutScore:
    """Score of a residual (N,) under the discrepancies of a fit."""
    squares = squared_residuals(problem, residual)
    by_channel: dict[str, list[float]] = {}
    for piece in problem.pieces:
        by_channel.setdefault(piece.name, []).append(float(np.mean(squares[piece.rows])))
    channels = {name: float(np.sqrt(np.mean(values))) for name, values in by_channel.items()}
    gap = float(np.sqrt(np.mean(squares)))
    density = problem.log_density(residual, whole.discrepancy)
    return HeldOutScore(density, residual, squares, gap, channels, unrefitted)


def squared_residuals(problem: Problem, residual: Array) -> Array:
    """(N,) squares in noise units: of an observed channel as a free run's, of one that accumulates its step loss."""
    squares = np.empty(problem.size)
    for piece in problem.pieces:
        part = problem.observer_factor(piece) * residual[piece.rows]
        if piece.channel.accumulates:
            squares[piece.rows] = step_loss(problem.unwrapped(piece, part), STEP_SIZE)[0]
        else:
            squares[piece.rows] = part**2
    return squares


def _shared_parameters(whole: Fit) -> list[Parameter]:
    """What is refitted: parameters that do not belong to a run."""
    return [parameter for parameter in whole.parameters if not parameter.per_run]
