"""The screen: the gain that one linearised step predicts of every effect, before any effect is fitted.

Every scan point of every effect is simulated once. Its change is scaled like a secant, the nuisance follows by its
derivatives, and the bounded step that leaves least gives the predicted gain and the start of a fit. A derivative at
neutral would not do: for a dead zone, or friction that depends on direction, it says nothing about the size that
matters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from slider_drilling.gap.model import Array, Effect, Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import (
    TRUST_FRACTION,
    Fit,
    bounded_step,
    distance_to_bounds,
    penalized_cost,
    prior_weights,
    scaled_offsets,
)

# Share of an amplitude's range by which starts stay away from its bounds.
_MARGIN = 0.02
# How far a derivative is trusted, in scales of a nuisance parameter, and a secant, in its scan point's amplitudes.
_TRUST = 1.0 / TRUST_FRACTION
# Starts of a fit where the first may mislead.
STARTS = 2

ScanPoint = tuple[Effect, tuple[float, ...]]


@dataclass(frozen=True)
class ScreenedEffect:
    """What the screen predicts of one effect.

    Attributes:
        effect: The effect.
        predicted_gain: By how much ``-2 log p`` falls at its best scan point, if secant and derivatives hold.
        starts: Parameter values to start fits from, best first, one for each scan point.
    """

    effect: Effect
    predicted_gain: float
    starts: tuple[dict[str, float], ...]


@dataclass(frozen=True)
class ScreenedPair:
    """What the screen predicts of two effects together.

    Attributes:
        effects: The effects.
        predicted_gain: By how much ``-2 log p`` falls.
        start: Parameter values to start a fit from.
        predicted_gap: E that is left.
    """

    effects: tuple[Effect, Effect]
    predicted_gain: float
    start: dict[str, float]
    predicted_gap: float


@dataclass(frozen=True)
class Scan:
    """Every scan point of every effect, simulated at a fit.

    Attributes:
        problem: The problem.
        base: The fit.
        points: P scan points.
        changes: (P, N) change of the simulation by each.
        cost: ``-2 log p`` of the fit.
        views: Residual and changes, whitened with and without the discrepancy.
    """

    problem: Problem = field(repr=False)
    base: Fit = field(repr=False)
    points: list[ScanPoint]
    changes: Array = field(repr=False)
    cost: float
    views: tuple[_View, ...] = field(repr=False)


@dataclass(frozen=True)
class _View:
    """Whitened residual (N,) and rows (p + P, N): Jacobian of the freed parameters, then changes."""

    white: Array
    rows: Array

    @cached_property
    def inner(self) -> Array:
        """(p + P, p + P) inner products of the rows."""
        return self.rows @ self.rows.T

    @cached_property
    def along(self) -> Array:
        """(p + P,) inner products of the rows with the residual."""
        return self.rows @ self.white


def scan_effects(problem: Problem, base: Fit, effects: Sequence[Effect]) -> Scan:
    """Simulate every scan point of the effects at a fit."""
    points = [(effect, point) for effect in effects for point in effect.scan]
    if not points:
        return Scan(problem, base, [], np.empty((0, problem.size)), 0.0, ())
    changes = scan_changes(problem, base.values, base.simulated, points, problem.options.fidelity)
    rows = np.vstack([base.jacobian, changes])
    views = [problem.whitened(base.residual, rows, base.discrepancy, robust) for robust in (True, False)]
    cost = problem.cost(base.residual)[0]
    return Scan(problem, base, points, changes, cost, tuple(_View(white, through) for white, through in views))


def scan_changes(
    problem: Problem, values: Values, simulated: Array, points: Sequence[ScanPoint], least_fidelity: int
) -> Array:
    """(P, N) change of the simulation by each scan point, in the cheapest simulation that shows its effect.

    A point that cannot be simulated shows nothing: its change is 0.

    Args:
        problem: The problem.
        values: Parameter values that the points are added to.
        simulated: (N,) simulation at these values, as the problem has it.
        points: P scan points.
        least_fidelity: Fidelity that shows what is in the values.
    """
    changes = np.empty((len(points), problem.size))
    needed = [max(effect.fidelity, least_fidelity) for effect, _ in points]
    for fidelity in sorted(set(needed)):
        own = [index for index, own_fidelity in enumerate(needed) if own_fidelity == fidelity]
        sets = [dict(values) | points[index][0].values(points[index][1]) for index in own]
        if fidelity == problem.options.fidelity:
            changes[own] = problem.simulate(sets) - simulated
        else:
            without, *with_it = problem.simulate([values, *sets], replace(problem.options, fidelity=fidelity))
            changes[own] = np.array(with_it) - without
    changes[~np.isfinite(changes).all(axis=1)] = 0.0
    return changes


def screen(scan: Scan) -> list[ScreenedEffect]:
    """What the scan predicts of every effect, largest gain first."""
    by_effect: dict[str, dict[tuple[float, ...], tuple[float, dict[str, float]]]] = {}
    effects = {effect.name: effect for effect, _ in scan.points}
    for view in scan.views:
        for index, (effect, point) in enumerate(scan.points):
            gain, start, _ = _predict(scan, view, [effect], (index,))
            by_point = by_effect.setdefault(effect.name, {})
            if gain > by_point.get(point, (-np.inf, {}))[0]:
                by_point[point] = gain, start
    screened = []
    for name, by_point in by_effect.items():
        ordered = sorted(by_point.values(), key=lambda entry: -entry[0])
        screened.append(ScreenedEffect(effects[name], ordered[0][0], tuple(start for _, start in ordered)))
    return sorted(screened, key=lambda each: -each.predicted_gain)


def rank_starts(scan: Scan, screened: ScreenedEffect) -> list[tuple[dict[str, float], Array]]:
    """The starts of an effect and their simulations (N,), cheapest first: a simulation checks the prediction."""
    problem = scan.problem.at_fidelity_of((screened.effect,))
    starts = list(zip(screened.starts, problem.simulate(screened.starts), strict=True))
    return sorted(starts, key=lambda start: penalized_cost(problem, scan.base.parameters, *start))


def screen_pairs(scan: Scan, most: int, threshold: float) -> list[ScreenedPair]:
    """The most promising pairs of effects, each within its physical range, without further simulations.

    Two effects that make up for each other, or hide each other, predict nothing one by one.

    Args:
        scan: The scan.
        most: Largest number of pairs.
        threshold: E to reach. A pair that is predicted to leave more, by more than a prediction may be wrong, is
            dropped.

    Returns:
        The pairs, largest gain first.
    """
    best: dict[tuple[str, str], ScreenedPair] = {}
    for view in scan.views:
        for first, second in _likely_pairs(scan, view):
            effects = scan.points[first][0].within_physical_range, scan.points[second][0].within_physical_range
            gain, start, gap = _predict(scan, view, effects, (first, second))
            names = effects[0].name, effects[1].name
            if names not in best or gain > best[names].predicted_gain:
                best[names] = ScreenedPair(effects, gain, start, gap)
    ending = [pair for pair in best.values() if TRUST_FRACTION * pair.predicted_gap <= threshold]
    return sorted(ending, key=lambda pair: -pair.predicted_gain)[:most]


def _predict(
    scan: Scan, view: _View, effects: Sequence[Effect], indices: Sequence[int]
) -> tuple[float, dict[str, float], float]:
    """Predicted gain of ``-2 log p`` with these scan points of the effects, the start of a fit, and E that is left."""
    problem, base = scan.problem, scan.base
    count = len(base.parameters)
    own = [*range(count), *(count + index for index in indices)]
    points = [(effect, scan.points[index][1]) for effect, index in zip(effects, indices, strict=True)]
    step = _bounded_step_of(base, points, view.inner[np.ix_(own, own)], view.along[own])
    change = step[:count] @ base.jacobian + step[count:] @ scan.changes[list(indices)]
    residual = problem.residual_of(base.simulated + change)
    gap = float(np.sqrt(np.mean(residual**2)))
    return scan.cost - problem.cost(residual)[0], _start_of(base, points, step), gap


def _likely_pairs(scan: Scan, view: _View) -> list[tuple[int, int]]:
    """For every two effects, the pair of scan points that leaves least of the whitened residual.

    Least squares in two unknowns, the multiples of the two changes, for all pairs at once; the freed parameters have
    been eliminated. Each multiple stays within the reach of its secant.
    """
    count = len(scan.base.parameters)
    prior = np.diag(prior_weights(scan.base.parameters) ** 2 + 1e-9)
    freed, rows = view.rows[:count], view.rows[count:]
    solved = np.linalg.solve(freed @ freed.T + prior, freed @ np.column_stack([rows.T, view.white]))
    rows = rows - solved[:, :-1].T @ freed
    white = view.white - solved[:, -1] @ freed
    inner, along = rows @ rows.T, rows @ white
    power = np.maximum(np.diag(inner), 1e-12)
    determinant = np.outer(power, power) - inner**2
    # Two changes that are nearly parallel make no pair.
    independent = determinant > 1e-9 * np.outer(power, power)
    low, high = np.array([_secant_range(effect, point) for effect, point in scan.points]).T
    multiple = (along[:, None] * power - along * inner) / np.where(independent, determinant, 1.0)
    multiple = np.clip(multiple, low[:, None], high[:, None])
    gain = _gain(multiple, along[:, None], power[:, None]) + _gain(multiple.T, along, power)
    gain = np.where(independent, gain - 2.0 * multiple * multiple.T * inner, 0.0)
    best: dict[tuple[str, str], tuple[float, int, int]] = {}
    for first in range(len(scan.points)):
        for second in range(first + 1, len(scan.points)):
            names = scan.points[first][0].name, scan.points[second][0].name
            if names[0] != names[1] and gain[first, second] > best.get(names, (0.0, 0, 0))[0]:
                best[names] = float(gain[first, second]), first, second
    return [(first, second) for _, first, second in best.values()]


def _gain(multiple: Array, along: Array, power: Array) -> Array:
    """Reduction of the squared residual by a multiple of a change, from their inner product and the change's square."""
    return np.asarray(2.0 * multiple * along - multiple**2 * power, dtype=np.float64)


