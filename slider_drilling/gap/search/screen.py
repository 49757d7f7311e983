"""Where fits of an effect begin: what each scan point promises, before any of them is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

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

_MARGIN = 0.02
# A derivative is trusted for so many of a nuisance's scales, a secant for so many times the scan's amplitude.
_FAR = 1.0 / TRUST_FRACTION
# Places that fits begin from where the first may mislead.
STARTS = 2


@dataclass(frozen=True)
class ScreenedEffect:
    """promise: by how much ``-2 log p`` falls at the best point if its secant and the nuisance's derivatives hold;
    starts: parameter values to begin fits from, most promising first, one a scan point.
    """

    effect: Effect
    predicted_gain: float
    starts: tuple[dict[str, float], ...]


@dataclass(frozen=True)
class ScreenedPair:
    """Two effects at once; promise, start: as `Candidate` has them; left: E that the same forecast leaves."""

    effects: tuple[Effect, Effect]
    predicted_gain: float
    start: dict[str, float]
    predicted_gap: float


@dataclass(frozen=True)
class Scan:
    """Every scan point of every effect, simulated once at a fit (base) of a problem.

    points: which they are; changes: (P, N) what each changes; now: ``-2 log p`` without any; views: the changes as the
    likelihood sees them.
    """

    problem: Problem = field(repr=False)
    base: Fit = field(repr=False)
    points: list[tuple[Effect, tuple[float, ...]]]
    changes: Array = field(repr=False)
    cost: float
    views: tuple[_View, ...] = field(repr=False)


def screen(scan: Scan) -> list[ScreenedEffect]:
    """Score every effect of a scan, most promising first.

    The secant replaces the derivative at neutral, which for a dead zone, or a friction that depends on direction, says
    nothing about the size that matters; the freed parameters follow.
    """
    scored: dict[str, dict[tuple[float, ...], tuple[float, dict[str, float]]]] = {}
    effects = {effect.name: effect for effect, _ in scan.points}
    for view in scan.views:
        for index, (effect, point) in enumerate(scan.points):
            promise, start, _ = _promised(scan, view, [effect], (index,))
            known = scored.setdefault(effect.name, {})
            if promise > known.get(point, (-np.inf, {}))[0]:
                known[point] = promise, start
    found = []
    for name, by_point in scored.items():
        ordered = sorted(by_point.values(), key=lambda entry: -entry[0])
        found.append(ScreenedEffect(effects[name], ordered[0][0], tuple(start for _, start in ordered)))
    return sorted(found, key=lambda candidate: -candidate.predicted_gain)


def rank_starts(scan: Scan, candidate: ScreenedEffect) -> list[tuple[dict[str, float], Array]]:
    """The candidate's starts and their simulations (N,), by what each leaves: what secants and derivatives promise may
    not be there.
    """
    problem = scan.problem.at_fidelity_of((candidate.effect,))
    begun = list(zip(candidate.starts, problem.simulate(candidate.starts), strict=True))
    return sorted(begun, key=lambda one: penalized_cost(problem, scan.base.parameters, *one))


def screen_pairs(scan: Scan, most: int, enough: float) -> list[ScreenedPair]:
    """The most promising pairs of effects of a scan, each within what its name stands for: at most so many, the best
    first. enough: E that would be; a pair that leaves more of it than a forecast may be wrong by is no such pair.

    By the same secants: what two of them explain together costs no more simulations than what each does alone. Two
    that make up for each other, or hide each other, promise nothing one by one.
    """
    best: dict[tuple[str, str], ScreenedPair] = {}
    for view in scan.views:
        for first, second in _likely_pairs(scan, view):
            chosen = scan.points[first][0].within_physical_range, scan.points[second][0].within_physical_range
            promise, start, left = _promised(scan, view, chosen, (first, second))
            names = chosen[0].name, chosen[1].name
            if names not in best or promise > best[names].predicted_gain:
                best[names] = ScreenedPair(chosen, promise, start, left)
    ending = [pair for pair in best.values() if TRUST_FRACTION * pair.predicted_gap <= enough]
    return sorted(ending, key=lambda pair: -pair.predicted_gain)[:most]


@dataclass(frozen=True)
class _View:
    """white (N,), rows (p + P, N): residual and changes, whitened; the freed parameters' first."""

    white: Array
    rows: Array


def scan_effects(problem: Problem, base: Fit, effects: Sequence[Effect]) -> Scan:
    """Simulate every scan point of the effects at a fit."""
    points = [(effect, point) for effect in effects for point in effect.scan]
    if not points:
        return Scan(problem, base, [], np.empty((0, problem.size)), 0.0, ())
    changes = scan_changes(problem, base.values, base.simulated, points, problem.options.fidelity)
    rows = np.vstack([base.jacobian, changes])
    views = [problem.whitened(base.residual, rows, base.discrepancy, forgiving) for forgiving in (True, False)]
    now = problem.cost(base.residual)[0]
    return Scan(problem, base, points, changes, now, tuple(_View(white, through) for white, through in views))


def _promised(
    scan: Scan, view: _View, effects: Sequence[Effect], chosen: Sequence[int]
) -> tuple[float, dict[str, float], float]:
    """By how much ``-2 log p`` falls with the chosen scan points of the effects, if secants and derivatives hold; where
    a fit would begin; E that is left.
    """
    problem, base = scan.problem, scan.base
    count = len(base.parameters)
    own = [*range(count), *(count + index for index in chosen)]
    points = [(effect, scan.points[index][1]) for effect, index in zip(effects, chosen, strict=True)]
    step = _step(base, points, view.rows[own], view.white)
    change = step[:count] @ base.jacobian + step[count:] @ scan.changes[list(chosen)]
    residual = problem.residual_of(base.simulated + change)
    return scan.cost - problem.cost(residual)[0], _start(base, points, step), float(np.sqrt(np.mean(residual**2)))


