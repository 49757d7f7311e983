"""The score test: how much of the tuned model's residual each effect could explain, before any of them is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from slider_drilling.gap.fit import Fit, prior_rows
from slider_drilling.gap.model import Array, Effect
from slider_drilling.gap.residuals import Problem

# How far beyond a scan point its secant is trusted when it predicts a start.
_LONGEST = 3.0
_BATCH = 32
_SLACK = 1e-6


@dataclass(frozen=True)
class Candidate:
    """An effect as the score test sees it.

    predicted: robust E^2 that the best scan point promises once the nuisance follows; promise: by how much that is less
    than what the nuisance promises alone; starts: parameter values (nuisance included) to begin fits from, most
    promising first; points: the effect's own values there as scanned.
    """

    effect: Effect
    predicted: float
    promise: float
    starts: tuple[dict[str, float], ...]
    points: tuple[dict[str, float], ...]


def screen(problem: Problem, fit: Fit, effects: Sequence[Effect]) -> list[Candidate]:
    """Score every effect at the fit, best first.

    Each scan point is simulated once; its change of the residual, with what the nuisance Jacobian spans projected
    out, is laid against the residual. The secant replaces the derivative at neutral, which for a dead zone or a
    friction that depends on direction says nothing about the size that matters.
    """
    points = [(effect, point) for effect in effects for point in effect.scan]
    changes = _changes(problem, fit, points)
    scored: dict[str, list[tuple[float, dict[str, float], dict[str, float]]]] = {e.name: [] for e in effects}
    weight = problem.reweighted(fit.residual)
    rows = weight[:, None] * fit.jacobian
    prior = np.diag(prior_rows(fit.parameters))
    alone, _ = _project(weight, rows, prior, fit, np.zeros_like(weight), 0.0)
    without = problem.robust_gap(fit.residual + fit.jacobian @ alone)
    for (effect, point), change in zip(points, changes, strict=True):
        amplitude = effect.parameters[0]
        shortest = -_LONGEST if amplitude.lower < amplitude.nominal < amplitude.upper else 0.0
        step, length = _project(weight, rows, prior, fit, change, shortest)
        predicted = fit.residual + fit.jacobian @ step + length * change
        start = _start(fit, effect, point, step, length)
        scored[effect.name].append((problem.robust_gap(predicted), start, effect.values(point)))
    found = []
    for effect in effects:
        ordered = sorted(scored[effect.name], key=lambda entry: entry[0])
        starts, scanned = tuple(entry[1] for entry in ordered), tuple(entry[2] for entry in ordered)
        predicted = ordered[0][0]
        found.append(Candidate(effect, predicted, without - predicted, starts, scanned))
    return sorted(found, key=lambda candidate: candidate.predicted)


def _changes(problem: Problem, fit: Fit, points: Sequence[tuple[Effect, tuple[float, ...]]]) -> Array:
    """(K, N) change of the residual when each effect is switched on at each point."""
    changes = np.empty((len(points), problem.time.size))
    for begin in range(0, len(points), _BATCH):
        part = points[begin : begin + _BATCH]
        simulated = problem.simulate([fit.values, *(fit.values | effect.values(point) for effect, point in part)])
        changes[begin : begin + len(part)] = simulated[0] - simulated[1:]
    return changes


def _project(weight: Array, rows: Array, prior: Array, fit: Fit, change: Array, shortest: float) -> tuple[Array, float]:
    """Nuisance step (scaled) and multiple of the change that together leave least, both within their bounds.

    The multiple is kept in [shortest, 3]; a negative one is the effect with the other sign, allowed where the
    amplitude's range has one, so that a shape that no physical size of the effect has is still seen. A nuisance
    that stands at its bound cannot take over what the effect would do beyond it.
    """
    left = np.vstack([np.column_stack([rows, weight * change]), np.column_stack([prior, np.zeros(len(prior))])])
    right = np.concatenate([-weight * fit.residual, np.zeros(len(prior))])
    triangle: Array = np.asarray(np.linalg.qr(np.column_stack([left, right]), mode="r"))
    here = np.array([fit.values[p.name] for p in fit.parameters])
    scale = np.array([p.scale for p in fit.parameters])
    low = np.append((np.array([p.lower for p in fit.parameters]) - here) / scale - _SLACK, shortest - _SLACK)
    high = np.append((np.array([p.upper for p in fit.parameters]) - here) / scale + _SLACK, _LONGEST)
    size = low.size
    solution = lsq_linear(triangle[:size, :size], triangle[:size, size], (low, high)).x
    return solution[:-1], float(solution[-1])


def _start(fit: Fit, effect: Effect, point: tuple[float, ...], step: Array, length: float) -> dict[str, float]:
    """Where the projection says the fit should begin; the amplitude keeps at least a quarter of the scan's."""
    start = dict(fit.values)
    for parameter, move in zip(fit.parameters, step, strict=True):
        moved = start[parameter.name] + parameter.scale * float(np.clip(move, -4.0, 4.0))
        start[parameter.name] = float(np.clip(moved, parameter.lower, parameter.upper))
    amplitude = effect.parameters[0]
    multiple = length if abs(length) >= 0.25 else 0.25
    size = amplitude.nominal + multiple * (point[0] - amplitude.nominal)
    margin = 0.02 * (amplitude.upper - amplitude.lower)
    size = float(np.clip(size, amplitude.lower + margin, amplitude.upper - margin))
    if size == amplitude.nominal:
        size = point[0]
    return start | effect.values((size, *point[1:]))
