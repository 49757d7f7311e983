"""The finalists of a race become candidates: refitted, cross-validated, and tested against the naming criteria."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.gap.evidence.block_bootstrap import BlockBootstrap
from slider_drilling.gap.evidence.compare import (
    NAMING_LEVEL,
    chi2_critical,
    gap_closed,
    passes_likelihood_ratio_test,
    predicts_better,
    resampled_squared_gaps,
)
from slider_drilling.gap.evidence.free_forms import fit_free_forms_of_known
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.noise import sigmas
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.fine_fit import refit_in_fine_simulation, refit_with_correction
from slider_drilling.gap.search.least_squares import Fit, KnownStart, fit
from slider_drilling.gap.search.race import Arm, finalists
from slider_drilling.gap.selection.calibration import lower_floors
from slider_drilling.gap.selection.evidence_tests import Evidence
from slider_drilling.gap.selection.naming_criteria import Kind, Stage, failed_criteria, failures
from slider_drilling.gap.selection.nuisance_limits import calibrate_within_limits, outside_prior
from slider_drilling.gap.selection.refit import (
    best_fit,
    check_adequacy,
    cross_validate,
    improve_incumbent,
    refit_from_incumbent,
    refit_from_scattered_nuisance,
    rescore,
)
from slider_drilling.gap.selection.state import CandidateResult, FittedModel, SearchState
from slider_drilling.process.parallel_map import parallel_map

# Relative change of a noise floor (by its logarithm) below which the scores are kept: they would hardly change.
MIN_FLOOR_CHANGE = 0.05


def evaluate_candidates(
    state: SearchState, arms: Sequence[Arm], remaining: Sequence[Effect], seed: int
) -> tuple[SearchState, tuple[CandidateResult, ...], bool]:
    """Refit the finalists in the best simulation mode, cross-validate them and test them against the current model.

    The leader of the race shows which mode that is. Where it is not the mode of the current model, that is scored again
    in it.

    Args:
        state: State before the step.
        arms: What the race left, best first.
        remaining: Effects that are not in the model.
        seed: Seed of the replicates.

    Returns:
        The state, with the current model refitted from the best candidate's optimum where that is better; the
        candidates in order; and whether the log rules out the former optimum, so that the race started from the wrong
        place.
    """
    sets, before = finalists(arms), state
    mode, leader = _best_mode(state, sets[0])
    if state.current.problem.options.observer_gain != state.modes[mode].options.observer_gain:
        state, _ = rescore(state.modes[mode], state)
    leader_cost = leader[1].cost

    def refit(finalist: Sequence[Arm]) -> FittedModel:
        is_leader = finalist is sets[0]
        corrected = leader if is_leader else refit_with_correction(*best_fit(state, finalist, mode))
        fine = refit_in_fine_simulation(*corrected, leader=None if is_leader else leader_cost)
        return cross_validate(*fine, finalist[0].effects, state.bootstrap.folds)

    models = parallel_map(refit, sets)
    incumbent = state.current
    state = improve_incumbent(state, min(models, key=lambda model: model.fit.cost), remaining, seed)
    if state.calibrated is not before.calibrated and state.calibrated_adequacy is before.calibrated_adequacy:
        state = replace(state, calibrated_adequacy=check_adequacy(state.calibrated, seed))
    models = parallel_map(lambda model: refit_from_incumbent(state, model), models)
    results = [_test_candidate(state, model, remaining, seed) for model in models]
    results.sort(key=lambda result: result.fitted.score.held_out_deviance)
    ordered = _order_by_other_runs(exclude_like_free_forms(state, results))
    return state, ordered, _rules_out(state.current, incumbent)


def _best_mode(state: SearchState, leader: Sequence[Arm]) -> tuple[int, tuple[Problem, Fit]]:
    """The simulation mode in which the leader's corrected fit is likeliest; and that fit with its problem."""
    modes = state.active_modes
    corrected = parallel_map(lambda mode: refit_with_correction(*best_fit(state, leader, mode)), modes)
    fits = dict(zip(modes, corrected, strict=True))
    mode = min(fits, key=lambda mode: fits[mode][1].cost)
    return mode, fits[mode]


def exclude_like_free_forms(state: SearchState, candidates: Sequence[CandidateResult]) -> tuple[CandidateResult, ...]:
    """The candidates; those that fit no better than a free form of an effect in the model have failed."""
    if not state.current.effects or not any(candidate.passed for candidate in candidates):
        return tuple(candidates)
    forms = fit_free_forms_of_known(state.current, state.bootstrap.folds)

    def tested(candidate: CandidateResult) -> CandidateResult:
        if not candidate.passed:
            return candidate
        evidence = Evidence(state, state.current, candidate.fitted, free_forms=forms)
        return replace(candidate, failures=failures(Stage.SECOND_EFFECT, evidence))

    return tuple(tested(candidate) for candidate in candidates)


def update_floors(
    state: SearchState, accepted: CandidateResult, remaining: Sequence[Effect], seed: int
) -> tuple[SearchState, CandidateResult]:
    """The state and the accepted candidate, scored with the noise floors that the better model shows.

    Kinks of the signal that the model now follows had been taken for noise.
    """
    model = accepted.fitted
    floors = lower_floors(model.problem, model.fit, state.floors)
    ratios = [floors[p.run][p.name].sigma / state.floors[p.run][p.name].sigma for p in model.problem.pieces]
    if all(abs(np.log(ratio)) < MIN_FLOOR_CHANGE for ratio in ratios):
        return state, accepted
    free_run = state.modes[0].with_noise([sigmas(own) for own in floors])
    modes = tuple(free_run.with_options(mode.options) for mode in state.modes)
    problem = free_run.with_options(replace(model.problem.options, fidelity=free_run.options.fidelity))
    state, (rescored,) = rescore(problem, state, [model])
    state = replace(state, floors=floors, modes=modes)
    return state, _test_candidate(state, rescored, remaining, seed)


