"""A fit finished where the cheap simulation equals the fine one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.gap.model import Graded, Model
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, fit, pace

POLISH = 3  # iterations
# Of the noise: where the mesh adds more, fits are finished on the fine one.
_COARSE = 0.5


def finished(problem: Problem, found: Fit, leader: float = float("inf")) -> tuple[Problem, Fit]:
    """A fit finished where the cheap simulation equals the fine one.

    Where what the mesh adds is a good part of the noise it changes with every step, and the fine one itself is fitted.
    leader: ``-2 log p`` to come up with; a fine fit that is to do so begins with the cheap one's derivatives, and ends
    once no iteration gains what that asks for.
    """
    best = fine(problem.model)
    exact = problem.at(found.values, best)
    polished = fit(exact, found.parameters, found.values, iterations=POLISH, known=found.carried)
    exact = problem.at(polished.values, best)
    if best > problem.how.fidelity and _mesh_error(exact) > _COARSE:
        exact = problem.run_as(replace(problem.how, fidelity=best))
        if not np.isfinite(leader):
            return exact, fit(exact, found.parameters, polished.values)
        begun = fit(exact, found.parameters, polished.values, iterations=0, known=polished.rows)
        return exact, fit(
            exact, found.parameters, begun.values, tolerance=pace(begun.cost - leader), simulated=begun.simulated,
            known=polished.carried,
        )  # fmt: skip
    return exact, fit(exact, found.parameters, polished.values, iterations=1)


def _mesh_error(problem: Problem) -> float:
    """What finer simulations add, RMS in noise units of the channel that shows most; not where a miss accumulates."""
    shown = [np.mean(problem.correction[p.rows] ** 2) for p in problem.pieces if not p.channel.accumulates]
    return float(np.sqrt(max(shown, default=0.0)))


def fine(model: Model) -> int:
    """The fidelity that fits are finished in: the one below the finest, which is left to show what it misses."""
    return max(model.finest - 1, 0) if isinstance(model, Graded) else 0
