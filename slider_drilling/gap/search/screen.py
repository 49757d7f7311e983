"""Where fits of an effect begin: what each scan point promises, before any of them is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.model import Array, Effect
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit

# A secant is trusted between a quarter of the scan's amplitude and three times it.
_SHORTEST, _LONGEST = 0.25, 3.0
_MARGIN = 0.02


@dataclass(frozen=True)
class Candidate:
    """promise: by how much ``-2 log p`` falls if the best point keeps what its secant says; starts: full parameter
    values to begin fits from, most promising first.
    """

    effect: Effect
    promise: float
    starts: tuple[dict[str, float], ...]


def screen(problem: Problem, base: Fit, effects: Sequence[Effect]) -> list[Candidate]:
    """Score every effect at a fit, most promising first.

    Each scan point is simulated once; what of its change the freed parameters cannot make up for is laid against the
    residual. The secant replaces the derivative at neutral, which for a dead zone, or a friction that depends on
    direction, says nothing about the size that matters.
    """
    points = [(effect, point) for effect in effects for point in effect.scan]
    if not points:
        return []
    changes = problem.simulate([base.values | effect.values(point) for effect, point in points]) - base.simulated
    scored: dict[str, list[tuple[float, float, tuple[float, ...]]]] = {effect.name: [] for effect in effects}
    for forgiving in (True, False):
        rest, beyond = _projected(problem, base, changes, forgiving)
        for (effect, point), change in zip(points, beyond, strict=True):
            multiple, gain = _along(effect, change, rest)
            scored[effect.name].append((gain, multiple, point))
    found = []
    for effect in effects:
        ordered = sorted(scored[effect.name], key=lambda entry: -entry[0])
        places = dict.fromkeys((multiple, point) for _, multiple, point in ordered)
        first: dict[tuple[float, ...], dict[str, float]] = {}
        for multiple, point in places:
            first.setdefault(point, base.values | _start(effect, point, multiple))
        found.append(Candidate(effect, ordered[0][0], tuple(first.values())))
    return sorted(found, key=lambda candidate: -candidate.promise)


def _projected(problem: Problem, base: Fit, changes: Array, forgiving: bool) -> tuple[Array, Array]:
    """Whitened residual (N,) and changes (M, N) without what the base's own parameters can make up for."""
    rows = np.vstack([base.jacobian, changes])
    white, rows = problem.whitened(base.residual, rows, base.discrepancy, forgiving)
    own = len(base.parameters)
    basis, _ = np.linalg.qr(rows[:own].T)
    return white - basis @ (basis.T @ white), rows[own:] - (rows[own:] @ basis) @ basis.T


def _along(effect: Effect, change: Array, rest: Array) -> tuple[float, float]:
    """(multiple of the change that fits best, fall of the squares with it), the multiple within its bounds."""
    length = float(change @ change)
    if length <= 1e-12:
        return 1.0, 0.0
    amplitude = effect.parameters[0]
    both_ways = amplitude.lower < amplitude.nominal < amplitude.upper
    overlap = float(change @ rest)
    multiple = float(np.clip(overlap / length, -_LONGEST if both_ways else 0.0, _LONGEST))
    return multiple, 2.0 * multiple * overlap - multiple**2 * length


def _start(effect: Effect, point: tuple[float, ...], multiple: float) -> dict[str, float]:
    """The scan point at the amplitude that the secant asks for, off neutral and off the bounds."""
    amplitude = effect.parameters[0]
    multiple = multiple if abs(multiple) >= _SHORTEST else _SHORTEST
    margin = _MARGIN * (amplitude.upper - amplitude.lower)
    size = amplitude.nominal + multiple * (point[0] - amplitude.nominal)
    size = float(np.clip(size, amplitude.lower + margin, amplitude.upper - margin))
    return effect.values((point[0] if size == amplitude.nominal else size, *point[1:]))
