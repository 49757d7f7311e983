"""Held-out scoring: blocked cross-validation with linearised refits, block bootstrap, and the null threshold.

A fold's refit is one Gauss-Newton step from the full fit with the fold's rows left out; its parameters are then
simulated for real, so only the refit is linearised, never the score.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.model import Array, Run
from slider_drilling.gap.noise import cycle_period
from slider_drilling.gap.residuals import Problem
from slider_drilling.gap.tune import Fit, prior_rows

Indices = NDArray[np.int_]
FOLDS = 6
BOOTSTRAPS = 2000
_BINS_PER_BLOCK = 8
_STEP_SHARES = (1.0, 0.5, 0.25)


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

    Steps are held inside the bounds.
    """
    weight = problem.reweighted(fit.residual)
    rows = weight[:, None] * fit.jacobian
    right = weight * fit.residual
    size = rows.shape[1]
    prior = prior_rows(fit.parameters) ** 2
    offset = np.array([(fit.values[p.name] - p.nominal) / p.scale for p in fit.parameters])
    lower = np.array([(p.lower - p.nominal) / p.scale for p in fit.parameters]) - offset
    upper = np.array([(p.upper - p.nominal) / p.scale for p in fit.parameters]) - offset
    steps = np.zeros((FOLDS, size))
    for fold in range(FOLDS):
        kept = folds.of != fold
        normal = rows[kept].T @ rows[kept] + np.diag(prior)
        gradient = rows[kept].T @ right[kept] + prior * offset
        ridge = 1e-9 * np.trace(normal) / max(size, 1)
        steps[fold] = np.clip(-np.linalg.solve(normal + ridge * np.eye(size), gradient), lower, upper)
    return steps


def held_out_residual(problem: Problem, fit: Fit, folds: Folds) -> Array:
    """(N,) residual of each sample under the parameters refitted without its fold, simulated for real.

    Where the model is strongly nonlinear the whole linearised step may overshoot: of the step and its half and
    quarter, the one that explains the *other* folds best is taken.
    """
    steps = fold_steps(problem, fit, folds)
    sets = []
    for share in _STEP_SHARES:
        for step in steps:
            moved = {
                p.name: fit.values[p.name] + share * p.scale * d for p, d in zip(fit.parameters, step, strict=True)
            }
            sets.append(fit.values | moved)
    residuals = problem.residuals(sets).reshape(len(_STEP_SHARES), FOLDS, -1)
    held = np.empty(problem.time.size)
    for fold in range(FOLDS):
        outside = folds.of == fold
        training = problem.weight * problem.robust(residuals[:, fold])[0] * ~outside
        best = int(np.argmin(np.sum(training**2, axis=1)))
        held[outside] = residuals[best, fold, outside]
    return held


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

    def gaps_squared(self, residual: Array) -> Array:
        """(BOOTSTRAPS,) resampled E^2 of a residual (N,)."""
        total, pieces = np.zeros(self.counts.shape[0]), np.zeros(self.counts.shape[0])
        size = self.folds.bin_run.size
        for rows in self.pieces:
            squares = np.bincount(self.folds.bins[rows], weights=residual[rows] ** 2, minlength=size)
            number = self.counts @ np.bincount(self.folds.bins[rows], minlength=size)
            held = number > 0
            total[held] += (self.counts @ squares)[held] / number[held]
            pieces += held
        return np.asarray(total / pieces)


