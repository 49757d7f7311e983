"""Logs as a fitted model would have given them if it were the truth, and what the fit leaves of them.

Replicates are made with the model itself: parameters as well as noise would tell them, its finest simulation, and the
channels' noise.
"""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np
from scipy.optimize import brentq

from slider_drilling.gap.evidence.compare import chi2_critical
from slider_drilling.gap.evidence.score import squared_residuals
from slider_drilling.gap.model import Array, HasFidelities, HasObserver, Model, SimulationOptions
from slider_drilling.gap.problem.noise import DIFFERENCE_SPREAD
from slider_drilling.gap.problem.problem import STEP_SIZE, Problem
from slider_drilling.gap.problem.step_loss import step_loss
from slider_drilling.gap.search.least_squares import Fit
from slider_drilling.process.parallel_map import parallel_map

_NUMBER = 8
_WIDEST = 1e3


def replicate_noise_factors(problem: Problem, found: Fit, seed: int) -> dict[int, float]:
    """By piece that accumulates, the factor (1 or more) on its noise under which replicates of a fit leave just that.

    What such a channel has missed once it keeps: where parameters hardly told from each other lead it elsewhere, its
    sensor's noise is no measure of what the truth would leave of it.
    """
    draws = replicate_residuals(problem, found, np.random.default_rng([seed, 11]))
    return {
        index: _factor([problem.unwrapped(piece, residual[piece.rows]) for residual in draws])
        for index, piece in enumerate(problem.pieces)
        if piece.channel.accumulates
    }


def _factor(parts: list[Array]) -> float:
    def left(logarithm: float) -> float:
        losses = [step_loss(part / np.exp(logarithm), STEP_SIZE)[0] for part in parts]
        return float(np.mean(losses)) - 1.0

    return float(np.exp(brentq(left, 0.0, np.log(_WIDEST), xtol=1e-2))) if left(0.0) > 0.0 else 1.0


def replicate_residuals(problem: Problem, found: Fit, generator: np.random.Generator) -> list[Array]:
    """Residuals (N,) that the problem leaves of replicates of its own fit; pulled, what is measured leads the way."""
    finest = problem.model.max_fidelity if isinstance(problem.model, HasFidelities) else 0
    sets = _nearby(problem, found, generator)
    truths = problem.simulate(sets, SimulationOptions(finest, 0.0))
    samples = [truth + _noise(problem, generator) for truth in truths]
    if problem.options.observer_gain == 0.0 or not isinstance(problem.model, HasObserver):
        fits = problem.simulate(sets)
        return [_tuned_to(problem, found, sample, np.delete(fits, i, axis=0)) for i, sample in enumerate(samples)]
    model, how = problem.model, replace(problem.options, fidelity=finest)

    def left(sample: Array) -> Array:
        fed: HasObserver = model
        for piece in problem.pieces:
            if piece.name == fed.observed_channel:
                fed = fed.with_measured(piece.run, sample[piece.rows] * piece.noise)
        own = replace(problem, model=cast(Model, fed), correction=np.zeros(problem.size))
        return problem.wrapped(sample - own.simulate([found.values], how)[0])

    return parallel_map(left, samples)


def _tuned_to(problem: Problem, found: Fit, sample: Array, others: Array) -> Array:
    """What a fit leaves of a replicate (N,), or the best of others (M, N), simulations of as likely parameters, where
    that leaves less by more than tuning gains on noise: tuned to the replicate, the model would find which way it went
    where next to nothing decides, as between sticking and not.
    """
    residuals = [problem.wrapped(sample - one) for one in (found.simulated, *others)]
    sizes = [float(np.sum(squared_residuals(problem, residual))) for residual in residuals]
    best = int(np.argmin(sizes))
    return residuals[best if sizes[0] - sizes[best] > chi2_critical(len(found.parameters)) else 0]


def _nearby(problem: Problem, found: Fit, generator: np.random.Generator) -> list[dict[str, float]]:
    """Parameter sets as likely as the fit's were it the truth, by its curvature: of the discrepancy that it leaves now
    no more would be there than as much as the noise, whose colour that may be.
    """
    if not found.parameters:
        return [found.values] * _NUMBER
    colour = {index: replace(one, size=min(one.size, 1.0)) for index, one in found.discrepancy.items()}
    _, rows = problem.whitened(found.residual, found.jacobian, colour)
    normal = rows @ rows.T
    normal[np.diag_indices_from(normal)] += 1.0
    factor = np.linalg.cholesky(normal)
    sets = []
    for _ in range(_NUMBER):
        step = np.linalg.solve(factor.T, generator.normal(size=len(found.parameters)))
        moved = {
            p.name: float(np.clip(found.values[p.name] + p.scale * change, p.lower, p.upper))
            for p, change in zip(found.parameters, step, strict=True)
        }
        sets.append(found.values | moved)
    return sets


def _noise(problem: Problem, generator: np.random.Generator) -> Array:
    noise = np.empty(problem.size)
    for piece in problem.pieces:
        count = piece.channel.time.size
        off = 1.0 + generator.normal() * DIFFERENCE_SPREAD / np.sqrt(count)
        noise[piece.rows] = off * generator.normal(size=count)
    return noise
