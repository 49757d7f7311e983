"""A fit from one start: Gauss-Newton on the whitened residual, several steps tried in one batch.

One iteration is a batch of simulations for the columns of a Jacobian and one for trial steps; where the last step went
as foretold, what it changed brings the Jacobian up to date instead of simulations. The discrepancy is estimated again
at each point (profile likelihood), so a channel that the model cannot follow yet loses weight by itself, and regains it
as the fit gets there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from scipy.optimize import lsq_linear
from scipy.stats import chi2

from slider_drilling.gap.evidence.likelihood import Discrepancy
from slider_drilling.gap.model import Array, Parameter, Values
from slider_drilling.gap.problem.problem import Problem

# Of ``-2 log p``: an iteration that gains less is the last; one free number gains as much on noise as often as not.
TOLERANCE = float(chi2.ppf(0.5, 1))
# Iterations of a fit at most.
MAX_ITERATIONS = 8
# Finite-difference step in units of a parameter's scale: large against the kinks that stick and slip leave in a
# residual, small against the curvature over one scale.
DIFFERENCE_STEP = 0.2
# How far a linear forecast is trusted: a trial step is damped by as much of the scales' own curvature; where no trial
# helps, the next ones are shorter by as much, once; a Jacobian that missed less of what a step changed serves for the
# next one too.
TRUST_FRACTION = 0.25


@dataclass(frozen=True)
class Fit:
    """One local optimum, or the way there.

    values: everything that is not nominal; parameters: those freed, in the Jacobian's order; simulated, residual:
    (N,) noise units; jacobian: (p, N) of the simulation per scale; cost: ``-2 log p`` with the priors; discrepancy:
    by piece; settled: whether the last iteration brought less than the tolerance; stale: whether a fit that goes on
    from here needs a new Jacobian.
    """

    values: dict[str, float]
    parameters: tuple[Parameter, ...]
    simulated: Array = field(repr=False)
    residual: Array = field(repr=False)
    jacobian: Array = field(repr=False)
    cost: float
    discrepancy: dict[int, Discrepancy]
    converged: bool
    jacobian_stale: bool

    @property
    def jacobian_rows(self) -> dict[str, Array]:
        """The Jacobian's rows (N,) by parameter."""
        return {parameter.name: row for parameter, row in zip(self.parameters, self.jacobian, strict=True)}

    @property
    def reusable_rows(self) -> dict[str, Array]:
        """The rows that a fit which goes on from here may begin with: none where they are stale."""
        return {} if self.jacobian_stale else self.jacobian_rows


def fit(
    problem: Problem,
    parameters: Sequence[Parameter],
    start: Values,
    *,
    iterations: int | None = None,
    tolerance: float | None = None,
    sample_weights: Array | None = None,
    simulated: Array | None = None,
    jacobian_rows: Mapping[str, Array] = MappingProxyType({}),
    trust_rows: bool = False,
) -> Fit:
    """Follow the likelihood down from one start; names in start that are not free stay as they are.

    parameters: expanded per run (`Problem.free`). iterations: ITERATIONS by default, 0 for the start itself with its
    Jacobian. tolerance: of ``-2 log p``, TOLERANCE by default. kept: (N,) weights 0 or 1, samples that count (all by
    default). simulated: (N,) of the start, known: rows (N,) of the first Jacobian by name, where another fit has them
    already; trusted: whether these are as good as new ones, so that where they lead nowhere nothing does.
    """
    space = _Space(problem, parameters, start, sample_weights)
    least = TOLERANCE if tolerance is None else tolerance
    point = space.begin(start)
    simulated, jacobian = space.linearised(point, simulated, jacobian_rows)
    cost, found = space.cost(simulated, point)
    reach, stale, fresh, settled = 1.0, False, trust_rows or not jacobian_rows, False
    for _ in range(MAX_ITERATIONS if iterations is None else iterations):
        if stale:
            simulated, jacobian = space.linearised(point, simulated, {})
            fresh = True
        trials = space.trials(point, problem.residual_of(simulated), jacobian, found, reach)
        outcomes = problem.simulate([space.values(trial) for trial in trials])
        costs = [space.cost(outcome, trial) for outcome, trial in zip(outcomes, trials, strict=True)]
        best = int(np.argmin([entry[0] for entry in costs]))
        gained = cost - costs[best][0]
        carried = stale = not fresh  # where a Jacobian that was carried along leads nowhere, a new one may
        if gained > 0.0:
            fresh = False
            jacobian, foretold = broyden_update(jacobian, trials[best] - point, outcomes[best] - simulated)
            stale = foretold < 1.0 - TRUST_FRACTION
            point, simulated, (cost, found) = trials[best], outcomes[best], costs[best]
        if gained >= least:
            reach = 1.0
        elif stale and carried:
            continue
        elif reach == 1.0:
            reach = TRUST_FRACTION
        else:
            settled = True
            break
    return Fit(
        space.values(point), tuple(space.parameters), simulated, problem.residual_of(simulated), jacobian, cost, found,
        settled, stale,
    )  # fmt: skip


def min_gain_to_catch_up(behind: float, iterations: int | None = None) -> float:
    """The least gain of ``-2 log p`` that makes an iteration worth another one to a fit that is so far behind another:
    who gains less does not come up with it in so many.
    """
    return max(TOLERANCE, behind / (MAX_ITERATIONS if iterations is None else iterations))


def penalized_cost(problem: Problem, parameters: Sequence[Parameter], values: Values, simulated: Array) -> float:
    """``-2 log p`` with the priors of these parameters, of values whose simulation (N,) is known."""
    space = _Space(problem, parameters, values, None)
    return space.cost(simulated, space.begin(values))[0]


