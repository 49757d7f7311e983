"""Confidence intervals of fitted parameters, from the curvature of the likelihood and the model's own error."""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.model import Array, HasConditionalNuisance, HasUserParameters, Parameter
from slider_drilling.gap.problem.model_error import model_error_covariance
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, KnownStart, fit, prior_weights

TWO_SIDED_95, ONE_SIDED_95 = 1.96, 1.645
"""Standard deviations to either end of an interval that holds 95 %, or that leaves out 5 % at one end."""
SPREAD_OF_ANSWERS = 2.0
"""How much farther from the truth answers lie than a fit's own interval says: a search ends in a flat valley, and a
real system differs from any model in ways that no fit shows. Measured, see docs/design/engine_constants.md."""
# Finite-difference step of the conversion to user parameters, in a parameter's scale.
_STEP = 1e-3


def parameter_intervals(
    problem: Problem, found: Fit, deviations: float = TWO_SIDED_95
) -> dict[str, tuple[float, float]]:
    """Interval of each freed parameter, by the names that a user knows, cut at its bounds.

    Args:
        problem: The problem of the fit.
        found: The fit.
        deviations: Standard deviations to either end; those of a 95 % interval by default.
    """
    if not found.parameters:
        return {}
    covariance = _covariance(problem, found)
    values = user_values(problem, found.values)
    intervals = {}
    for name, parameter in user_parameters(problem, found).items():
        slope = _slope(problem, found, name)
        half = deviations * float(np.sqrt(max(float(slope @ covariance @ slope), 0.0)))
        low, high = values[name] - half, values[name] + half
        low, high = min(low, *parameter.equivalents, high), max(high, *parameter.equivalents, low)
        intervals[name] = max(low, parameter.lower), min(high, parameter.upper)
    return intervals


def _covariance(problem: Problem, found: Fit) -> Array:
    """(p, p) of the freed parameters, each in its scale."""
    _, rows = problem.whitened(found.residual, found.jacobian, found.discrepancy)
    normal = rows @ rows.T + np.diag(prior_weights(found.parameters) ** 2)
    # The pseudo-inverse: what the log says nothing of may lie anywhere within its bounds.
    covariance: Array = np.asarray(np.linalg.pinv(normal + 1e-9 * np.eye(len(normal))), dtype=np.float64)
    return covariance + model_error_covariance(problem, found, rows, covariance)


def intervals_beside_all_nuisance(problem: Problem, found: Fit) -> dict[str, tuple[float, float]]:
    """95 % interval of each freed parameter in an answer, with a Jacobian of the fit.

    It is `SPREAD_OF_ANSWERS` times as wide as the fit says.

    Nuisance that the log gave no reason to calibrate (`HasConditionalNuisance`) is still not known: here it is as free
    as its prior says. Otherwise what acts alike would seem better known where a log shows less.

    Args:
        problem: The problem of the fit.
        found: The fit.
    """
    again = _beside_all_nuisance(problem, found)
    known = set(user_values(problem, found.values))
    intervals = parameter_intervals(problem, again, SPREAD_OF_ANSWERS * TWO_SIDED_95)
    return {name: interval for name, interval in intervals.items() if name in known}


def deviations_from_none(problem: Problem, found: Fit, name: str) -> float:
    """Standard deviations of the fit by which a freed parameter is off its nominal value, all nuisance as unknown.

    Args:
        problem: The problem of the fit.
        found: The fit.
        name: Of the parameter, as the model calls it: an amplitude is known better than what a user calls the size.
    """
    again = _beside_all_nuisance(problem, found)
    index = [parameter.name for parameter in again.parameters].index(name)
    parameter = again.parameters[index]
    deviation = parameter.scale * float(np.sqrt(_covariance(problem, again)[index, index]))
    return abs(found.values[name] - parameter.nominal) / deviation


def _beside_all_nuisance(problem: Problem, found: Fit) -> Fit:
    """The fit with all nuisance freed, none of it moved."""
    freed = {parameter.name for parameter in found.parameters}
    conditional = problem.model.conditional_nuisance if isinstance(problem.model, HasConditionalNuisance) else ()
    unfitted = [each for effect in conditional for each in effect.parameters if each.name not in freed]
    parameters = [*found.parameters, *problem.expand_per_run(unfitted)]
    return fit(problem, parameters, found.values, iterations=0, known=KnownStart(found.simulated))


def user_values(problem: Problem, values: dict[str, float]) -> dict[str, float]:
    """Fitted values by the names that a user knows."""
    return problem.model.to_user(values) if isinstance(problem.model, HasUserParameters) else dict(values)


def user_parameters(problem: Problem, found: Fit) -> dict[str, Parameter]:
    """The freed parameters by the names that a user knows."""
    freed = {parameter.name: parameter for parameter in found.parameters}
    converted = problem.model.user_parameters if isinstance(problem.model, HasUserParameters) else {}
    names = [name for name in user_values(problem, found.values) if name in {**freed, **converted}]
    return {name: freed.get(name) or converted[name] for name in names}


def _slope(problem: Problem, found: Fit, name: str) -> Array:
    """(p,) change of one user parameter per scale of each freed one."""
    here = user_values(problem, found.values)[name]
    return np.array([
        (user_values(problem, found.values | {p.name: found.values[p.name] + _STEP * p.scale})[name] - here) / _STEP
        for p in found.parameters
    ])  # fmt: skip