def _likely_pairs(scan: Scan, view: _View) -> list[tuple[int, int]]:
    """Of every two effects the pair of scan points that leaves least of the whitened residual, each as far as its
    secant speaks, the freed parameters following.
    """
    count = len(scan.base.parameters)
    prior = np.diag(prior_weights(scan.base.parameters) ** 2 + 1e-9)
    freed, rows = view.rows[:count], view.rows[count:]
    solved = np.linalg.solve(freed @ freed.T + prior, freed @ np.column_stack([rows.T, view.white]))
    rows = rows - solved[:, :-1].T @ freed
    white = view.white - solved[:, -1] @ freed
    inner, along = rows @ rows.T, rows @ white
    power = np.maximum(np.diag(inner), 1e-12)
    inside = np.outer(power, power) - inner**2
    apart = inside > 1e-9 * np.outer(power, power)
    low, high = np.array([_span(effect, point) for effect, point in scan.points]).T
    multiple = (along[:, None] * power - along * inner) / np.where(apart, inside, 1.0)
    multiple = np.clip(multiple, low[:, None], high[:, None])
    gained = _gain(multiple, along[:, None], power[:, None]) + _gain(multiple.T, along, power)
    gained = np.where(apart, gained - 2.0 * multiple * multiple.T * inner, 0.0)
    best: dict[tuple[str, str], tuple[float, int, int]] = {}
    for first in range(len(scan.points)):
        for second in range(first + 1, len(scan.points)):
            names = scan.points[first][0].name, scan.points[second][0].name
            if names[0] != names[1] and gained[first, second] > best.get(names, (0.0, 0, 0))[0]:
                best[names] = float(gained[first, second]), first, second
    return [(first, second) for _, first, second in best.values()]


def _gain(multiple: Array, along: Array, power: Array) -> Array:
    """By how much a residual's square falls with so much of a change, by how far it lies along it, and its square."""
    return np.asarray(2.0 * multiple * along - multiple**2 * power, dtype=np.float64)


def scan_changes(
    problem: Problem, values: Values, simulated: Array, points: Sequence[tuple[Effect, tuple[float, ...]]], least: int
) -> Array:
    """(P, N) what each scan point changes at the values, by the cheapest simulations that show its effect.

    simulated: (N,) at the values, as the problem has it; least: fidelity that shows what is in the values.
    """
    changes = np.empty((len(points), problem.size))
    needed = [max(effect.fidelity, least) for effect, _ in points]
    for asked in sorted(set(needed)):
        own = [index for index, fidelity in enumerate(needed) if fidelity == asked]
        sets = [dict(values) | points[index][0].values(points[index][1]) for index in own]
        if asked == problem.options.fidelity:
            changes[own] = problem.simulate(sets) - simulated
        else:
            without, *with_it = problem.simulate([values, *sets], replace(problem.options, fidelity=asked))
            changes[own] = np.array(with_it) - without
    return changes


def _step(base: Fit, chosen: Sequence[tuple[Effect, tuple[float, ...]]], rows: Array, white: Array) -> Array:
    """(p + e,) nuisance step in scales and multiples of the scan points' changes that together leave least, bounded."""
    low, high = distance_to_bounds(base.parameters, base.values)
    none = np.zeros(len(chosen))
    prior = np.append(prior_weights(base.parameters), none) ** 2
    normal = rows @ rows.T + np.diag(prior)
    gradient = rows @ white - prior * np.append(scaled_offsets(base.parameters, base.values), none)
    spans = [_span(effect, point) for effect, point in chosen]
    lowest = np.append(np.maximum(low, -_FAR), [span[0] for span in spans])
    highest = np.append(np.minimum(high, _FAR), [span[1] for span in spans])
    return bounded_step(normal, gradient, 0.0, lowest, highest)


def _span(effect: Effect, point: tuple[float, ...]) -> tuple[float, float]:
    """Multiples of a scan point's amplitude that its secant speaks for: as far as the next points of the same shape,
    beyond the first and the last of them as far as one is trusted.
    """
    amplitude = effect.parameters[0]
    own = point[0] - amplitude.nominal
    others = [other[0] - amplitude.nominal for other in effect.scan if other[1:] == point[1:]]
    multiples = [other / own for other in others if other / own > 0.0]
    neutral = -_FAR if amplitude.lower < amplitude.nominal < amplitude.upper else 0.0
    return max((m for m in multiples if m < 1.0), default=neutral), min((m for m in multiples if m > 1.0), default=_FAR)


def _start(base: Fit, chosen: Sequence[tuple[Effect, tuple[float, ...]]], step: Array) -> dict[str, float]:
    """The base moved as asked for, and the scan points at their amplitudes, off neutral and off the bounds."""
    start, count = dict(base.values), len(base.parameters)
    for parameter, move in zip(base.parameters, step[:count], strict=True):
        moved = start.get(parameter.name, parameter.nominal) + parameter.scale * float(move)
        start[parameter.name] = float(np.clip(moved, parameter.lower, parameter.upper))
    for (effect, point), multiple in zip(chosen, step[count:], strict=True):
        amplitude = effect.parameters[0]
        trusted = float(multiple) if abs(multiple) >= TRUST_FRACTION else TRUST_FRACTION
        margin = _MARGIN * (amplitude.upper - amplitude.lower)
        size = amplitude.nominal + trusted * (point[0] - amplitude.nominal)
        size = float(np.clip(size, amplitude.lower + margin, amplitude.upper - margin))
        start |= effect.values((point[0] if size == amplitude.nominal else size, *point[1:]))
    return start
