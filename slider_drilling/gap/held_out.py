"""Held-out scoring: blocked cross-validation with linearised refits, and the block bootstrap of the scores.

A fold's refit is one Gauss-Newton step from the full fit with the fold's rows left out; its parameters are then
simulated for real, so only the refit is linearised, never the score.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.fit import Fit, prior_rows
from slider_drilling.gap.model import Array, Run, Values
from slider_drilling.gap.noise import cycle_period
from slider_drilling.gap.residuals import Problem

Indices = NDArray[np.int_]
FOLDS = 6
BOOTSTRAPS = 2000
_BINS_PER_BLOCK = 8
_STEP_SHARES = (1.0, 0.5, 0.25, 0.1)
# A simulation follows the linear forecast where it departs by no more than this share of the fit's cost.
_LINEAR = 0.05


def block_length(run: Run) -> float:
    """Length s of the blocks that are held out and resampled: two cycles of the excitation, at most a sixth of the run.

    Without cycles a twentieth of the run, so that the bootstrap has twenty blocks.
    """
    period = cycle_period(run.time, run.excitation)
    wanted = run.duration / 20.0 if period is None else max(2.0 * period, run.duration / 20.0)
    return float(min(wanted, run.duration / FOLDS))


@dataclass(frozen=True)
class Folds:
    """of: (N,) the fold of each sample (contiguous stretches of time, the same for every channel);
    bins: (N,) index of the sample's bootstrap bin; bin_run: (B,) the run of each bin; per_block: bins a block holds,
    by run.
    """

    of: Indices
    bins: Indices
    bin_run: Indices
    per_block: tuple[int, ...]


def make_folds(problem: Problem) -> Folds:
    """Folds of at least a block's length and bins of an eighth of a block."""
    fold_of = np.zeros(problem.time.size, dtype=int)
    bin_of = np.zeros(problem.time.size, dtype=int)
    bin_run: list[int] = []
    per_block: list[int] = []
    for index, run in enumerate(problem.model.runs):
        here = problem.run == index
        elapsed = (problem.time[here] - run.time[0]) / run.duration
        fold_of[here] = np.clip((elapsed * FOLDS).astype(int), 0, FOLDS - 1)
        count = max(round(run.duration / block_length(run) * _BINS_PER_BLOCK), FOLDS)
        bin_of[here] = len(bin_run) + np.clip((elapsed * count).astype(int), 0, count - 1)
        bin_run += [index] * count
        per_block.append(max(int(np.ceil(block_length(run) / run.duration * count - 1e-9)), 1))
    return Folds(fold_of, bin_of, np.array(bin_run), tuple(per_block))


def fold_steps(problem: Problem, fit: Fit, folds: Folds) -> Array:
    """(FOLDS, p) scaled parameter steps that refit to everything outside each fold, linearised at the fit.

    Steps are held inside the bounds. What belongs to the run stays: how it began is told by its beginning alone, and a
    refit without that would only show that nothing else tells it.
    """
    refitted = fit.refitted
    own = list(compress(fit.parameters, refitted))
    weight = problem.reweighted(fit.residual)
    rows = weight[:, None] * fit.jacobian[:, refitted]
    right = weight * fit.residual
    prior = prior_rows(own) ** 2
    offset = np.array([(fit.values[p.name] - p.nominal) / p.scale for p in own])
    lower = np.array([(p.lower - p.nominal) / p.scale for p in own]) - offset
    upper = np.array([(p.upper - p.nominal) / p.scale for p in own]) - offset
    steps = np.zeros((FOLDS, len(fit.parameters)))
    for fold in range(FOLDS):
        kept = folds.of != fold
        normal = rows[kept].T @ rows[kept] + np.diag(prior)
        gradient = rows[kept].T @ right[kept] + prior * offset
        ridge = 1e-9 * np.trace(normal) / max(len(own), 1)
        steps[fold, refitted] = np.clip(-np.linalg.solve(normal + ridge * np.eye(len(own)), gradient), lower, upper)
    return steps


