"""Fits finished in simulations fine enough to compare models by.

The optimum of a cheap simulation lies elsewhere: an effect that acts alike makes up for the errors of its mesh. Fits
therefore continue in a cheap simulation that is corrected to equal the fine one, and then in the fine one itself.
"""

from __future__ import annotations

from dataclasses import replace

from slider_drilling.gap.evidence.compare import chi2_critical
from slider_drilling.gap.model import HasFidelities, Model
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, KnownStart, fit, min_gain_to_catch_up


def refit_with_correction(problem: Problem, start: Fit) -> tuple[Problem, Fit]:
    """Continue a fit in the cheap simulation, corrected to equal the fine one where it starts.

    Returns:
        The corrected problem, and the fit.
    """
    fidelity = fit_fidelity(problem.model)
    corrected = problem.corrected_at(start.values, fidelity) if fidelity > problem.options.fidelity else problem
    known = KnownStart(jacobian_rows=start.reusable_rows)
    return corrected, fit(corrected, start.parameters, start.values, known=known)


def refit_in_fine_simulation(corrected: Problem, start: Fit, leader: float | None = None) -> tuple[Problem, Fit]:
    """Continue a corrected fit in the fine simulation until it converges.

    The Jacobian of the corrected fit serves in the fine simulation too.

    Args:
        corrected: The corrected problem.
        start: The fit in it.
        leader: ``-2 log p`` of the best fit, to catch up with; None for the best itself. The fit ends once an iteration
            gains less than that asks for, or less than one parameter gains on noise.

    Returns:
        The problem whose cheap simulation equals the fine one at the fit, to cross-validate in; and the fit.
    """
    fidelity = fit_fidelity(corrected.model)
    if fidelity <= corrected.options.fidelity:
        return corrected, start
    exact = corrected.with_options(replace(corrected.options, fidelity=fidelity))
    here = fit(exact, start.parameters, start.values, iterations=0, known=KnownStart(jacobian_rows=start.jacobian_rows))
    least_gain = max(chi2_critical(1), min_gain_to_catch_up(here.cost - leader) if leader is not None else 0.0)
    known = KnownStart(here.simulated, start.jacobian_rows, trust_rows=leader is not None)
    fine = fit(exact, start.parameters, start.values, tolerance=least_gain, known=known)
    return corrected.corrected_at(fine.values, fidelity, fine.simulated), fine


def fit_fidelity(model: Model) -> int:
    """Fidelity in which fits are finished: one below the finest, which is left to show what that one misses."""
    return max(model.max_fidelity - 1, 0) if isinstance(model, HasFidelities) else 0
