"""A search around a fit where least squares gets stuck: what sticks and slips leaves many local minima close together.

Derivatives say nothing of a string that breaks free an instant earlier or later; a population that is spread as wide as
the data would allow finds the parameters with which it does so when the log says.
"""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.fit import Fit, prior_rows
from slider_drilling.gap.model import Anchored, Array
from slider_drilling.gap.residuals import Problem

# The first population costs this share more than the fit, if the problem were smooth.
_SPREAD = 0.05
# Where the model is rough the spread is at least this, in units of the parameters' scales: over less than that its cost
# is the luck of when the string breaks free, beyond it follows the parameters.
_LEAST, _FAR, _MANY = 0.3, 24, 40
# No direction is searched further out than this, however little the fit says of it.
_MOST = 5.0


def roam(problem: Problem, fit: Fit, *, seed: int = 0) -> dict[str, float]:
    """As `shake`, further and on the cheap model: what an exact run adds at one place says nothing of another here."""
    if isinstance(problem.model, Anchored):
        problem.model.anchor([])
    return shake(problem, fit, generations=_FAR, population=_MANY, least=_LEAST, seed=seed)


def shake(
    problem: Problem, fit: Fit, *, generations: int = 8, population: int = 20, least: float = 0.0, seed: int = 0
) -> dict[str, float]:
    """The best parameter values that CMA-ES finds near a fit, the fit's own if none is better.

    Coordinates are those in which the fit's linearised cost is round. least: spread to begin with in every direction,
    units of the parameters' scales. The model stays anchored as it was.
    """
    from cma import CMAEvolutionStrategy

    parameters = fit.parameters
    back = _round_coordinates(problem, fit, least)
    scale, lower, upper, nominal = (
        np.array([getattr(p, field) for p in parameters]) for field in ("scale", "lower", "upper", "nominal")
    )
    prior = prior_rows(parameters)
    start = np.array([fit.values[p.name] for p in parameters])

    def values(trial: Array) -> dict[str, float]:
        return fit.values | {p.name: float(v) for p, v in zip(parameters, trial, strict=True)}

    def costs(trials: Array) -> Array:
        residuals = problem.residuals([values(trial) for trial in trials])
        away = np.sum((prior * (trials - nominal) / scale) ** 2, axis=1)
        return away + np.array([problem.robust_gap(residual) for residual in residuals])

    best, lowest = start, float(costs(start[None])[0])
    options = {"popsize": population, "seed": seed + 1, "verbose": -9, "maxiter": generations}
    search = CMAEvolutionStrategy(np.zeros(start.size), 1.0, options)
    while not search.stop():
        points = search.ask()
        trials = np.clip(start + scale * (np.asarray(points) @ back.T), lower, upper)
        found = costs(trials)
        search.tell(points, list(found))
        if np.min(found) < lowest:
            lowest, best = float(np.min(found)), trials[int(np.argmin(found))]
    return values(best)


def _round_coordinates(problem: Problem, fit: Fit, least: float) -> Array:
    """(p, p) matrix from coordinates in which the search begins round and of size one to the scaled parameters."""
    _, slope = problem.robust(fit.residual)
    rows = (problem.weight * slope)[:, None] * fit.jacobian
    hessian = rows.T @ rows + np.diag(prior_rows(fit.parameters) ** 2)
    hessian += 1e-4 * np.trace(hessian) / len(hessian) * np.eye(len(hessian))
    curvature, directions = np.linalg.eigh(hessian)
    spread = np.sqrt(_SPREAD * fit.cost / len(hessian) / curvature)
    return np.asarray(directions * np.clip(spread, least, _MOST))