def held_out(problem: Problem, fit: Fit, folds: Folds) -> tuple[Array, Array]:
    """(N,) residual of each sample, and its loss, under the parameters refitted without its fold, simulated for real.

    A fold's refit is as much of its linearised step as the model still follows linearly: the step, its half, quarter,
    tenth or none of it. Beyond, a string that sticks and slips breaks free at other times than in the fit; that says
    how far ahead it can be foretold, nothing of how well the parameters are known.
    """
    steps = fold_steps(problem, fit, folds)
    scale = np.array([p.scale for p in fit.parameters])
    sets: list[Values] = [fit.values]
    for share in _STEP_SHARES:
        for step in steps:
            moved = zip(fit.parameters, share * scale * step, strict=True)
            sets.append(fit.values | {p.name: fit.values[p.name] + change for p, change in moved})
    simulated = problem.simulate(sets)
    chosen = np.zeros(FOLDS, dtype=int)
    for fold, step in enumerate(steps):
        for part, share in enumerate(_STEP_SHARES):
            index = 1 + part * FOLDS + fold
            apart = problem.weight * (simulated[index] - simulated[0] + share * fit.jacobian @ step)
            if apart @ apart <= _LINEAR * fit.cost:
                chosen[fold] = index
                break
    residuals = problem.against_log(simulated[chosen])
    losses = problem.robust(residuals)[0] ** 2
    rows = np.arange(problem.time.size)
    return residuals[folds.of, rows], losses[folds.of, rows]


@dataclass(frozen=True)
class HeldOut:
    """A fit's score on held-out stretches.

    residual (N,); gap_squared: its E^2; resampled: (BOOTSTRAPS,) of that; robust: the same under the fit's own loss and
    weights; surprise, surprise_resampled: robust and the price of the floors, which is what models are compared by.
    by_channel: mean loss of each channel.
    """

    residual: Array
    gap_squared: float
    resampled: Array
    robust: float
    surprise: float
    surprise_resampled: Array
    by_channel: dict[str, float]


def score_held_out(problem: Problem, fit: Fit, bootstrap: Bootstrap) -> HeldOut:
    """Refit without each of the bootstrap's folds and score on it."""
    residual, loss = held_out(problem, fit, bootstrap.folds)
    weight, priced = problem.weight**2, loss + problem.price
    return HeldOut(
        residual, problem.gap_squared(residual), bootstrap.means(residual**2, problem.score),
        float(weight @ loss), float(weight @ priced), bootstrap.means(priced, weight), problem.by_channel(loss),
    )  # fmt: skip


class Bootstrap:
    """Circular block bootstrap of E^2 over time; the same resamples for every residual, so that they pair.

    Blocks start at any bin, so their number is that of the bins (eight per block length), not of disjoint blocks.
    """

    def __init__(self, problem: Problem, folds: Folds, seed: int) -> None:
        generator = np.random.default_rng(seed)
        self.problem, self.folds = problem, folds
        self.counts = np.zeros((BOOTSTRAPS, folds.bin_run.size))
        for run, block in enumerate(folds.per_block):
            here = np.flatnonzero(folds.bin_run == run)
            blocks = int(np.ceil(here.size / block))
            starts = generator.integers(0, here.size, size=(BOOTSTRAPS, blocks))
            drawn = (starts[:, :, None] + np.arange(block)) % here.size
            for draw in range(BOOTSTRAPS):
                picked = drawn[draw].reshape(-1)[: here.size]
                self.counts[draw, here] += np.bincount(picked, minlength=here.size)
        piece = problem.run * len(problem.channel_names) + problem.channel
        self.pieces = [np.flatnonzero(piece == value) for value in np.unique(piece)]

    def means(self, squares: Array, weight: Array) -> Array:
        """(BOOTSTRAPS,) resampled weighted sum of squares (N,); weight (N,) is the same throughout a run's channel."""
        total, weights = np.zeros(self.counts.shape[0]), np.zeros(self.counts.shape[0])
        size = self.folds.bin_run.size
        for rows in self.pieces:
            share = float(weight[rows].sum())
            sums = self.counts @ np.bincount(self.folds.bins[rows], weights=squares[rows], minlength=size)
            number = self.counts @ np.bincount(self.folds.bins[rows], minlength=size)
            held = number > 0
            total[held] += share * sums[held] / number[held]
            weights += share * held
        return np.asarray(total / weights)
