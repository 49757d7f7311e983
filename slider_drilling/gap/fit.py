"""One least-squares fit of a model's parameters: scipy's, on batched finite-difference Jacobians.

One iteration costs one batch: the residual and every column of its Jacobian are simulated together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from slider_drilling.gap.model import Array, Parameter, Values
from slider_drilling.gap.residuals import PRIOR_SHARE, Problem

# Finite-difference step in units of a parameter's scale: large against the kinks that stick and slip leave in
# the residual, small against the curvature over one scale.
STEP = 0.2


@dataclass(frozen=True)
class Fit:
    """One local optimum.

    values: by name, nuisance and effects that were freed; parameters: their descriptions, in the Jacobian's
    order; residual (N,), jacobian (N, p) of the residual per scale; cost: the fit's objective.
    """

    values: dict[str, float]
    parameters: tuple[Parameter, ...]
    residual: Array
    jacobian: Array
    cost: float
    converged: bool

    @property
    def refitted(self) -> NDArray[np.bool_]:
        """(p,) whether a refit without a stretch of the run frees the parameter: what belongs to the run stays."""
        return np.array([not parameter.per_run for parameter in self.parameters], dtype=bool)


class _Objective:
    """Residual and Jacobian of the free parameters in scaled coordinates, evaluated together and kept."""

    def __init__(self, problem: Problem, parameters: Sequence[Parameter], fixed: Values) -> None:
        self.problem, self.parameters, self.fixed = problem, list(parameters), dict(fixed)
        self.scale = np.array([parameter.scale for parameter in parameters])
        self.nominal = np.array([parameter.nominal for parameter in parameters])
        self.lower = (np.array([parameter.lower for parameter in parameters]) - self.nominal) / self.scale
        self.upper = (np.array([parameter.upper for parameter in parameters]) - self.nominal) / self.scale
        self.prior = prior_rows(self.parameters)
        self.kept: list[tuple[Array, Array, Array]] = []

    def values(self, point: Array) -> dict[str, float]:
        chosen = self.nominal + self.scale * point
        return self.fixed | {p.name: float(v) for p, v in zip(self.parameters, chosen, strict=True)}

    def evaluate(self, point: Array) -> tuple[Array, Array]:
        for known, residual, jacobian in self.kept:
            if np.array_equal(known, point):
                return residual, jacobian
        step = np.where(point + STEP < self.upper, STEP, -STEP)
        trials = [self.values(point)]
        for index in range(point.size):
            moved = point.copy()
            moved[index] += step[index]
            trials.append(self.values(moved))
        # Columns are differences of simulations, not of residuals: a simulated angle is continuous, a residual wraps.
        simulated = self.problem.simulate(trials)
        jacobian = ((simulated[0] - simulated[1:]) / step[:, None]).T
        residual = self.problem.against_log(simulated[0])
        self.kept = [*self.kept[-1:], (point.copy(), residual, jacobian)]
        return residual, jacobian

    def residual(self, point: Array) -> Array:
        residual, _ = self.evaluate(point)
        mapped, _ = self.problem.robust(residual)
        return np.concatenate([self.problem.weight * mapped, self.prior * point])

    def jacobian(self, point: Array) -> Array:
        residual, jacobian = self.evaluate(point)
        _, slope = self.problem.robust(residual)
        return np.concatenate([(self.problem.weight * slope)[:, None] * jacobian, np.diag(self.prior)])


def prior_rows(parameters: Sequence[Parameter]) -> Array:
    """(p,) weight of each scaled parameter's distance from nominal in the fit."""
    spread = np.array([parameter.spread for parameter in parameters])
    scale = np.array([parameter.scale for parameter in parameters])
    return np.where(np.isfinite(spread), scale / spread, 0.0) * np.sqrt(PRIOR_SHARE)


def fit(
    problem: Problem,
    parameters: Sequence[Parameter],
    start: Values,
    *,
    iterations: int = 12,
    tolerance: float = 1e-4,
) -> Fit:
    """Robust least squares over the parameters from one start; names in start that are not free stay fixed.

    parameters are already expanded per run (`Problem.free`).
    """
    fixed = {name: value for name, value in start.items() if name not in {p.name for p in parameters}}
    objective = _Objective(problem, parameters, fixed)
    begin = np.array([(start.get(p.name, p.nominal) - p.nominal) / p.scale for p in parameters])
    inside = 1e-3 * np.minimum(objective.upper - objective.lower, 1.0)
    begin = np.clip(begin, objective.lower + inside, objective.upper - inside)
    found = least_squares(
        objective.residual, begin, jac=objective.jacobian, bounds=(objective.lower, objective.upper),
        max_nfev=iterations, ftol=tolerance, xtol=1e-4, gtol=1e-10,
    )  # fmt: skip
    residual, jacobian = objective.evaluate(found.x)
    return Fit(
        objective.values(found.x), tuple(parameters), residual, jacobian, problem.robust_gap(residual), found.status > 0
    )
