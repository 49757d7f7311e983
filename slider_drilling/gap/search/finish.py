"""A fit finished in simulations fine enough to be judged by."""

from __future__ import annotations

from dataclasses import replace

from slider_drilling.gap.evidence.compare import by_chance
from slider_drilling.gap.model import Graded, Model
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, fit, pace


def corrected(problem: Problem, found: Fit) -> tuple[Problem, Fit]:
    """A fit that goes on in the cheap simulation made equal to the fine one where it stood; and that problem."""
    best = fine(problem.model)
    near = problem.at(found.values, best) if best > problem.how.fidelity else problem
    return near, fit(near, found.parameters, found.values, known=found.carried)


def finished(near: Problem, found: Fit, leader: float | None = None) -> tuple[Problem, Fit]:
    """A corrected fit that goes on in the fine simulation until it settles; besides, the problem whose cheap simulation
    equals the fine one there, to be held out in.

    The optimum of the cheap simulation is another one: what its mesh does wrong an effect that acts alike makes up for.
    The derivatives that the corrected fit ended with serve the fine one.
    leader: ``-2 log p`` to come up with, None for whoever leads. The fine fit ends once no iteration gains what that
    asks for, or what one parameter gains on noise.
    """
    best = fine(near.model)
    if best <= near.how.fidelity:
        return near, found
    exact = near.run_as(replace(near.how, fidelity=best))
    begun = fit(exact, found.parameters, found.values, iterations=0, known=found.rows)
    least = max(by_chance(1), pace(begun.cost - leader) if leader is not None else 0.0)
    ended = fit(
        exact, found.parameters, found.values, tolerance=least, simulated=begun.simulated, known=found.rows,
        trusted=leader is not None,
    )
    return near.at(ended.values, best, ended.simulated), ended


def fine(model: Model) -> int:
    """The fidelity that fits are finished in: the one below the finest, which is left to show what it misses."""
    return max(model.finest - 1, 0) if isinstance(model, Graded) else 0
