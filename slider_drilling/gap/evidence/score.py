"""What a fit foretells of stretches that it has not seen: its log predictive density there, and the gap it leaves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.model import Array, Parameter
from slider_drilling.gap.problem.cycles import block_length
from slider_drilling.gap.problem.problem import STEP_SIZE, Problem
from slider_drilling.gap.problem.step_loss import step_loss
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.process.parallel_map import parallel_map

FOLDS = 6


@dataclass(frozen=True)
class Folds:
    """of: (N,) the fold of each sample, contiguous stretches of time, the same for every channel; instant: (N,) when it
    was taken, counted in samples of its run's densest channel, one run after the other; instants: per run, how many;
    block: per run, how many are resampled together.
    """

    fold: NDArray[np.int_] = field(repr=False)
    instant: NDArray[np.int_] = field(repr=False)
    instants: tuple[int, ...]
    block: tuple[int, ...]


@dataclass(frozen=True)
class HeldOutScore:
    """density: (N,) held-out ``-2 log p`` of each sample; residual: (N,) held out, noise units; squares: (N,) each
    sample's share of E^2 before averaging, a missed step of what accumulates counted once; gap: E, over all samples (a
    dozen of one channel are no equal to thousands of another); by_channel: E of each; not_refitted: folds whose refit
    did not arrive, so that they are in-sample.
    """

    density: Array = field(repr=False)
    residual: Array = field(repr=False)
    squares: Array = field(repr=False)
    gap: float
    by_channel: dict[str, float]
    unrefitted_folds: int

    @property
    def held_out_deviance(self) -> float:
        """``-2 log p`` of all that was held out."""
        return float(np.sum(self.density))


def make_folds(problem: Problem) -> Folds:
    """Folds of equal length a run, and blocks of a few cycles."""
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


def score_held_out(problem: Problem, found: Fit, folds: Folds) -> HeldOutScore:
    """Refit without each fold and look at it. What belongs to the run (how it began) keeps the whole run's value.

    A refit goes down the likelihood of the rest; where none of its trial steps gets lower although the linear forecast
    says it should, the fold is in-sample and counted as such.
    """
    own, known = _of_the_rig(found), found.jacobian_rows

    def without(fold: int) -> Fit:
        kept = (folds.fold != fold).astype(float)
        return fit(
            problem,
            own,
            found.values,
            iterations=1,
            sample_weights=kept,
            simulated=found.simulated,
            jacobian_rows=known,
        )

    residual = np.empty(problem.size)
    missing = 0
    for fold, refit in enumerate(parallel_map(without, range(FOLDS))):
        inside = folds.fold == fold
        residual[inside] = refit.residual[inside]
        missing += not refit.converged and refit.values == found.values
    return score_residual(problem, residual, found, missing)


def score_left_out_runs(problem: Problem, found: Fit) -> HeldOutScore:
    """Refit to the other runs, for each run in turn, and look at it: what another excitation asks of a model, more of
    the same does not. What belongs to the run (how it began) keeps its value.
    """
    own, known, runs = _of_the_rig(found), found.jacobian_rows, range(len(problem.model.runs))

    def left_of(run: int) -> Array:
        rest = problem.restricted_to([other for other in runs if other != run])
        refit = fit(rest, own, found.values, simulated=found.simulated, jacobian_rows=known)
        return problem.restricted_to([run]).residuals([refit.values])[0]

    return score_residual(problem, np.sum(parallel_map(left_of, runs), axis=0), found)


def _of_the_rig(found: Fit) -> list[Parameter]:
    """What is refitted: not what belongs to the run."""
    return [parameter for parameter in found.parameters if not parameter.per_run]


def score_residual(problem: Problem, residual: Array, found: Fit, missing: int = 0) -> HeldOutScore:
    """The score of a residual (N,) under a fit's discrepancies."""
    squares = squared_residuals(problem, residual)
    by_channel: dict[str, list[float]] = {}
    for piece in problem.pieces:
        by_channel.setdefault(piece.name, []).append(float(np.mean(squares[piece.rows])))
    channels = {name: float(np.sqrt(np.mean(values))) for name, values in by_channel.items()}
    gap = float(np.sqrt(np.mean(squares)))
    return HeldOutScore(problem.log_density(residual, found.discrepancy), residual, squares, gap, channels, missing)


def squared_residuals(problem: Problem, residual: Array) -> Array:
    """(N,) squared residual in noise units; of a pulled channel as a free run's, of one that accumulates its loss."""
    squares = np.empty(problem.size)
    for piece in problem.pieces:
        part = problem.observer_factor(piece) * residual[piece.rows]
        if piece.channel.accumulates:
            squares[piece.rows] = step_loss(problem.unwrapped(piece, part), STEP_SIZE)[0]
        else:
            squares[piece.rows] = part**2
    return squares
