"""A fit finished in simulations fine enough to be judged by."""

from __future__ import annotations

from dataclasses import replace

from slider_drilling.gap.evidence.compare import chi2_critical
from slider_drilling.gap.model import HasFidelities, Model
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, fit, min_gain_to_catch_up


def refit_with_correction(problem: Problem, found: Fit) -> tuple[Problem, Fit]:
    """A fit that goes on in the cheap simulation made equal to the fine one where it stood; and that problem."""
    best = fit_fidelity(problem.model)
    near = problem.corrected_at(found.values, best) if best > problem.options.fidelity else problem
    return near, fit(near, found.parameters, found.values, jacobian_rows=found.reusable_rows)


def refit_in_fine_simulation(near: Problem, found: Fit, leader: float | None = None) -> tuple[Problem, Fit]:
    """A corrected fit that goes on in the fine simulation until it settles; besides, the problem whose cheap simulation
    equals the fine one there, to be held out in.

    The optimum of the cheap simulation is another one: what its mesh does wrong an effect that acts alike makes up for.
    The derivatives that the corrected fit ended with serve the fine one.
    leader: ``-2 log p`` to come up with, None for whoever leads. The fine fit ends once no iteration gains what that
    asks for, or what one parameter gains on noise.
    """
    best = fit_fidelity(near.model)
    if best <= near.options.fidelity:
        return near, found
    exact = near.with_options(replace(near.options, fidelity=best))
    begun = fit(exact, found.parameters, found.values, iterations=0, jacobian_rows=found.jacobian_rows)
    least = max(chi2_critical(1), min_gain_to_catch_up(begun.cost - leader) if leader is not None else 0.0)
    ended = fit(
        exact,
        found.parameters,
        found.values,
        tolerance=least,
        simulated=begun.simulated,
        jacobian_rows=found.jacobian_rows,
        trust_rows=leader is not None,
    )
    return near.corrected_at(ended.values, best, ended.simulated), ended


def fit_fidelity(model: Model) -> int:
    """The fidelity that fits are finished in: the one below the finest, which is left to show what it misses."""
    return max(model.max_fidelity - 1, 0) if isinstance(model, HasFidelities) else 0
