"""Re-tuning: what any rig is tuned in is fitted from several places, and a tuned model shows what is noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import qmc

from slider_drilling.gap.evidence.replicates import replicate_noise_factors
from slider_drilling.gap.model import Parameter, Values
from slider_drilling.gap.problem.noise import NoiseFloor, lower_floor, raise_floor
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.search.screen import STARTS
from slider_drilling.process.parallel_map import parallel_map

_SCATTERED = 32  # points
# Standard deviations of what rigs are off by: none is looked for farther out, and a re-tuned parameter that goes there
# may stand for something else.
NUISANCE_LIMIT = 2.5


def fit_from_starts(problem: Problem, starts: Sequence[Values], freed: Sequence[Parameter] | None = None) -> Fit:
    """The best re-tuned fit of those that begin at the starts; freed: the model's nuisance by default."""
    parameters = parameters_of(problem, ()) if freed is None else freed
    found = parallel_map(lambda start: fit(problem, parameters, start), starts)
    return min(found, key=lambda one: one.cost)


def scattered_starts(problem: Problem, tuned: Fit, freed: Sequence[Parameter] | None = None) -> list[dict[str, float]]:
    """Where else tuning may begin: the cheapest of points spread over where a rig may lie, in what is freed, by default
    all that the fit has freed.
    """
    parameters = list(tuned.parameters if freed is None else freed)
    if not parameters:
        return [tuned.values]
    low, high = zip(*(plausible_range(parameter) for parameter in parameters), strict=True)
    unit = qmc.Sobol(len(parameters), seed=0).random(_SCATTERED)
    points = [
        tuned.values | {p.name: float(v) for p, v in zip(parameters, row, strict=True)}
        for row in np.array(low) + (np.array(high) - np.array(low)) * unit
    ]
    costs = [problem.cost(residual)[0] for residual in problem.residuals(points)]
    return [points[index] for index in np.argsort(costs)[:STARTS]]


def plausible_range(parameter: Parameter) -> tuple[float, float]:
    """Where a parameter may lie: within `FAR_OFF` spreads of nominal, inside its bounds."""
    spread = parameter.spread if np.isfinite(parameter.spread) else parameter.upper - parameter.lower
    low = max(parameter.lower, parameter.nominal - NUISANCE_LIMIT * spread)
    return low, min(parameter.upper, parameter.nominal + NUISANCE_LIMIT * spread)


def lower_floors(
    problem: Problem, tuned: Fit, floors: Sequence[dict[str, NoiseFloor]]
) -> tuple[dict[str, NoiseFloor], ...]:
    """Floors by what a fit leaves: without the signal's own kinks."""
    found = [dict(own) for own in floors]
    for piece in problem.pieces:
        left = tuned.residual[piece.rows] * piece.noise
        found[piece.run][piece.name] = lower_floor(found[piece.run][piece.name], left)
    return tuple(found)


def raise_floors(
    problem: Problem, tuned: Fit, floors: Sequence[dict[str, NoiseFloor]], seed: int
) -> tuple[dict[str, NoiseFloor], ...]:
    """Floors by what a fit foretells of replicates of itself."""
    found = [dict(own) for own in floors]
    for index, factor in replicate_noise_factors(problem, tuned, seed).items():
        piece = problem.pieces[index]
        found[piece.run][piece.name] = raise_floor(found[piece.run][piece.name], factor)
    return tuple(found)
