"""A fit from one start: Gauss-Newton on the whitened residual, several steps tried in one batch.

One iteration takes a batch of simulations for the columns of a Jacobian and one for trial steps. Where the last step
went as predicted, its outcome updates the Jacobian without simulations. The discrepancy is estimated again at each
point (profile likelihood): a channel that the model cannot follow yet loses weight, and regains it as the fit improves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import lsq_linear
from scipy.stats import chi2

from slider_drilling.gap.evidence.likelihood import Discrepancy
from slider_drilling.gap.model import Array, Parameter, Values
from slider_drilling.gap.problem.problem import Problem

# Gain of ``-2 log p`` below which an iteration is the last: one parameter gains as much on noise half of the time.
TOLERANCE = float(chi2.ppf(0.5, 1))
# Largest number of iterations of a fit.
MAX_ITERATIONS = 8
# Finite-difference step in units of a parameter's scale: large against the kinks that stick and slip leave in a
# residual, small against the curvature over one scale.
DIFFERENCE_STEP = 0.2
# How far a linear prediction is trusted. A damped trial step adds this share of the scales' own curvature; where no
# trial helps, the next ones are shorter by this factor, once; a Jacobian is kept while its prediction misses less than
# this share of what a step changed.
TRUST_FRACTION = 0.25


@dataclass(frozen=True)
class Fit:
    """A local optimum, or the way there.

    Attributes:
        values: Parameter values; all others are nominal.
        parameters: Free parameters, in the Jacobian's order.
        simulated: (N,) in noise units.
        residual: (N,) in noise units.
        jacobian: (p, N) change of the simulation per scale of each parameter.
        cost: ``-2 log p`` with the priors.
        discrepancy: Discrepancy of each piece.
        converged: Whether the last iteration gained less than the tolerance.
        jacobian_stale: Whether a fit that continues from here needs a new Jacobian.
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
        """Rows that a fit which continues from here may start with; none if they are stale."""
        return {} if self.jacobian_stale else self.jacobian_rows


@dataclass(frozen=True)
class KnownStart:
    """What is known of the start of a fit, and need not be simulated.

    Attributes:
        simulated: (N,) simulation of the start, None where it is not known.
        jacobian_rows: Rows (N,) of the first Jacobian by parameter, where another fit has them.
        trust_rows: Whether these rows are as good as new ones: where they lead nowhere, the fit ends.
    """

    simulated: Array | None = field(default=None, repr=False)
    jacobian_rows: Mapping[str, Array] = field(default_factory=dict, repr=False)
    trust_rows: bool = False


NOTHING_KNOWN = KnownStart()


def fit(
    problem: Problem,
    parameters: Sequence[Parameter],
    start: Values,
    *,
    iterations: int | None = None,
    tolerance: float | None = None,
    sample_weights: Array | None = None,
    known: KnownStart = NOTHING_KNOWN,
) -> Fit:
    """Follow the likelihood to a local optimum from one start.

    Args:
        problem: What to fit.
        parameters: Free parameters, expanded per run (`Problem.expand_per_run`).
        start: Values to start from. Those of parameters that are not free stay as they are.
        iterations: Largest number of iterations, `MAX_ITERATIONS` by default; 0 for the start with its Jacobian.
        tolerance: Gain of ``-2 log p`` below which an iteration is the last, `TOLERANCE` by default.
        sample_weights: (N,) 0 or 1, samples that count; all by default.
        known: What is known of the start.

    Returns:
        The fit where it ended.
    """
    space = _Space(problem, parameters, start, sample_weights)
    least_gain = TOLERANCE if tolerance is None else tolerance
    at = space.start(start, known)
    if not np.isfinite(at.cost):
        iterations = 0  # no step leads on from where nothing can be simulated
    step_length, stale, fresh, converged = 1.0, False, known.trust_rows or not known.jacobian_rows, False
    for _ in range(MAX_ITERATIONS if iterations is None else iterations):
        if stale:
            at, fresh = space.with_new_jacobian(at), True
        best = space.best_trial(at, step_length)
        gain = at.cost - best.cost
        # Where a reused Jacobian leads nowhere, a new one may lead on.
        reused = stale = not fresh
        if gain > 0.0:
            fresh = False
            jacobian, predicted = broyden_update(at.jacobian, best.point - at.point, best.simulated - at.simulated)
            stale = predicted < 1.0 - TRUST_FRACTION
            at = replace(best, jacobian=jacobian)
        if gain >= least_gain:
            step_length = 1.0
        elif stale and reused:
            continue
        elif step_length == 1.0:
            step_length = TRUST_FRACTION
        else:
            converged = True
            break
    return Fit(
        space.values(at.point), tuple(space.parameters), at.simulated, problem.residual_of(at.simulated), at.jacobian,
        at.cost, at.discrepancies, converged, stale,
    )  # fmt: skip