def refit_from_other_starts(
    state: SearchState, accepted: CandidateResult, remaining: Sequence[Effect], seed: int
) -> CandidateResult | None:
    """The candidate refitted from other values of its nuisance; None where that is no likelier or fails a criterion."""
    refitted = refit_from_scattered_nuisance(state.current_mode, accepted.fitted, state.bootstrap.folds)
    if refitted is None:
        return None
    result = _test_candidate(state, refitted, remaining, seed)
    return result if result.passed else None


def find_masked_effects(
    state: SearchState, candidates: Sequence[CandidateResult], level_shared_by: int
) -> tuple[str, ...]:
    """Effects, likeliest first, that make the log likelier than an implausible calibration, with a plausible one."""
    masked = [
        candidate for candidate in candidates
        if passes_likelihood_ratio_test(state.current.fit, candidate.fitted.fit, level_shared_by)
        and candidate.effect.is_physical(candidate.fitted.fit.values)
        and not outside_prior(candidate.fitted)
    ]  # fmt: skip
    return tuple(candidate.effect.name for candidate in sorted(masked, key=lambda candidate: candidate.fitted.fit.cost))


def evaluate_within_limits(
    state: SearchState, candidates: Sequence[CandidateResult], remaining: Sequence[Effect], seed: int
) -> tuple[SearchState, tuple[CandidateResult, ...], CandidateResult | None]:
    """Test the candidates of an implausible calibration against one that is kept within its limits.

    Returns:
        The state with the restricted calibration; the candidates tested against it; and the likeliest one that passes
        and that the log alone prefers to the implausible calibration. None if there is none, or if the restricted
        calibration is enough.
    """
    near = calibrate_within_limits(state, remaining, seed)

    def tested(candidate: CandidateResult) -> CandidateResult:
        result = _test_candidate(near, candidate.fitted, remaining, seed)
        implausible = failures(Stage.PLAUSIBLE_CALIBRATION, Evidence(near, near.current, candidate.fitted))
        return replace(result, failures=(*result.failures, *implausible))

    def supported(candidate: CandidateResult) -> bool:
        evidence = Evidence(state, state.current, candidate.fitted, remaining)
        return candidate.passed and not failures(Stage.REPLACES_CALIBRATION, evidence)

    results = tuple(tested(candidate) for candidate in candidates)
    passed = [result for result in results if supported(result)]
    if near.adequacy.complete or not passed:
        return near, results, None
    return near, results, min(passed, key=lambda result: result.fitted.fit.cost)


def indistinguishable_from(
    bootstrap: BlockBootstrap, accepted: CandidateResult, candidates: Sequence[CandidateResult]
) -> tuple[str, ...]:
    """Names of the other candidates that pass and that the log cannot distinguish from the accepted one.

    It distinguishes them only if the accepted one both predicts better and leaves a smaller gap. A density that is
    better beside a gap that is not shows a better description of what is left, not a cause.
    """
    alternatives = [candidate for candidate in candidates if candidate is not accepted and candidate.passed]
    level = NAMING_LEVEL / max(len(alternatives), 1)
    best = accepted.fitted.score

    def distinguished(alternative: FittedModel) -> bool:
        wider = resampled_squared_gaps(bootstrap, alternative.score) - resampled_squared_gaps(bootstrap, best)
        better = predicts_better(bootstrap, best, alternative.score, len(alternatives))
        return better and float(np.quantile(wider, level)) > 0.0

    return tuple(candidate.effect.name for candidate in alternatives if not distinguished(candidate.fitted))


def _test_candidate(state: SearchState, model: FittedModel, remaining: Sequence[Effect], seed: int) -> CandidateResult:
    """The model tested against the current one by the naming criteria, in runs that its fit has not seen too."""
    evidence = Evidence(state, state.current, model, remaining, seed)
    closed, interval = gap_closed(state.bootstrap, state.current.score, model.score)
    failed = failed_criteria(Stage.CANDIDATE, evidence)
    result = CandidateResult(
        effect=model.effects[-1],
        fitted=model,
        closed=closed,
        interval=interval,
        failures=tuple(message for each in failed for message in each.messages(evidence)),
        beside=state.current.names,
        too_small=bool(failed) and all(each.kind is Kind.SIZE for each in failed),
    )
    if failed or len(model.problem.model.runs) < 2:
        return result
    before, after = state.current.cross_run_score, model.cross_run_score
    closed_there = gap_closed(state.bootstrap, before, after)
    return replace(result, closed_in_other_runs=closed_there, failures=failures(Stage.OTHER_RUNS, evidence))


def _order_by_other_runs(candidates: Sequence[CandidateResult]) -> tuple[CandidateResult, ...]:
    """Candidates tested in other runs first, by how well they predict these; then the others in their order."""
    tested = [candidate for candidate in candidates if candidate.closed_in_other_runs is not None]
    tested.sort(key=lambda candidate: candidate.fitted.cross_run_score.held_out_deviance)
    return (*tested, *(candidate for candidate in candidates if candidate.closed_in_other_runs is None))


def _rules_out(now: FittedModel, before: FittedModel) -> bool:
    """Whether the log rules out the former optimum of the same effects: outside the confidence region (Wilks)."""
    if now is before:
        return False
    known = KnownStart(jacobian_rows=now.fit.jacobian_rows)
    there = fit(now.problem, now.fit.parameters, before.fit.values, iterations=0, known=known)
    return there.cost - now.fit.cost > chi2_critical(len(now.fit.parameters))