def _bounded_step_of(base: Fit, points: Sequence[ScanPoint], inner: Array, along: Array) -> Array:
    """(p + e,) step that leaves least: nuisance in scales, then multiples of the scan points' changes, bounded.

    Args:
        base: The fit.
        points: The e scan points.
        inner: (p + e, p + e) inner products of the whitened rows of the freed parameters and the points.
        along: (p + e,) inner products of these with the whitened residual.
    """
    low, high = distance_to_bounds(base.parameters, base.values)
    none = np.zeros(len(points))
    prior = np.append(prior_weights(base.parameters), none) ** 2
    normal = inner + np.diag(prior)
    gradient = along - prior * np.append(scaled_offsets(base.parameters, base.values), none)
    ranges = [_secant_range(effect, point) for effect, point in points]
    lowest = np.append(np.maximum(low, -_TRUST), [own[0] for own in ranges])
    highest = np.append(np.minimum(high, _TRUST), [own[1] for own in ranges])
    return bounded_step(normal, gradient, 0.0, lowest, highest)


def _secant_range(effect: Effect, point: tuple[float, ...]) -> tuple[float, float]:
    """Smallest and largest multiple of a scan point's amplitude for which its secant holds.

    It reaches to the neighbouring scan points of the same shape, and beyond the outermost ones as far as it is trusted.
    """
    amplitude = effect.parameters[0]
    own = point[0] - amplitude.nominal
    others = [other[0] - amplitude.nominal for other in effect.scan if other[1:] == point[1:]]
    multiples = [other / own for other in others if other / own > 0.0]
    lowest = -_TRUST if amplitude.lower < amplitude.nominal < amplitude.upper else 0.0
    below = max((m for m in multiples if m < 1.0), default=lowest)
    return below, min((m for m in multiples if m > 1.0), default=_TRUST)


def _start_of(base: Fit, points: Sequence[ScanPoint], step: Array) -> dict[str, float]:
    """Parameter values after the step; amplitudes stay away from neutral and from their bounds."""
    start, count = dict(base.values), len(base.parameters)
    for parameter, move in zip(base.parameters, step[:count], strict=True):
        moved = start.get(parameter.name, parameter.nominal) + parameter.scale * float(move)
        start[parameter.name] = float(np.clip(moved, parameter.lower, parameter.upper))
    for (effect, point), multiple in zip(points, step[count:], strict=True):
        amplitude = effect.parameters[0]
        trusted = float(multiple) if abs(multiple) >= TRUST_FRACTION else TRUST_FRACTION
        margin = _MARGIN * (amplitude.upper - amplitude.lower)
        size = amplitude.nominal + trusted * (point[0] - amplitude.nominal)
        size = float(np.clip(size, amplitude.lower + margin, amplitude.upper - margin))
        start |= effect.values((point[0] if size == amplitude.nominal else size, *point[1:]))
    return start