def linearised_at_its_end(problem: Problem, found: Fit) -> Fit:
    """The same fit with a Jacobian that is simulated where it ended.

    That of the fit itself comes from an earlier point, with what its steps told since: enough to go on, but not to say
    how well a parameter is known.
    """
    here = fit(problem, found.parameters, found.values, iterations=0, known=KnownStart(found.simulated))
    return replace(found, jacobian=here.jacobian, jacobian_stale=False)


def min_gain_to_catch_up(behind: float, iterations: int | None = None) -> float:
    """Gain of ``-2 log p`` that an iteration must bring for a fit to catch up with a better one.

    Args:
        behind: How far the fit is behind, ``-2 log p``.
        iterations: In how many iterations, `MAX_ITERATIONS` by default.

    Returns:
        The gain, no less than `TOLERANCE`.
    """
    return max(TOLERANCE, behind / (MAX_ITERATIONS if iterations is None else iterations))


def penalized_cost(problem: Problem, parameters: Sequence[Parameter], values: Values, simulated: Array) -> float:
    """``-2 log p`` with the priors of these parameters, of values whose simulation (N,) is known."""
    space = _Space(problem, parameters, values, None)
    return space.cost(simulated, space.begin(values))[0]


@dataclass(frozen=True)
class _Point:
    """A place in the space of the free parameters, and the simulation there.

    Attributes:
        point: (p,) in units of the scales.
        simulated: (N,) in noise units.
        jacobian: (p, N) change of the simulation per scale.
        cost: ``-2 log p`` with the priors.
        discrepancies: Of each piece.
    """

    point: Array
    simulated: Array
    jacobian: Array
    cost: float
    discrepancies: dict[int, Discrepancy]


