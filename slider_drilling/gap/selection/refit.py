"""What is known, fitted and scored again: in another problem, in another way, or from another place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.gap.evidence.adequacy import Adequacy, adequacy_of_fit
from slider_drilling.gap.evidence.compare import passes_likelihood_ratio_test
from slider_drilling.gap.evidence.score import Folds, HeldOutScore, score_held_out, score_residual
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.fine_fit import fit_fidelity, refit_in_fine_simulation, refit_with_correction
from slider_drilling.gap.search.least_squares import TOLERANCE, Fit, fit, min_gain_to_catch_up
from slider_drilling.gap.search.race import Arm
from slider_drilling.gap.selection.calibration import fit_from_starts, scattered_starts
from slider_drilling.gap.selection.state import FittedModel, SearchState
from slider_drilling.process.parallel_map import parallel_map


def finish_and_cross_validate(problem: Problem, effects: Sequence[Effect], found: Fit, folds: Folds) -> FittedModel:
    """A fit finished and held out."""
    return cross_validate(*refit_in_fine_simulation(*refit_with_correction(problem, found)), effects, folds)


def cross_validate(exact: Problem, polished: Fit, effects: Sequence[Effect], folds: Folds) -> FittedModel:
    """A finished fit, held out."""
    return FittedModel(tuple(effects), exact, polished, score_held_out(exact, polished, folds))


def check_adequacy(explained: FittedModel, seed: int, effects: Sequence[Effect] = ()) -> Adequacy:
    """Whether an explanation is enough; effects: looked for in what it leaves."""
    return adequacy_of_fit(explained.problem, explained.fit, explained.score, seed, effects, explained.effects)


def score_nominal(problem: Problem, tuned: FittedModel) -> HeldOutScore:
    """Score of the model as given."""
    exact = problem.corrected_at({}, fit_fidelity(problem.model))
    residual = exact.residuals([{}])[0]
    return score_residual(exact, residual, replace(tuned.fit, discrepancy=exact.cost(residual)[1]))


def refit(problem: Problem, known: FittedModel, folds: Folds) -> FittedModel:
    problem = problem.at_fidelity_of(known.effects)
    found = fit(problem, known.fit.parameters, known.fit.values)
    return finish_and_cross_validate(problem, known.effects, found, folds)


def rescore(
    problem: Problem, state: SearchState, others: Sequence[FittedModel] = ()
) -> tuple[SearchState, list[FittedModel]]:
    """The state with what is known fitted and scored again in another problem, and others likewise."""
    known = [state.calibrated] if state.current is state.calibrated else [state.calibrated, state.current]
    again = parallel_map(lambda one: refit(problem, one, state.bootstrap.folds), [*known, *others])
    tuned, current = again[0], again[len(known) - 1]
    return replace(state, calibrated=tuned, current=current, nominal_score=score_nominal(problem, tuned)), again[
        len(known) :
    ]


def improve_incumbent(state: SearchState, leader: FittedModel, left: Sequence[Effect], seed: int) -> SearchState:
    """The state with what is known fitted again from where the likeliest finalist got to, if that is likelier.

    A finalist began elsewhere too, and what it gains may be the other place's: what is known is held against it there,
    as far as it comes up with where it is.
    """
    known, freed = state.current, {parameter.name for parameter in state.current.fit.parameters}
    begin = {name: value for name, value in leader.fit.values.items() if name in freed}
    begun = fit(known.problem, known.fit.parameters, begin, iterations=0)
    again = fit(
        known.problem, begun.parameters, begin, tolerance=min_gain_to_catch_up(begun.cost - known.fit.cost),
        simulated=begun.simulated,
        jacobian_rows=begun.jacobian_rows, trust_rows=True,
    )  # fmt: skip
    if again.cost >= known.fit.cost - TOLERANCE:
        return state
    better = finish_and_cross_validate(
        state.current_mode.at_fidelity_of(known.effects), known.effects, again, state.bootstrap.folds
    )
    if better.fit.cost >= known.fit.cost - TOLERANCE:
        return state
    enough = check_adequacy(better, seed, left)
    if known is not state.calibrated:
        return replace(state, current=better, adequacy=enough)
    given = score_nominal(better.problem, better)
    return replace(
        state, nominal_score=given, calibrated=better, current=better, adequacy=enough, calibrated_adequacy=enough
    )


def refit_from_incumbent(state: SearchState, found: FittedModel) -> FittedModel:
    """An explanation that contains what is known, begun once more from there where it ended less likely: with what it
    adds where that had got to, and at nothing. Finished where it gains more than its added parameters do by chance.
    """
    known = state.current
    if found.fit.cost <= known.fit.cost:
        return found
    own = {p.name for effect in found.effects if effect.name not in known.names for p in effect.parameters}
    added = {name: value for name, value in found.fit.values.items() if name in own}
    near = known.problem.at_fidelity_of(found.effects)
    begun = fit_from_starts(near, [known.fit.values | added, known.fit.values], found.fit.parameters)
    if not passes_likelihood_ratio_test(known.fit, begun):
        return found
    again = finish_and_cross_validate(
        state.current_mode.at_fidelity_of(found.effects), found.effects, begun, state.bootstrap.folds
    )
    return min(found, again, key=lambda one: one.fit.cost)


def refit_from_scattered_nuisance(way: Problem, known: FittedModel, folds: Folds) -> FittedModel | None:
    """An explanation fitted again from other places of its nuisance, None where none of them leads to a likelier one.

    Strokes of rocking hide how the string was wound at the beginning: a fit that began near one winding stays there.
    """
    own = {parameter.name for effect in known.effects for parameter in effect.parameters}
    problem, freed = way.at_fidelity_of(known.effects), known.fit.parameters
    nuisance = [parameter for parameter in freed if parameter.name not in own]
    here = fit(problem, freed, known.fit.values, iterations=0)
    again = fit_from_starts(problem, [here.values, *scattered_starts(problem, here, nuisance)], freed)
    if again.cost >= here.cost - TOLERANCE:
        return None
    better = finish_and_cross_validate(problem, known.effects, again, folds)
    return better if better.fit.cost < known.fit.cost - TOLERANCE else None


def best_fit(state: SearchState, own: Sequence[Arm], way: int) -> tuple[Problem, Fit]:
    """The best fit of a set in one way of running the model: its own arm's, or one that goes on from another way's."""
    problem = state.modes[way].at_fidelity_of(own[0].effects)
    fits = [arm.fit for arm in own if arm.mode == way and arm.fit is not None]
    if own[0].mode != way and own[0].fit is not None:
        fits.append(fit(problem, own[0].fit.parameters, own[0].fit.values))
    return problem, min(fits, key=lambda one: one.cost)
