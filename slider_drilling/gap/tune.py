"""Fits of whole runs where least squares alone would stick: grown over time, shaken, begun from many points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import qmc

from slider_drilling.gap.fit import Fit, fit
from slider_drilling.gap.model import Parameter, Shortened, Values
from slider_drilling.gap.predictability import foresee, glimpse
from slider_drilling.gap.residuals import Problem, build_problem
from slider_drilling.gap.shake import roam, shake

_SCATTER_BATCH = 64
# Shares of the runs that a fit from afar grows over.
GROWTH = (0.4, 0.7, 1.0)
# A price of the floors above which derivatives say little of where to go.
ROUGH = 0.1
# Where the fit leaves no more cost than this, there is nothing to search for.
SMOOTH = 1.1
# Times that `sharpen` takes the size of a forgiven step, and of the cost that it may add elsewhere.
_STRICT, CONTENT = 8.0, 1.03


def fit_growing(
    problem: Problem,
    parameters: Sequence[Parameter],
    start: Values,
    *,
    iterations: int = 5,
    shares: Sequence[float] = GROWTH,
    shaken: Sequence[float] = (),
) -> Fit:
    """`fit` on a growing first part of the runs; the model is made exact before each, and at the end of whole runs.

    What happens late hangs on everything before it: a string that breaks free once too often early on leaves every
    later angle wrong, and a fit of the whole run from there finds no way back. shaken: the shares after which follows
    a search around what least squares found (`slider_drilling.gap.shake`), and least squares again from there.
    """
    best, reached = None, 0.0
    values: Values = start
    for share in shares:
        part = problem if share >= 1.0 else first_part(problem, share)
        found = [fit_exactly(part, parameters, values, iterations)]
        if share in shaken and found[0].cost > SMOOTH:
            found.append(fit_exactly(part, parameters, shake(part, found[0], seed=1), iterations))
        if best is not None and share == reached:
            found.append(best)
        best, reached = min(found, key=lambda entry: entry.cost), share
        values = best.values
    assert best is not None
    if reached >= 1.0:
        problem.anchor(best.values)
    return best


def roamed(problem: Problem, found: Fit, iterations: int) -> Fit:
    """A fit, or what a wide search around it finds where it stands on rough ground."""
    problem.anchor(found.values)
    own = glimpse(problem, found)
    if float(own.weight**2 @ own.price) <= ROUGH:
        return found
    other = fit_exactly(problem, found.parameters, roam(problem, found), iterations)
    return min(found, other, key=lambda entry: entry.cost)


def begun_again(problem: Problem, found: Fit) -> Fit:
    """A fit of whole runs, or what it becomes when what belongs to the run begins at its nominal value again.

    A tool-face zero that is off looks like one missed step at the very start, which costs little; from there no small
    change of it is better.
    """
    start = found.values | {p.name: p.nominal for p in found.parameters if p.per_run}
    other = fit_growing(problem, found.parameters, start, iterations=6, shares=(1.0,))
    if other.cost < found.cost:
        return other
    problem.anchor(found.values)
    return found


def sharpen(problem: Problem, found: Fit) -> Fit:
    """The fit once more with missed steps priced higher, where that leaves everything else as it was.

    A loss that forgives a missed step finds the right place, and is then content some degrees off.
    """
    strict = replace(problem, step_size=_STRICT * problem.step_size)
    sharper = fit_growing(strict, found.parameters, found.values, iterations=6, shares=(1.0,), shaken=(1.0,))
    cost = problem.robust_gap(sharper.residual)
    better = problem.gap_squared(sharper.residual) < problem.gap_squared(found.residual)
    if better and cost <= CONTENT * found.cost:
        return replace(sharper, cost=cost)
    problem.anchor(found.values)
    return found


def foreseen(problem: Problem, found: Fit) -> tuple[Problem, Fit]:
    """The problem in a fit's own floors, and the same fit in them."""
    own = foresee(problem, found)
    residual = problem.in_floors_of(own, found.residual)
    jacobian = found.jacobian * (problem.floor / own.floor)[:, None]
    return own, replace(found, residual=residual, jacobian=jacobian, cost=own.robust_gap(residual))


def settle(problem: Problem, found: Fit) -> tuple[Problem, Fit]:
    """The problem in a fit's own floors, and the fit once more in them."""
    own = foresee(problem, found)
    return own, fit_growing(own, found.parameters, found.values, iterations=6, shares=(1.0,))


def fit_exactly(problem: Problem, parameters: Sequence[Parameter], start: Values, iterations: int) -> Fit:
    """`fit` with the model made exact before and after: residual and cost are those of the exact model."""
    problem.anchor(start)
    found = fit(problem, parameters, start, iterations=iterations)
    problem.anchor(found.values)
    residual = problem.residuals([found.values])[0]
    return replace(found, residual=residual, cost=problem.robust_gap(residual))


def first_part(problem: Problem, share: float) -> Problem:
    """The problem of the first part of the runs: of a shortened model where there is one, else by weight."""
    if isinstance(problem.model, Shortened):
        part = build_problem(problem.model.shortened(share), problem.floors)
        floor = np.concatenate([problem.floor[problem.slices[key]][: own.stop - own.start]
                                for key, own in part.slices.items()])  # fmt: skip
        return replace(part, floor=floor, step_size=problem.step_size)
    weight = problem.weight.copy()
    for index, run in enumerate(problem.model.runs):
        weight[(problem.run == index) & (problem.time > run.time[0] + share * run.duration)] = 0.0
    return replace(problem, weight=weight / np.sqrt(np.sum(weight**2)))


def scattered(
    problem: Problem, parameters: Sequence[Parameter], base: Values, count: int, keep: int
) -> list[dict[str, float]]:
    """The best ``keep`` of ``count`` points spread evenly over where the parameters may plausibly lie.

    For records whose residual has many local minima: with stick-slip a wrong phase costs more than a wrong amplitude.
    """
    points = [dict(base) | point for point in spread_out(parameters, count, 2.0)]
    costs = np.empty(count)
    for begin in range(0, count, _SCATTER_BATCH):
        residuals = problem.residuals(points[begin : begin + _SCATTER_BATCH])
        costs[begin : begin + _SCATTER_BATCH] = [problem.robust_gap(residual) for residual in residuals]
    return [points[index] for index in np.argsort(costs)[:keep]]


def spread_out(parameters: Sequence[Parameter], count: int, spreads: float) -> list[dict[str, float]]:
    """Points (Sobol) within so many spreads of nominal, or between the bounds where no spread is known."""
    if count == 0 or not parameters:
        return [{}] * count
    low = np.array([max(p.lower, p.nominal - spreads * p.spread) for p in parameters])
    high = np.array([min(p.upper, p.nominal + spreads * p.spread) for p in parameters])
    unit = qmc.Sobol(len(parameters), seed=0).random(count)
    return [
        {p.name: float(v) for p, v in zip(parameters, row, strict=True)} for row in low + (high - low) * unit
    ]
