"""A fit finished in simulations fine enough to be judged by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.gap.evidence.compare import by_chance
from slider_drilling.gap.model import Graded, Model
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, fit, pace


def finished(problem: Problem, found: Fit, leader: float = float("inf")) -> tuple[Problem, Fit]:
    """A fit that goes on in the fine simulation until it settles; besides, the problem whose cheap simulation equals
    the fine one there, to be held out in.

    The optimum of the cheap simulation is another one: what its mesh does wrong an effect that acts alike makes up for.
    It is corrected for first, which costs little; the derivatives it ends with serve the fine fit.
    leader: ``-2 log p`` to come up with. The fine fit ends once no iteration gains what that asks for, or what one
    parameter gains on noise.
    """
    best = fine(problem.model)
    if best <= problem.how.fidelity:
        return problem, fit(problem, found.parameters, found.values, known=found.carried)
    near = fit(problem.at(found.values, best), found.parameters, found.values, known=found.carried)
    exact = problem.run_as(replace(problem.how, fidelity=best))
    begun = fit(exact, found.parameters, near.values, iterations=0, known=near.rows)
    least = max(by_chance(1), pace(begun.cost - leader) if np.isfinite(leader) else 0.0)
    ended = fit(
        exact, found.parameters, near.values, tolerance=least, simulated=begun.simulated, known=near.rows,
        trusted=bool(np.isfinite(leader)),
    )
    return problem.at(ended.values, best), ended


def fine(model: Model) -> int:
    """The fidelity that fits are finished in: the one below the finest, which is left to show what it misses."""
    return max(model.finest - 1, 0) if isinstance(model, Graded) else 0
