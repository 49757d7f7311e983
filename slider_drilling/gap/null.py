"""The null threshold: what a held-out gap would be if the tuned model were the truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.fit import Fit, prior_rows
from slider_drilling.gap.held_out import FOLDS, Folds, HeldOut
from slider_drilling.gap.model import Array
from slider_drilling.gap.residuals import Problem


@dataclass(frozen=True)
class Threshold:
    """99 % quantiles under the null: gap_squared of held-out E^2, robust of its score under the fit's loss, by_channel
    of each channel's mean loss (at 1 - 0.01 / channels)."""

    gap_squared: float
    robust: float
    by_channel: dict[str, float]

    def holds(self, score: HeldOut) -> bool:
        """Whether a score is what noise alone would leave, as a whole and in every channel."""
        return score.robust <= self.robust and not self.above(score.by_channel)

    def above(self, by_channel: dict[str, float]) -> list[str]:
        """The channels that are not within their own threshold."""
        return [name for name, loss in by_channel.items() if loss > self.by_channel[name]]


def null_threshold(
    problem: Problem, fit: Fit, folds: Folds, noise: Array, model_error: Array, *, draws: int = 200, seed: int = 0
) -> Threshold:
    """The quantiles of spec gap.md's c0 when the tuned model is the truth.

    Each draw is block-resampled noise (N,) plus the model's own discretisation error (N,), refitted per fold
    through the Jacobian of the fit (linearised: a full refit of every draw would cost more than the diagnosis).
    """
    generator = np.random.default_rng(seed)
    # A step that the mesh misses must not bend the refits: it does not bend the fits either.
    weight = problem.reweighted(model_error)
    jacobian = fit.jacobian[:, fit.refitted]
    rows = weight[:, None] * jacobian
    prior = np.diag(prior_rows(fit.parameters)[fit.refitted] ** 2)
    inverses = [np.linalg.pinv(rows[folds.of != fold].T @ rows[folds.of != fold] + prior) for fold in range(FOLDS)]
    squared, robust = np.empty(draws), np.empty(draws)
    channels = {name: np.empty(draws) for name in problem.channel_names}
    for draw in range(draws):
        synthetic = _resample_noise(problem, folds, noise, generator) + model_error
        pulls = rows * (weight * synthetic)[:, None]
        by_fold = np.stack([pulls[folds.of == fold].sum(axis=0) for fold in range(FOLDS)])
        whole = by_fold.sum(axis=0)
        steps = np.stack([-inverse @ (whole - own) for inverse, own in zip(inverses, by_fold, strict=True)])
        predicted = synthetic + np.einsum("np,np->n", jacobian, steps[folds.of])
        predicted *= _floor_error(problem, generator)
        loss = problem.robust(predicted)[0] ** 2
        squared[draw], robust[draw] = problem.gap_squared(predicted), float(problem.weight**2 @ loss)
        for name, mean in problem.by_channel(loss).items():
            channels[name][draw] = mean
    level = 1.0 - 0.01 / len(channels)
    return Threshold(
        float(np.quantile(squared, 0.99)), float(np.quantile(robust, 0.99)),
        {name: _upper(values, level) for name, values in channels.items()},
    )  # fmt: skip


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


def _upper(values: Array, level: float) -> float:
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
