"""Fitting parameters to the residuals: scipy's least squares on batched finite-difference Jacobians.

One iteration costs one batch: the residual and every column of its Jacobian are simulated together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from slider_drilling.gap.model import Array, Parameter, Shortened, Values
from slider_drilling.gap.residuals import PRIOR_SHARE, Problem, build_problem

# Finite-difference step in units of a parameter's scale: large against the kinks that stick and slip leave in
# the residual, small against the curvature over one scale.
STEP = 0.2
_SCATTER_BATCH = 64
# Shares of the runs that a fit from afar grows over.
GROWTH = (0.4, 0.7, 1.0)


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
        objective.values(found.x), tuple(parameters), residual, jacobian,
        float(np.sum((problem.weight * problem.robust(residual)[0]) ** 2)), found.status > 0,
    )  # fmt: skip


def fit_growing(
    problem: Problem,
    parameters: Sequence[Parameter],
    start: Values,
    *,
    iterations: int = 5,
    shares: Sequence[float] = GROWTH,
) -> Fit:
    """`fit` on a growing first part of the runs, the last one whole; the model is made exact before each.

    What happens late hangs on everything before it: a string that breaks free once too often early on leaves every
    later angle wrong, and a fit of the whole run from there finds no way back. The model is left exact near the fit.
    """
    best, values = None, dict(start)
    for share in shares:
        problem.anchor(values)
        part = problem if share >= 1.0 else first_part(problem, share)
        best = fit(part, parameters, values, iterations=iterations)
        values = best.values
    assert best is not None
    return best


def first_part(problem: Problem, share: float) -> Problem:
    """The problem of the first part of the runs: of a shortened model where there is one, else by weight."""
    if isinstance(problem.model, Shortened):
        return build_problem(problem.model.shortened(share), problem.floors)
    weight = problem.weight.copy()
    for index, run in enumerate(problem.model.runs):
        weight[(problem.run == index) & (problem.time > run.time[0] + share * run.duration)] = 0.0
    return replace(problem, weight=weight / np.sqrt(np.sum(weight**2)))


def scattered(
    problem: Problem, parameters: Sequence[Parameter], base: Values, count: int, keep: int, seed: int = 0
) -> list[dict[str, float]]:
    """The best ``keep`` of ``count`` points spread evenly over where the parameters may plausibly lie.

    Within two spreads of nominal, or between the bounds where no spread is known. For records whose residual has
    many local minima: with stick-slip a wrong phase costs more than a wrong amplitude.
    """
    if count == 0:
        return []
    low = np.array([max(p.lower, p.nominal - 2.0 * p.spread) for p in parameters])
    high = np.array([min(p.upper, p.nominal + 2.0 * p.spread) for p in parameters])
    unit = qmc.Sobol(len(parameters), seed=seed).random(count)
    points = [
        dict(base) | {p.name: float(v) for p, v in zip(parameters, row, strict=True)}
        for row in low + (high - low) * unit
    ]
    costs = np.empty(count)
    for begin in range(0, count, _SCATTER_BATCH):
        residuals = problem.residuals(points[begin : begin + _SCATTER_BATCH])
        mapped = problem.weight * problem.robust(residuals)[0]
        costs[begin : begin + _SCATTER_BATCH] = np.sum(mapped**2, axis=1)
    return [points[index] for index in np.argsort(costs)[:keep]]
