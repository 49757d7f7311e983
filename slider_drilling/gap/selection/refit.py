"""Refits of a model: finished in fine simulations, in another problem, and from other starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.gap.evidence.adequacy import Adequacy, adequacy_of_fit
from slider_drilling.gap.evidence.compare import passes_likelihood_ratio_test
from slider_drilling.gap.evidence.score import (
    Folds,
    HeldOutScore,
    score_held_out,
    score_residual,
    squared_residuals,
)
from slider_drilling.gap.model import Effect, Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.fine_fit import fit_fidelity, refit_in_fine_simulation, refit_with_correction
from slider_drilling.gap.search.least_squares import (
    TOLERANCE,
    Fit,
    KnownStart,
    fit,
    linearised_at_its_end,
    min_gain_to_catch_up,
)
from slider_drilling.gap.search.multi_start import fit_from_starts, scattered_starts
from slider_drilling.gap.search.race import Arm
from slider_drilling.gap.selection.state import FittedModel, SearchState
from slider_drilling.process.parallel_map import parallel_map


def cross_validate(problem: Problem, fine_fit: Fit, effects: Sequence[Effect], folds: Folds) -> FittedModel:
    """The model of a finished fit, with its cross-validated score."""
    known = linearised_at_its_end(problem, fine_fit)
    return FittedModel(tuple(effects), problem, known, score_held_out(problem, known, folds))


def finish_and_cross_validate(problem: Problem, effects: Sequence[Effect], start: Fit, folds: Folds) -> FittedModel:
    """The model of a fit, finished in fine simulations and cross-validated."""
    return cross_validate(*refit_in_fine_simulation(*refit_with_correction(problem, start)), effects, folds)


def check_adequacy(model: FittedModel, seed: int, effects: Sequence[Effect] = ()) -> Adequacy:
    """Whether a model leaves only noise.

    Args:
        model: The fitted model.
        seed: Seed of its replicates.
        effects: Effects to look for in the residuals.
    """
    return adequacy_of_fit(model.problem, model.fit, model.score, seed, effects, model.effects)


def score_nominal(problem: Problem, calibrated: FittedModel) -> HeldOutScore:
    """Score of the model as given."""
    return _score_unfitted(problem, calibrated.fit, {})


def _score_unfitted(problem: Problem, whole: Fit, values: Values) -> HeldOutScore:
    """Score of the model with values that were not fitted."""
    exact = problem.corrected_at(values, fit_fidelity(problem.model))
    residual = exact.residuals([values])[0]
    return score_residual(exact, residual, replace(whole, discrepancy=exact.cost(residual)[1]))


def fitted_gap(model: FittedModel) -> float:
    """E of a fit over the data that it was fitted to."""
    return float(np.sqrt(np.mean(squared_residuals(model.problem, model.fit.residual))))


def least_gap(problem: Problem, given: Sequence[Values]) -> float:
    """The smallest E of the model with any of these values, none of which was fitted."""
    exact = problem.with_options(replace(problem.options, fidelity=fit_fidelity(problem.model)))
    squares = [squared_residuals(exact, residual) for residual in exact.residuals(given)]
    return float(np.sqrt(min(np.mean(each) for each in squares)))


def no_worse_than(calibrated: FittedModel, given: Sequence[Values]) -> FittedModel:
    """The calibrated model; or the model with the best of these values, where calibration left a larger gap.

    The likelihood lets slow discrepancies pass. Where the model fits badly, its optimum can therefore follow what is
    fast and leave a larger gap than the model as given, or than the values that a user starts from.
    """
    scores = [_score_unfitted(calibrated.problem, calibrated.fit, values) for values in given]
    best = min(range(len(given)), key=lambda index: scores[index].gap)
    if calibrated.score.gap <= scores[best].gap:
        return calibrated
    parameters = calibrated.fit.parameters
    problem = calibrated.problem.corrected_at(given[best], fit_fidelity(calibrated.problem.model))
    values = {parameter.name: parameter.nominal for parameter in parameters} | dict(given[best])
    unchanged = fit(problem, parameters, values, iterations=0)
    return replace(calibrated, problem=problem, fit=unchanged, score=scores[best])


def refit(problem: Problem, model: FittedModel, folds: Folds) -> FittedModel:
    """The model fitted and cross-validated in another problem, from its present values."""
    problem = problem.at_fidelity_of(model.effects)
    start = fit(problem, model.fit.parameters, model.fit.values)
    return finish_and_cross_validate(problem, model.effects, start, folds)


def rescore(
    problem: Problem, state: SearchState, others: Sequence[FittedModel] = ()
) -> tuple[SearchState, list[FittedModel]]:
    """The state with its models fitted and scored in another problem, and other models likewise."""
    own = [state.calibrated] if state.current is state.calibrated else [state.calibrated, state.current]
    refitted = parallel_map(lambda model: refit(problem, model, state.bootstrap.folds), [*own, *others])
    nominal = score_nominal(problem, refitted[0])
    calibrated = no_worse_than(refitted[0], [{}])
    current = calibrated if len(own) == 1 else refitted[1]
    return replace(state, calibrated=calibrated, current=current, nominal_score=nominal), refitted[len(own) :]


def improve_incumbent(state: SearchState, leader: FittedModel, remaining: Sequence[Effect], seed: int) -> SearchState:
    """The state with its current model refitted from the best candidate's optimum, where that is likelier.

    A candidate may win only because it started elsewhere. The current model is therefore refitted from there before
    they are compared, for as long as it can still catch up with its present optimum.
    """
    incumbent = state.current
    freed = {parameter.name for parameter in incumbent.fit.parameters}
    start = {name: value for name, value in leader.fit.values.items() if name in freed}
    linearised = fit(incumbent.problem, incumbent.fit.parameters, start, iterations=0)
    refitted = fit(
        incumbent.problem, linearised.parameters, start,
        tolerance=min_gain_to_catch_up(linearised.cost - incumbent.fit.cost),
        known=KnownStart(linearised.simulated, linearised.jacobian_rows, trust_rows=True),
    )  # fmt: skip
    if refitted.cost >= incumbent.fit.cost - TOLERANCE:
        return state
    problem = state.current_mode.at_fidelity_of(incumbent.effects)
    better = finish_and_cross_validate(problem, incumbent.effects, refitted, state.bootstrap.folds)
    if better.fit.cost >= incumbent.fit.cost - TOLERANCE:
        return state
    adequacy = check_adequacy(better, seed, remaining)
    if incumbent is not state.calibrated:
        return replace(state, current=better, adequacy=adequacy)
    nominal = score_nominal(better.problem, better)
    if better.score.gap > nominal.gap:
        return state
    return replace(
        state, nominal_score=nominal, calibrated=better, current=better, adequacy=adequacy,
        calibrated_adequacy=adequacy,
    )  # fmt: skip


def refit_from_incumbent(state: SearchState, candidate: FittedModel) -> FittedModel:
    """The candidate, refitted from the current model's values where it ended less likely than that.

    A larger model cannot be less likely than the one that it contains: then the search missed its optimum. It starts
    once with the candidate's own values of the new effects, and once with these neutral.
    """
    incumbent = state.current
    if candidate.fit.cost <= incumbent.fit.cost:
        return candidate
    own = {p.name for effect in candidate.effects if effect.name not in incumbent.names for p in effect.parameters}
    added = {name: value for name, value in candidate.fit.values.items() if name in own}
    starts = [incumbent.fit.values | added, incumbent.fit.values]
    refitted = fit_from_starts(incumbent.problem.at_fidelity_of(candidate.effects), starts, candidate.fit.parameters)
    if not passes_likelihood_ratio_test(incumbent.fit, refitted):
        return candidate
    problem = state.current_mode.at_fidelity_of(candidate.effects)
    finished = finish_and_cross_validate(problem, candidate.effects, refitted, state.bootstrap.folds)
    return min(candidate, finished, key=lambda model: model.fit.cost)


def refit_from_scattered_nuisance(mode: Problem, model: FittedModel, folds: Folds) -> FittedModel | None:
    """The model refitted from other values of its nuisance, None where none leads to a likelier optimum.

    A log may hide the state at its start, as rocking hides how a shaft was wound: a fit that began near one state stays
    there.
    """
    own = {parameter.name for effect in model.effects for parameter in effect.parameters}
    problem, freed = mode.at_fidelity_of(model.effects), model.fit.parameters
    nuisance = [parameter for parameter in freed if parameter.name not in own]
    here = fit(problem, freed, model.fit.values, iterations=0)
    refitted = fit_from_starts(problem, [here.values, *scattered_starts(problem, here, nuisance)], freed)
    if refitted.cost >= here.cost - TOLERANCE:
        return None
    better = finish_and_cross_validate(problem, model.effects, refitted, folds)
    return better if better.fit.cost < model.fit.cost - TOLERANCE else None


def best_fit(state: SearchState, arms: Sequence[Arm], mode: int) -> tuple[Problem, Fit]:
    """The best fit of a set of effects in one simulation mode, with its problem.

    Args:
        state: State of the search.
        arms: Arms of the set, cheapest first.
        mode: Index of the mode. Where the cheapest arm ran in another one, its fit is continued in this one.
    """
    problem = state.modes[mode].at_fidelity_of(arms[0].effects)
    fits = [arm.fit for arm in arms if arm.mode == mode and arm.fit is not None]
    if arms[0].mode != mode and arms[0].fit is not None:
        fits.append(fit(problem, arms[0].fit.parameters, arms[0].fit.values))
    return problem, min(fits, key=lambda found: found.cost)
