"""A global search over a box, for where no scan point leads: many points, then populations that adapt (CMA-ES).

In a self-excited oscillation the phase is wrong wherever one of its causes is wrong, the more so the longer it runs:
all points far from the truth then look alike. The search therefore starts on the first part of every run, with many
populations, and only the best of them see the whole. The last generations use simulations fine enough to show what is
searched for, since the phase depends on the mesh too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import qmc

from slider_drilling.gap.model import CanTruncate, Values
from slider_drilling.gap.problem.problem import Problem, build_problem

# Points of the first search, and parameter sets simulated together.
_POINTS, _BATCH = 512, 64
# Members of a population, and its first standard deviation in the unit box.
_POPULATION, _SPREAD = 24, 0.2


@dataclass(frozen=True)
class _Round:
    """One round of the search.

    Attributes:
        fraction: First part of every run that is simulated.
        populations: How many are kept.
        generations: Of each population.
        cheap: Whether the cheapest simulation is used.
    """

    fraction: float
    populations: int
    generations: int
    cheap: bool = True


_ROUNDS = (_Round(0.5, 8, 15), _Round(0.75, 4, 15), _Round(1.0, 2, 60), _Round(1.0, 2, 15, cheap=False))
_CostsOf = Callable[[np.ndarray], list[float]]


def global_search(
    problem: Problem, fine: Problem, spans: Mapping[str, tuple[float, float]], fixed: Values, seed: int
) -> list[dict[str, float]]:
    """Search the spans for the least cost.

    Args:
        problem: The problem in cheap simulations.
        fine: The same problem in simulations that show what is searched for.
        spans: Lower and upper end by parameter.
        fixed: Values of all other parameters.
        seed: The same seed gives the same result.

    Returns:
        The best parameter values of each remaining population, cheapest first.
    """
    low, high = np.array([span[0] for span in spans.values()]), np.array([span[1] for span in spans.values()])

    def values(row: np.ndarray) -> dict[str, float]:
        inside = low + (high - low) * np.clip(row, 0.0, 1.0)
        return dict(fixed) | {name: float(value) for name, value in zip(spans, inside, strict=True)}

    populations: list[Any] = []
    for stage in _ROUNDS:
        part = first_part(problem if stage.cheap else fine, stage.fraction)

        def costs(rows: np.ndarray, part: Problem = part) -> list[float]:
            return _costs(part, [values(row) for row in rows])

        if populations:
            populations = _best(populations, costs)[: stage.populations]
        else:
            populations = _first_populations(costs, len(spans), stage.populations, seed)
        for population in populations:
            _evolve(population, costs, stage.generations)
    return [values(np.asarray(population.result.xfavorite)) for population in _best(populations, costs)]


def _costs(problem: Problem, sets: Sequence[Values]) -> list[float]:
    """``-2 log p`` of each parameter set, infinite where its simulation is not finite."""
    costs: list[float] = []
    for begin in range(0, len(sets), _BATCH):
        residuals = problem.residuals(sets[begin : begin + _BATCH])
        costs += [problem.cost(each)[0] if np.isfinite(each).all() else float("inf") for each in residuals]
    return costs


def first_part(problem: Problem, fraction: float) -> Problem:
    """The problem of the first part of every run; the whole one where the model cannot be truncated."""
    if fraction >= 1.0 or not isinstance(problem.model, CanTruncate):
        return problem
    noise: list[dict[str, float]] = [{} for _ in problem.model.runs]
    for piece in problem.pieces:
        noise[piece.run][piece.name] = piece.noise
    first = build_problem(problem.model.truncated(fraction), noise, problem.options, problem.counter)
    return replace(first, white_discrepancy=problem.white_discrepancy)


def _first_populations(costs_of: _CostsOf, dimensions: int, number: int, seed: int) -> list[Any]:
    """Populations around the cheapest of points spread over the unit box."""
    import cma

    unit = qmc.Sobol(dimensions, seed=seed).random(_POINTS)
    populations = []
    for rank, index in enumerate(np.argsort(costs_of(unit))[:number]):
        options = {"bounds": [0.0, 1.0], "popsize": _POPULATION, "verbose": -9, "seed": seed + rank + 1}
        populations.append(cma.CMAEvolutionStrategy(unit[index], _SPREAD, options))
    return populations


def _evolve(population: Any, costs_of: _CostsOf, generations: int) -> None:
    """Evolve a population in place."""
    for _ in range(generations):
        if population.stop():
            return
        rows = population.ask()
        population.tell(rows, costs_of(np.array(rows)))


def _best(populations: Sequence[Any], costs_of: _CostsOf) -> list[Any]:
    """Populations by the cost of their centres: what was cheap on a part need not be on more of the run."""
    costs = costs_of(np.array([np.asarray(population.result.xfavorite) for population in populations]))
    return [populations[index] for index in np.argsort(costs)]
