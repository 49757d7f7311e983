"""Fits from several starts, and where a parameter may plausibly lie."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import qmc

from slider_drilling.gap.model import Parameter, Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.search.screen import STARTS
from slider_drilling.process.parallel_map import parallel_map

# Points of the Sobol sequence among which other starts are chosen.
_SCATTERED = 32
# Standard deviations of a nuisance parameter's prior. No start lies farther out, and a fit that goes beyond may hide
# an effect.
NUISANCE_LIMIT = 2.5


def fit_from_starts(problem: Problem, starts: Sequence[Values], freed: Sequence[Parameter] | None = None) -> Fit:
    """The best fit of those from several starts.

    Args:
        problem: What to fit.
        starts: Parameter values to start from.
        freed: Free parameters; the model's nuisance by default.
    """
    parameters = parameters_of(problem, ()) if freed is None else freed
    fits = parallel_map(lambda start: fit(problem, parameters, start), starts)
    return min(fits, key=lambda found: found.cost)


def scattered_starts(
    problem: Problem, start: Fit, freed: Sequence[Parameter] | None = None
) -> list[dict[str, float]]:
    """Other parameter values to start from: the cheapest of points scattered over the plausible range.

    Args:
        problem: What to fit.
        start: Fit whose other values are kept.
        freed: Parameters that are scattered; by default all that the fit has freed.
    """
    parameters = list(start.parameters if freed is None else freed)
    if not parameters:
        return [start.values]
    low, high = zip(*(plausible_range(parameter) for parameter in parameters), strict=True)
    unit = qmc.Sobol(len(parameters), seed=0).random(_SCATTERED)
    points = [
        start.values | {p.name: float(v) for p, v in zip(parameters, row, strict=True)}
        for row in np.array(low) + (np.array(high) - np.array(low)) * unit
    ]
    costs = [problem.cost(residual)[0] for residual in problem.residuals(points)]
    return [points[index] for index in np.argsort(costs)[:STARTS]]


def plausible_range(parameter: Parameter) -> tuple[float, float]:
    """Lower and upper end of what is plausible: nominal plus or minus `NUISANCE_LIMIT` spreads, within bounds."""
    spread = parameter.spread if np.isfinite(parameter.spread) else parameter.upper - parameter.lower
    low = max(parameter.lower, parameter.nominal - NUISANCE_LIMIT * spread)
    return low, min(parameter.upper, parameter.nominal + NUISANCE_LIMIT * spread)
