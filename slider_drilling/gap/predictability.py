"""What a simulation cannot foretell, because the smallest change of its parameters changes it beyond all measure.

A bit that breaks free and spins stops at an angle that hangs on everything before: no model, however right, tells it.
What follows is evidence for or against a model only as far as the model itself is sure of it. The measure is how far
the mean of two simulations, a little to either side in the parameters, lies from the one between them: nothing where
the model follows smoothly, as much as they scatter where it does not. In a channel that accumulates, what a finer
simulation would change is added.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from slider_drilling.gap.fit import Fit
from slider_drilling.gap.model import Anchored, Array
from slider_drilling.gap.residuals import Problem

# Pairs of neighbours; their largest distance in units of each parameter's scale, that of the fit's own derivatives.
_PAIRS = 8
_STEP = 0.2
# A neighbourhood in time, as a share of the run, over which the scatter of so few is averaged.
_WINDOW = 0.025


def foresee(problem: Problem, fit: Fit) -> Problem:
    """The problem with the floors of this fit, where the model is made exact."""
    problem.anchor(fit.values)
    return problem.foretold(unpredictable(problem, fit))


def glimpse(problem: Problem, fit: Fit) -> Problem:
    """As `foresee`, by the neighbours alone and with the model as it is anchored."""
    return problem.foretold(_bend(problem, fit))


def unpredictable(problem: Problem, fit: Fit) -> Array:
    """(N,) standard deviation, in each channel's unit, of what the model at a fit cannot foretell."""
    spread = _bend(problem, fit)
    finer = unsettled(problem, fit)
    for (run, name), part in problem.slices.items():
        # Elsewhere the mesh's error is the same for every model and tells none from another.
        if problem.channel_of(run, name).accumulates:
            spread[part] = np.hypot(spread[part], _averaged(finer[part]))
    return spread


def _bend(problem: Problem, fit: Fit) -> Array:
    """(N,) standard deviation of what neighbours in the parameters do otherwise."""
    generator = np.random.default_rng(0)
    parameters = fit.parameters
    here = np.array([fit.values[p.name] for p in parameters])
    step = _STEP * np.array([p.scale for p in parameters])
    low, high = np.array([p.lower for p in parameters]), np.array([p.upper for p in parameters])
    step = np.minimum(step, 0.5 * (high - low))
    # Both neighbours lie inside the bounds.
    middle = np.clip(here, low + step, high - step)
    moves = generator.choice([-1.0, 1.0], size=(_PAIRS, here.size)) * step
    moves *= generator.uniform(0.5, 1.0, size=moves.shape)
    sets = [fit.values | dict(zip((p.name for p in parameters), point, strict=True))
            for point in (middle, *(middle + moves), *(middle - moves))]  # fmt: skip
    simulated = problem.simulate(sets) * problem.floor
    apart = _within_half_a_turn(problem, simulated[1:] - simulated[0])
    bend = 0.5 * (apart[:_PAIRS] + apart[_PAIRS:])
    # Of three alike but independent simulations this has 1.5 times the variance of one.
    variance = np.mean(bend**2, axis=0) / 1.5
    spread = np.sqrt(variance)
    for part in problem.slices.values():
        spread[part] = _averaged(spread[part])
    return spread


def _averaged(spread: Array) -> Array:
    """Root of the running mean square of one channel's spread (n,)."""
    window = max(3, 2 * round(0.5 * _WINDOW * spread.size) + 1)
    # A running mean can end a rounding error below zero.
    return np.sqrt(np.maximum(uniform_filter1d(spread**2, window, mode="nearest"), 0.0))


def unsettled(problem: Problem, fit: Fit) -> Array:
    """(N,) by how much, in each channel's unit, a finer simulation differs."""
    difference = np.zeros_like(problem.floor)
    if isinstance(problem.model, Anchored):
        values = [problem.set_of(fit.values, run) for run in range(len(problem.model.runs))]
        finer = problem.model.discretisation(values)
        for (run, name), part in problem.slices.items():
            difference[part] = finer[run][name]
    return _within_half_a_turn(problem, difference)


def _within_half_a_turn(problem: Problem, difference: Array) -> Array:
    """Differences (..., N) of simulations without the whole turns of channels that wrap."""
    wrapped = difference.copy()
    for (run, name), part in problem.slices.items():
        period = problem.channel_of(run, name).period
        if period is not None:
            wrapped[..., part] -= period * np.round(wrapped[..., part] / period)
    return wrapped