class _Space:
    """Scaled coordinates of the free parameters, their bounds and priors."""

    def __init__(self, problem: Problem, parameters: Sequence[Parameter], start: Values, kept: Array | None) -> None:
        self.problem, self.parameters, self.kept = problem, list(parameters), kept
        names = {parameter.name for parameter in parameters}
        self.fixed = {name: value for name, value in start.items() if name not in names}
        self.scale = np.array([parameter.scale for parameter in parameters])
        self.nominal = np.array([parameter.nominal for parameter in parameters])
        self.lower = (np.array([parameter.lower for parameter in parameters]) - self.nominal) / self.scale
        self.upper = (np.array([parameter.upper for parameter in parameters]) - self.nominal) / self.scale
        self.prior = prior_weights(self.parameters)

    def begin(self, start: Values) -> Array:
        return np.clip(scaled_offsets(self.parameters, start), self.lower, self.upper)

    def values(self, point: Array) -> dict[str, float]:
        chosen = self.nominal + self.scale * point
        return self.fixed | {p.name: float(v) for p, v in zip(self.parameters, chosen, strict=True)}

    def cost(self, simulated: Array, point: Array) -> tuple[float, dict[int, Discrepancy]]:
        residual = self.problem.residual_of(simulated)
        if not np.isfinite(residual).all():
            return float("inf"), {}
        total, found = self.problem.cost(residual)
        if self.kept is not None:
            total = float(self.problem.log_density(residual, found) @ self.kept)
        return total + float(np.sum((self.prior * point) ** 2)), found

    def linearised(
        self, point: Array, simulated: Array | None, known: Mapping[str, Array]
    ) -> tuple[Array, Array]:
        """The simulation (N,), and (p, N) its change per scale; what is not known yet is simulated in one batch."""
        step = np.where(point + DIFFERENCE_STEP < self.upper, DIFFERENCE_STEP, -DIFFERENCE_STEP)
        new = [index for index, parameter in enumerate(self.parameters) if parameter.name not in known]
        asked = [] if simulated is not None else [self.values(point)]
        asked += [self.values(point + step[index] * np.eye(point.size)[index]) for index in new]
        outcomes = self.problem.simulate(asked) if asked else np.empty((0, self.problem.size))
        here = outcomes[0] if simulated is None else simulated
        rows = np.array([known.get(parameter.name, here) for parameter in self.parameters])
        rows = rows.reshape(point.size, self.problem.size)
        rows[new] = (outcomes[len(asked) - len(new) :] - here) / step[new, None]
        return here, rows

    def trials(
        self, point: Array, residual: Array, jacobian: Array, found: dict[int, Discrepancy], reach: float
    ) -> list[Array]:
        """Points to try next, inside the bounds: a Gauss-Newton step, a damped one, and one by the residual as it is.

        reach: share of each step that is gone.
        """
        low, high = self.lower - point, self.upper - point
        tried = []
        for forgiving, dampings in ((True, (0.0, TRUST_FRACTION)), (False, (0.0,))):
            white, rows = self.problem.whitened(residual, jacobian, found, forgiving)
            if self.kept is not None:
                white, rows = white * self.kept, rows * self.kept
            normal = rows @ rows.T + np.diag(self.prior**2)
            gradient = rows @ white - self.prior**2 * point
            tried += [bounded_step(normal, gradient, damping, low, high) for damping in dampings]
        return [np.clip(point + reach * step, self.lower, self.upper) for step in tried]


def broyden_update(jacobian: Array, step: Array, change: Array) -> tuple[Array, float]:
    """A Jacobian (p, N) with what a step (p,) was seen to change (N,), and the share of that change it had foretold.

    Broyden's update (Math. Comp. 19, 1965): the smallest that gives the change, so that where derivatives change slowly
    the next step needs no simulation for them.
    """
    missed = change - step @ jacobian
    share = 1.0 - float(missed @ missed) / max(float(change @ change), 1e-30)
    return jacobian + np.outer(step / max(float(step @ step), 1e-30), missed), share


def bounded_step(normal: Array, gradient: Array, damping: float, low: Array, high: Array) -> Array:
    """s (p,) that minimises ``s' (normal + damping diag) s / 2 - gradient' s`` within bounds."""
    diagonal = np.diag(normal)
    ridge = damping * diagonal + 1e-9 * max(float(diagonal.max(initial=0.0)), 1e-30)
    factor = np.linalg.cholesky(normal + np.diag(ridge))
    right = np.linalg.solve(factor, gradient)
    margin = 1e-9
    return np.asarray(lsq_linear(factor.T, right, (low - margin, high + margin), method="bvls").x)


def scaled_offsets(parameters: Sequence[Parameter], values: Values) -> Array:
    """(p,) how far each parameter is from nominal, in scales."""
    return np.array([(values.get(p.name, p.nominal) - p.nominal) / p.scale for p in parameters])


def distance_to_bounds(parameters: Sequence[Parameter], values: Values) -> tuple[Array, Array]:
    """(p,) how far each parameter may go down and up from its value, in scales: at most 0 and at least 0."""
    here = np.array([values.get(p.name, p.nominal) for p in parameters])
    scale = np.array([p.scale for p in parameters])
    low = (np.array([p.lower for p in parameters]) - here) / scale
    high = (np.array([p.upper for p in parameters]) - here) / scale
    return np.minimum(low, 0.0), np.maximum(high, 0.0)


def prior_weights(parameters: Sequence[Parameter]) -> Array:
    """(p,) one over the prior's spread in scales, 0 where nothing is known."""
    return np.array([p.scale / p.spread if np.isfinite(p.spread) else 0.0 for p in parameters])