class _Space:
    """The free parameters as a point (p,) in units of their scales, with bounds and priors."""

    def __init__(
        self, problem: Problem, parameters: Sequence[Parameter], start: Values, sample_weights: Array | None
    ) -> None:
        self.problem, self.parameters, self.sample_weights = problem, list(parameters), sample_weights
        names = {parameter.name for parameter in parameters}
        self.fixed = {name: value for name, value in start.items() if name not in names}
        self.scale = np.array([parameter.scale for parameter in parameters])
        self.nominal = np.array([parameter.nominal for parameter in parameters])
        self.lower = (np.array([parameter.lower for parameter in parameters]) - self.nominal) / self.scale
        self.upper = (np.array([parameter.upper for parameter in parameters]) - self.nominal) / self.scale
        self.prior = prior_weights(self.parameters)

    def begin(self, start: Values) -> Array:
        """The point of the start, within the bounds."""
        return np.clip(scaled_offsets(self.parameters, start), self.lower, self.upper)

    def start(self, values: Values, known: KnownStart) -> _Point:
        """The start of a fit; what is not known yet is simulated."""
        point = self.begin(values)
        simulated, jacobian = self.linearise(point, known.simulated, known.jacobian_rows)
        return _Point(point, simulated, jacobian, *self.cost(simulated, point))

    def with_new_jacobian(self, at: _Point) -> _Point:
        """The same place with derivatives that are simulated anew."""
        return replace(at, jacobian=self.linearise(at.point, at.simulated, {})[1])

    def best_trial(self, at: _Point, step_length: float) -> _Point:
        """The cheapest of the trial steps, with the Jacobian from which they were taken."""
        residual = self.problem.residual_of(at.simulated)
        trials = self.trials(at.point, residual, at.jacobian, at.discrepancies, step_length)
        outcomes = self.problem.simulate([self.values(trial) for trial in trials])
        costs = [self.cost(outcome, trial) for outcome, trial in zip(outcomes, trials, strict=True)]
        best = int(np.argmin([cost for cost, _ in costs]))
        return _Point(trials[best], outcomes[best], at.jacobian, *costs[best])

    def values(self, point: Array) -> dict[str, float]:
        """Parameter values at a point."""
        free = self.nominal + self.scale * point
        return self.fixed | {p.name: float(v) for p, v in zip(self.parameters, free, strict=True)}

    def cost(self, simulated: Array, point: Array) -> tuple[float, dict[int, Discrepancy]]:
        """``-2 log p`` with the priors, infinite if the simulation is not finite; and the discrepancies."""
        residual = self.problem.residual_of(simulated)
        if not np.isfinite(residual).all():
            return float("inf"), {}
        total, discrepancies = self.problem.cost(residual)
        if self.sample_weights is not None:
            total = float(self.problem.log_density(residual, discrepancies) @ self.sample_weights)
        return total + float(np.sum((self.prior * point) ** 2)), discrepancies

    def linearise(
        self, point: Array, simulated: Array | None, known_rows: Mapping[str, Array]
    ) -> tuple[Array, Array]:
        """The simulation (N,) and its Jacobian (p, N); what is not known yet is simulated in one batch.

        A parameter whose step cannot be simulated has derivatives of 0: it stays where it is.
        """
        step = np.where(point + DIFFERENCE_STEP < self.upper, DIFFERENCE_STEP, -DIFFERENCE_STEP)
        new = [index for index, parameter in enumerate(self.parameters) if parameter.name not in known_rows]
        sets = [] if simulated is not None else [self.values(point)]
        sets += [self.values(point + step[index] * np.eye(point.size)[index]) for index in new]
        outcomes = self.problem.simulate(sets) if sets else np.empty((0, self.problem.size))
        here = outcomes[0] if simulated is None else simulated
        rows = np.array([known_rows.get(parameter.name, here) for parameter in self.parameters])
        rows = rows.reshape(point.size, self.problem.size)
        rows[new] = (outcomes[len(sets) - len(new) :] - here) / step[new, None]
        rows[~np.isfinite(rows).all(axis=1)] = 0.0
        return here, rows

    def trials(
        self, point: Array, residual: Array, jacobian: Array, discrepancies: dict[int, Discrepancy], step_length: float
    ) -> list[Array]:
        """Points to try next, within the bounds.

        A Gauss-Newton step, a damped one, and one on the residual without discrepancy, each times ``step_length``.
        """
        low, high = self.lower - point, self.upper - point
        steps = []
        for robust, dampings in ((True, (0.0, TRUST_FRACTION)), (False, (0.0,))):
            white, rows = self.problem.whitened(residual, jacobian, discrepancies, robust)
            if self.sample_weights is not None:
                white, rows = white * self.sample_weights, rows * self.sample_weights
            normal = rows @ rows.T + np.diag(self.prior**2)
            gradient = rows @ white - self.prior**2 * point
            steps += [bounded_step(normal, gradient, damping, low, high) for damping in dampings]
        return [np.clip(point + step_length * step, self.lower, self.upper) for step in steps]


def broyden_update(jacobian: Array, step: Array, change: Array) -> tuple[Array, float]:
    """Update a Jacobian by the outcome of a step (Broyden, Math. Comp. 19, 1965).

    It is the smallest update that gives the change, so that where derivatives change slowly the next step needs no
    simulation for them.

    Args:
        jacobian: (p, N).
        step: (p,).
        change: (N,) of the simulation, by the step.

    Returns:
        The Jacobian (p, N), and the share of the change that the old one had predicted.
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
    # lsq_linear asks for bounds that differ.
    margin = 1e-9
    # lsq_linear tries the unbounded step first, too; its checks of the arguments take longer than the step itself.
    free = np.asarray(np.linalg.lstsq(factor.T, right, rcond=-1)[0])
    if np.all((free >= low - margin) & (free <= high + margin)):
        return free
    return np.asarray(lsq_linear(factor.T, right, (low - margin, high + margin), method="bvls").x)


def scaled_offsets(parameters: Sequence[Parameter], values: Values) -> Array:
    """(p,) distance of each parameter from nominal, in scales."""
    return np.array([(values.get(p.name, p.nominal) - p.nominal) / p.scale for p in parameters])


def distance_to_bounds(parameters: Sequence[Parameter], values: Values) -> tuple[Array, Array]:
    """(p,) how far each parameter may go down (at most 0) and up (at least 0) from its value, in scales."""
    here = np.array([values.get(p.name, p.nominal) for p in parameters])
    scale = np.array([p.scale for p in parameters])
    low = (np.array([p.lower for p in parameters]) - here) / scale
    high = (np.array([p.upper for p in parameters]) - here) / scale
    return np.minimum(low, 0.0), np.maximum(high, 0.0)


def prior_weights(parameters: Sequence[Parameter]) -> Array:
    """(p,) one over the prior's standard deviation in scales, 0 where nothing is known."""
    return np.array([p.scale / p.spread if np.isfinite(p.spread) else 0.0 for p in parameters])
