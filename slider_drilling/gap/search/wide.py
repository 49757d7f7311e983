"""A search over a box, for where no scan point is near: many points, then a population that adapts (CMA-ES)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.stats import qmc

from slider_drilling.gap.model import Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.screen import STARTS

_POINTS, _BATCH = 512, 64
_POPULATION, _GENERATIONS, _SPREAD = 24, 60, 0.2


def wide(
    problem: Problem, spans: Mapping[str, tuple[float, float]], fixed: Values, seed: int
) -> list[dict[str, float]]:
    """The best parameter values found within spans (low, high by name), one of each population, cheapest first.

    fixed: values of everything else. Same seed, same answer.
    """
    import cma

    low, high = np.array([span[0] for span in spans.values()]), np.array([span[1] for span in spans.values()])

    def values(row: np.ndarray) -> dict[str, float]:
        inside = low + (high - low) * np.clip(row, 0.0, 1.0)
        return dict(fixed) | {name: float(value) for name, value in zip(spans, inside, strict=True)}

    def costs(rows: np.ndarray) -> list[float]:
        found: list[float] = []
        for begin in range(0, len(rows), _BATCH):
            residuals = problem.residuals([values(row) for row in rows[begin : begin + _BATCH]])
            found += [
                problem.cost(residual)[0] if np.isfinite(residual).all() else float("inf") for residual in residuals
            ]
        return found

    unit = qmc.Sobol(len(spans), seed=seed).random(_POINTS)
    first = costs(unit)
    ends = []
    for number, index in enumerate(np.argsort(first)[:STARTS]):
        options = {
            "bounds": [0.0, 1.0], "popsize": _POPULATION, "maxiter": _GENERATIONS, "verbose": -9,
            "seed": seed + number + 1,
        }  # fmt: skip
        strategy = cma.CMAEvolutionStrategy(unit[index], _SPREAD, options)
        while not strategy.stop():
            rows = strategy.ask()
            strategy.tell(rows, costs(np.array(rows)))
        ends.append((float(strategy.result.fbest), values(np.asarray(strategy.result.xbest))))
    return [end for _, end in sorted(ends, key=lambda entry: entry[0])]
