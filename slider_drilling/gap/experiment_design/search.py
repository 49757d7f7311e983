"""An evolution strategy over the numbers of a programme: few evaluations, many numbers, no derivatives.

A (1, lambda) strategy with elitism: each generation changes some of the best point's numbers, and the step follows the
rule of one success in five (Rechenberg 1973; Beyer and Schwefel, Natural Computing 1, 2002).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import exp

import numpy as np

from slider_drilling.gap.model import Array, Parameter, Values
from slider_drilling.process.parallel_map import parallel_map

_GENERATION = 6
# Share of the numbers that a trial changes, and first and last standard deviation in their ranges.
_CHANGED, _FIRST_STEP, _LEAST_STEP = 0.35, 0.25, 0.03


@dataclass(frozen=True)
class Found:
    """The best point of a search.

    Attributes:
        values: The point.
        loss: Its loss.
        evaluations: Number of points that were evaluated.
    """

    values: dict[str, float]
    loss: float
    evaluations: int


def minimise(
    loss: Callable[[Values], float],
    variables: Sequence[Parameter],
    starts: Sequence[Values],
    evaluations: int,
    seed: int,
    report: Callable[[float], None] = lambda share: None,
) -> Found:
    """Search for the point of least loss.

    Args:
        loss: Loss of a point; infinite for one that must not be.
        variables: The numbers and their bounds.
        starts: Points to evaluate first; the search goes on from the best.
        evaluations: Number of points to evaluate, starts included.
        seed: Of the search: the same seed gives the same point.
        report: Called with the share done.
    """
    generator = np.random.default_rng([seed, 55])
    low = np.array([variable.lower for variable in variables])
    span = np.array([variable.upper for variable in variables]) - low

    def values_at(point: Array) -> dict[str, float]:
        return {variable.name: float(value) for variable, value in zip(variables, low + span * point, strict=True)}

    points = [
        np.clip(np.array([(start.get(each.name, each.nominal) - each.lower) for each in variables]) / span, 0.0, 1.0)
        for start in starts
    ]
    losses = parallel_map(loss, [values_at(point) for point in points])
    best = int(np.argmin(losses))
    point, least, count, step = points[best], losses[best], len(points), _FIRST_STEP
    while count < evaluations:
        trials = [_mutated(point, step, generator) for _ in range(min(_GENERATION, evaluations - count))]
        outcomes = parallel_map(loss, [values_at(trial) for trial in trials])
        successes = float(np.mean([outcome < least for outcome in outcomes]))
        best = int(np.argmin(outcomes))
        if outcomes[best] < least:
            point, least = trials[best], outcomes[best]
        step = max(step * exp(0.6 * (successes - 0.2)), _LEAST_STEP)
        count += len(trials)
        report(count / evaluations)
    return Found(values_at(point), float(least), count)


def _mutated(point: Array, step: float, generator: np.random.Generator) -> Array:
    """The point with some of its numbers changed, reflected at the bounds."""
    changed = generator.uniform(size=point.size) < _CHANGED
    changed[generator.integers(point.size)] = True
    moved = point + changed * generator.normal(0.0, step, point.size)
    return np.asarray(1.0 - np.abs(1.0 - np.abs(moved) % 2.0))
