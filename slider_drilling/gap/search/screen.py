"""Where fits of an effect begin: what each scan point promises, before any of them is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.gap.model import Array, Effect, Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, bounded_step, prior_weights, room

# A secant is trusted from the scan's amplitude by this factor to as many times it, a nuisance's derivative for as many
# of its scales.
_TRUSTED = 4.0
_MARGIN = 0.02
# Places that fits begin from where the first may mislead.
STARTS = 2


@dataclass(frozen=True)
class Candidate:
    """promise: by how much ``-2 log p`` falls at the best point if its secant and the nuisance's derivatives hold;
    starts: parameter values to begin fits from, most promising first, one a scan point.
    """

    effect: Effect
    promise: float
    starts: tuple[dict[str, float], ...]


def screen(problem: Problem, base: Fit, effects: Sequence[Effect]) -> list[Candidate]:
    """Score every effect at a fit, most promising first.

    Each scan point is simulated once. The secant replaces the derivative at neutral, which for a dead zone, or a
    friction that depends on direction, says nothing about the size that matters; the freed parameters follow.
    """
    points = [(effect, point) for effect in effects for point in effect.scan]
    if not points:
        return []
    changes = changes_of(problem, base.values, base.simulated, points, problem.how.fidelity)
    now = problem.cost(base.residual)[0]
    scored: dict[str, dict[tuple[float, ...], tuple[float, dict[str, float]]]] = {e.name: {} for e in effects}
    for forgiving in (True, False):
        rows = np.vstack([base.jacobian, changes])
        white, through = problem.whitened(base.residual, rows, base.discrepancy, forgiving)
        for index, (effect, point) in enumerate(points):
            own = [*range(len(base.parameters)), len(base.parameters) + index]
            step = _step(base, effect, through[own], white)
            left = problem.against_log(base.simulated + step @ rows[own])
            promise = now - problem.cost(left)[0]
            if promise > scored[effect.name].get(point, (-np.inf, {}))[0]:
                scored[effect.name][point] = promise, _start(base, effect, point, step)
    found = []
    for effect in effects:
        ordered = sorted(scored[effect.name].values(), key=lambda entry: -entry[0])
        found.append(Candidate(effect, ordered[0][0], tuple(start for _, start in ordered)))
    return sorted(found, key=lambda candidate: -candidate.promise)


def changes_of(
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
        if asked == problem.how.fidelity:
            changes[own] = problem.simulate(sets) - simulated
        else:
            without, *with_it = problem.simulate([values, *sets], replace(problem.how, fidelity=asked))
            changes[own] = np.array(with_it) - without
    return changes


def _step(base: Fit, effect: Effect, rows: Array, white: Array) -> Array:
    """(p + 1,) nuisance step in scales and multiple of the effect's change that together leave least, bounded."""
    here = np.array([base.values.get(p.name, p.nominal) for p in base.parameters])
    scale = np.array([p.scale for p in base.parameters])
    low, high = room(base.parameters, base.values)
    amplitude = effect.parameters[0]
    both_ways = amplitude.lower < amplitude.nominal < amplitude.upper
    prior = np.append(prior_weights(base.parameters), 0.0) ** 2
    nominal = np.array([p.nominal for p in base.parameters])
    normal = rows @ rows.T + np.diag(prior)
    gradient = rows @ white - prior * np.append((here - nominal) / scale, 0.0)
    lowest = np.append(np.maximum(low, -_TRUSTED), -_TRUSTED if both_ways else 0.0)
    highest = np.append(np.minimum(high, _TRUSTED), _TRUSTED)
    return bounded_step(normal, gradient, 0.0, lowest, highest)


def _start(base: Fit, effect: Effect, point: tuple[float, ...], step: Array) -> dict[str, float]:
    """The base moved as asked for, and the scan point at its amplitude, off neutral and off the bounds."""
    start = dict(base.values)
    for parameter, move in zip(base.parameters, step[:-1], strict=True):
        moved = start.get(parameter.name, parameter.nominal) + parameter.scale * float(move)
        start[parameter.name] = float(np.clip(moved, parameter.lower, parameter.upper))
    amplitude, multiple = effect.parameters[0], float(step[-1])
    multiple = multiple if abs(multiple) >= 1.0 / _TRUSTED else 1.0 / _TRUSTED
    margin = _MARGIN * (amplitude.upper - amplitude.lower)
    size = amplitude.nominal + multiple * (point[0] - amplitude.nominal)
    size = float(np.clip(size, amplitude.lower + margin, amplitude.upper - margin))
    return start | effect.values((point[0] if size == amplitude.nominal else size, *point[1:]))