def null_quantiles(
    problem: Problem, fit: Fit, folds: Folds, noise: Array, model_error: Array, *, draws: int = 200, seed: int = 0
) -> tuple[float, dict[str, float]]:
    """c0, and the same per channel: the 99 % quantile of held-out E^2 when the tuned model is the truth.

    Each draw is block-resampled noise (N,) plus the model's own discretisation error (N,), refitted per fold
    through the Jacobian of the fit (linearised: a full refit of every draw would cost more than the diagnosis).
    The per-channel quantile is at 1 - 0.01 / channels.
    """
    generator = np.random.default_rng(seed)
    rows = problem.weight[:, None] * fit.jacobian
    prior = np.diag(prior_rows(fit.parameters) ** 2)
    inverses = [np.linalg.pinv(rows[folds.of != fold].T @ rows[folds.of != fold] + prior) for fold in range(FOLDS)]
    totals, channels = [], {name: [] for name in problem.channel_names}  # type: ignore[var-annotated]
    for _ in range(draws):
        synthetic = _resample_noise(problem, folds, noise, generator) + model_error
        pulls = rows * (problem.weight * synthetic)[:, None]
        by_fold = np.stack([pulls[folds.of == fold].sum(axis=0) for fold in range(FOLDS)])
        whole = by_fold.sum(axis=0)
        steps = np.stack([-inverse @ (whole - own) for inverse, own in zip(inverses, by_fold, strict=True)])
        predicted = synthetic + np.einsum("np,np->n", fit.jacobian, steps[folds.of])
        predicted *= _floor_error(problem, generator)
        totals.append(problem.gap_squared(predicted))
        for name, gap in problem.channel_gaps(predicted).items():
            channels[name].append(gap)
    level = 1.0 - 0.01 / len(channels)
    return float(np.quantile(totals, 0.99)), {name: _upper(values, level) for name, values in channels.items()}


def _floor_error(problem: Problem, generator: np.random.Generator) -> Array:
    """(N,) by how much a residual would be off because its noise floor is an estimate too."""
    factor = np.ones(problem.time.size)
    for (run, name), part in problem.slices.items():
        off = problem.floors[run][name].uncertainty * generator.standard_normal()
        factor[part] = np.sqrt(max(1.0 + off, 0.0))
    return factor


def noise_sample(problem: Problem, residual: Array) -> Array:
    """(N,) the fast part of a residual, per channel scaled to one noise floor: what block resampling draws from.

    Slow structure is what an effect leaves and is taken out by second differences; where noise is coloured (its
    correlation is known from the cycles) the sample is an autoregression driven by that fast part.
    """
    noise = np.empty_like(residual)
    for (run, name), part in problem.slices.items():
        values = residual[part]
        if values.size < 100:
            noise[part] = np.random.default_rng(values.size).standard_normal(values.size)
            continue
        fast = np.convolve(values, [1.0, -2.0, 1.0], mode="same") / np.sqrt(6.0)
        spread = 1.4826 * float(np.median(np.abs(fast - np.median(fast))))
        fast = np.clip(fast / spread, -4.0, 4.0)
        # The second difference of white noise is itself coloured: shuffling restores white noise of that distribution.
        white = np.random.default_rng(values.size).permutation(fast)
        colour = problem.floors[run][name].lag_correlation
        noise[part] = _autoregression(white, colour)
        noise[part] /= np.sqrt(np.mean(noise[part] ** 2))
    return noise


def _autoregression(white: Array, colour: float) -> Array:
    if colour <= 0.0:
        return white
    coloured = np.empty_like(white)
    last = white[0]
    for index, value in enumerate(white):
        last = colour * last + np.sqrt(1.0 - colour**2) * value
        coloured[index] = last
    return coloured


def _upper(values: list[float], level: float) -> float:
    """A quantile further out than so few draws reach: Gaussian tail in the cube root (Wilson-Hilferty)."""
    from scipy.stats import norm

    root = np.cbrt(values)
    return float((root.mean() + norm.ppf(level) * root.std()) ** 3)


def _resample_noise(problem: Problem, folds: Folds, noise: Array, generator: np.random.Generator) -> Array:
    """Noise with its blocks in another order and sign, per channel and run."""
    drawn = np.empty_like(noise)
    for (run, _), part in problem.slices.items():
        values = noise[part]
        if values.size < 100:
            drawn[part] = generator.standard_normal(values.size)
            continue
        block = max(int(values.size * folds.per_block[run] / np.sum(folds.bin_run == run)), 1)
        starts = generator.integers(0, values.size, size=int(np.ceil(values.size / block)))
        signs = generator.choice([-1.0, 1.0], size=starts.size)
        pieces = (starts[:, None] + np.arange(block)) % values.size
        drawn[part] = (signs[:, None] * values[pieces]).reshape(-1)[: values.size]
    return drawn
