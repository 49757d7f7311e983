"""Replicates of a fit: logs as the fitted model would have given them if it were the truth, and what the fit leaves.

A replicate is simulated with the finest simulation and parameters as likely as the fitted ones, and gets the channels'
noise.
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

# Replicates of each fit.
_NUMBER = 8
# Largest factor on a noise floor.
_MAX_FACTOR = 1e3


def replicate_noise_factors(problem: Problem, found: Fit, seed: int) -> dict[int, float]:
    """By piece that accumulates, the factor (1 or more) on its noise floor with which replicates leave E = 1.

    Such a channel keeps every missed step. Where parameters that the log hardly distinguishes lead it elsewhere, its
    sensor's noise does not measure what even the truth would leave.
    """
    residuals = replicate_residuals(problem, found, np.random.default_rng([seed, 11]))
    return {
        index: _noise_factor([problem.unwrapped(piece, residual[piece.rows]) for residual in residuals])
        for index, piece in enumerate(problem.pieces)
        if piece.channel.accumulates
    }


def _noise_factor(residuals: list[Array]) -> float:
    def excess(log_factor: float) -> float:
        losses = [step_loss(residual / np.exp(log_factor), STEP_SIZE)[0] for residual in residuals]
        return float(np.mean(losses)) - 1.0

    return float(np.exp(brentq(excess, 0.0, np.log(_MAX_FACTOR), xtol=1e-2))) if excess(0.0) > 0.0 else 1.0


def replicate_residuals(problem: Problem, found: Fit, generator: np.random.Generator) -> list[Array]:
    """Residuals (N,) that a fit leaves of its own replicates.

    In a run with an observer, each replicate's measurement is fed back in the place of the log's.
    """
    finest = problem.model.max_fidelity if isinstance(problem.model, HasFidelities) else 0
    sets = _likely_sets(problem, found, generator)
    truths = problem.simulate(sets, SimulationOptions(finest, 0.0))
    samples = [truth + _noise(problem, generator) for truth in truths]
    if problem.options.observer_gain == 0.0 or not isinstance(problem.model, HasObserver):
        fits = problem.simulate(sets)
        return [_calibrated_to(problem, found, sample, np.delete(fits, i, axis=0)) for i, sample in enumerate(samples)]
    model, options = problem.model, replace(problem.options, fidelity=finest)

    def residual_of(sample: Array) -> Array:
        observed: HasObserver = model
        for piece in problem.pieces:
            if piece.name == observed.observed_channel:
                observed = observed.with_measured(piece.run, sample[piece.rows] * piece.noise)
        own = replace(problem, model=cast(Model, observed), correction=np.zeros(problem.size))
        return problem.wrapped(sample - own.simulate([found.values], options)[0])

    return parallel_map(residual_of, samples)


def _calibrated_to(problem: Problem, found: Fit, sample: Array, others: Array) -> Array:
    """Residual (N,) of a replicate, by the fit or by the best of other simulations with likely parameters.

    Where next to nothing decides, as between sticking and slipping, calibration to the replicate would find which way
    it went. Another simulation counts only if it gains more than calibration gains on noise.

    Args:
        problem: The problem.
        found: The fit.
        sample: (N,) the replicate.
        others: (M, N) simulations with other parameters.
    """
    residuals = [problem.wrapped(sample - simulated) for simulated in (found.simulated, *others)]
    sizes = [float(np.sum(squared_residuals(problem, residual))) for residual in residuals]
    best = int(np.argmin(sizes))
    return residuals[best if sizes[0] - sizes[best] > chi2_critical(len(found.parameters)) else 0]


def _likely_sets(problem: Problem, found: Fit, generator: np.random.Generator) -> list[dict[str, float]]:
    """Parameter sets as likely as the fit's if that were the truth, drawn by its curvature.

    The discrepancy is limited to the size of the noise: if the model were the truth, it could only be coloured noise.
    """
    if not found.parameters:
        return [found.values] * _NUMBER
    limited = {index: replace(each, size=min(each.size, 1.0)) for index, each in found.discrepancy.items()}
    _, rows = problem.whitened(found.residual, found.jacobian, limited)
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
    """(N,) white noise; its size scatters as the estimate of the floor does."""
    noise = np.empty(problem.size)
    for piece in problem.pieces:
        count = piece.channel.time.size
        size = 1.0 + generator.normal() * DIFFERENCE_SPREAD / np.sqrt(count)
        noise[piece.rows] = size * generator.normal(size=count)
    return noise
