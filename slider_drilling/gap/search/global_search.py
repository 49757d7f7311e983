"""A search over a box, for where no scan point is near: many points, then populations that adapt (CMA-ES).

What swings by itself is out of phase wherever one of its causes is wrong, and the more so the longer it swings: all
points far from the truth are then alike. So the search begins on the first part of every run, with many populations,
and only the best of them ever see the whole. The last generations are of simulations that show what is searched for:
a phase hangs on the mesh as on everything else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import qmc

from slider_drilling.gap.model import CanTruncate, Values
from slider_drilling.gap.problem.problem import Problem, build_problem

_POINTS, _BATCH = 512, 64
_POPULATION, _SPREAD = 24, 0.2


@dataclass(frozen=True)
class _Rung:
    """share: of every run; populations: that are followed; generations: of each; cheap: whether any simulation does."""

    share: float
    populations: int
    generations: int
    cheap: bool = True


_RUNGS = (_Rung(0.5, 8, 15), _Rung(0.75, 4, 15), _Rung(1.0, 2, 60), _Rung(1.0, 2, 15, cheap=False))
_CostsOf = Callable[[np.ndarray], list[float]]


def global_search(
    problem: Problem, shows: Problem, spans: Mapping[str, tuple[float, float]], fixed: Values, seed: int
) -> list[dict[str, float]]:
    """The best parameter values found within spans (low, high by name), one of each population, cheapest first.

    shows: the same problem in simulations that show what is searched for; fixed: values of everything else. Same seed,
    same answer.
    """
    low, high = np.array([span[0] for span in spans.values()]), np.array([span[1] for span in spans.values()])

    def values(row: np.ndarray) -> dict[str, float]:
        inside = low + (high - low) * np.clip(row, 0.0, 1.0)
        return dict(fixed) | {name: float(value) for name, value in zip(spans, inside, strict=True)}

    populations: list[Any] = []
    for rung in _RUNGS:
        part = _first(problem if rung.cheap else shows, rung.share)

        def costs(rows: np.ndarray, part: Problem = part) -> list[float]:
            return _costs(part, [values(row) for row in rows])

        if populations:
            populations = _best(populations, costs)[: rung.populations]
        else:
            populations = _scattered(costs, len(spans), rung.populations, seed)
        for population in populations:
            _evolve(population, costs, rung.generations)
    return [values(np.asarray(population.result.xfavorite)) for population in _best(populations, costs)]


def _costs(problem: Problem, sets: Sequence[Values]) -> list[float]:
    """``-2 log p`` of each parameter set, infinite where its simulation ends in no numbers."""
    found: list[float] = []
    for begin in range(0, len(sets), _BATCH):
        residuals = problem.residuals(sets[begin : begin + _BATCH])
        found += [problem.cost(one)[0] if np.isfinite(one).all() else float("inf") for one in residuals]
    return found


def _first(problem: Problem, share: float) -> Problem:
    """The problem of the first share of every run; the whole one where the model cannot be shortened."""
    if share >= 1.0 or not isinstance(problem.model, CanTruncate):
        return problem
    noise: list[dict[str, float]] = [{} for _ in problem.model.runs]
    for piece in problem.pieces:
        noise[piece.run][piece.name] = piece.noise
    return build_problem(problem.model.truncated(share), noise, problem.options, problem.counter)


def _scattered(costs_of: _CostsOf, dimensions: int, number: int, seed: int) -> list[Any]:
    """Populations about the cheapest of points spread over the unit box."""
    import cma

    unit = qmc.Sobol(dimensions, seed=seed).random(_POINTS)
    found = []
    for place, index in enumerate(np.argsort(costs_of(unit))[:number]):
        options = {"bounds": [0.0, 1.0], "popsize": _POPULATION, "verbose": -9, "seed": seed + place + 1}
        found.append(cma.CMAEvolutionStrategy(unit[index], _SPREAD, options))
    return found


def _evolve(population: Any, costs_of: _CostsOf, generations: int) -> None:
    for _ in range(generations):
        if population.stop():
            return
        rows = population.ask()
        population.tell(rows, costs_of(np.array(rows)))


def _best(populations: Sequence[Any], costs_of: _CostsOf) -> list[Any]:
    """Cheapest first, each where its middle is: what was cheap on a part need not be on more of it."""
    found = costs_of(np.array([np.asarray(population.result.xfavorite) for population in populations]))
    return [populations[index] for index in np.argsort(found)]
