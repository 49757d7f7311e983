"""The finalists of a step are refitted, held out, and put to the tests that a name has to pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import comb

import numpy as np

from slider_drilling.gap.evidence.compare import (
    LEAST_SHARE,
    LEVEL,
    BlockBootstrap,
    chi2_critical,
    exceeds_evidence_threshold,
    fit_exceeds_evidence_threshold,
    gap_closed,
    passes_likelihood_ratio_test,
    predicts_better,
    predicts_better_among,
    resampled_squared_gaps,
    shrinks,
)
from slider_drilling.gap.evidence.free_forms import fit_free_forms_of_known
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.noise import sigmas
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.fine_fit import refit_in_fine_simulation, refit_with_correction
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import Arm, finalists
from slider_drilling.gap.selection.calibration import lower_floors
from slider_drilling.gap.selection.nuisance_limits import (
    calibrate_within_limits,
    outside_prior,
    supported_without_prior,
)
from slider_drilling.gap.selection.other_runs import check_other_runs, order_by_other_runs
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


def evaluate_candidates(
    state: SearchState, ran: Sequence[Arm], left: Sequence[Effect], seed: int
) -> tuple[SearchState, tuple[CandidateResult, ...], bool]:
    """Refit the finalists in the way that foretells most, and hold them out against what is known so far; whether what
    was known is ruled out now, so that the race ran from the wrong place.

    Which way that is, the leader shows, corrected. Where it is not the one the state was scored in, what is known is
    scored anew in it.
    """
    sets, ways = finalists(ran), state.active_modes
    led = dict(
        zip(ways, parallel_map(lambda one: refit_with_correction(*best_fit(state, sets[0], one)), ways), strict=True)
    )
    way = min(led, key=lambda one: led[one][1].cost)
    leader = led[way][1].cost
    before = state
    if state.current.problem.options.observer_gain != state.modes[way].options.observer_gain:
        state, _ = rescore(state.modes[way], state)

    def refit(arms: Sequence[Arm]) -> FittedModel:
        near = led[way] if arms is sets[0] else refit_with_correction(*best_fit(state, arms, way))
        ended = refit_in_fine_simulation(*near, leader=None if arms is sets[0] else leader)
        return cross_validate(*ended, arms[0].effects, state.bootstrap.folds)

    found = parallel_map(refit, sets)
    known = state.current
    state = improve_incumbent(state, min(found, key=lambda one: one.fit.cost), left, seed)
    if state.calibrated is not before.calibrated and state.calibrated_adequacy is before.calibrated_adequacy:
        state = replace(state, calibrated_adequacy=check_adequacy(state.calibrated, seed))
    found = parallel_map(lambda one: refit_from_incumbent(state, one), found)
    judged = [_verdict(state, one, left, seed) for one in found]
    judged.sort(key=lambda one: one.fitted.score.held_out_deviance)
    told = order_by_other_runs(exclude_like_free_forms(state, judged))
    return state, told, _rules_out(state.current, known)


def exclude_like_free_forms(state: SearchState, judged: Sequence[CandidateResult]) -> tuple[CandidateResult, ...]:
    """The same, but for effects that foretell no more than another form of a law which is known would: a cause that is
    not quite the catalogue's leaves what something else can bend to.
    """
    idle = not state.current.effects or not any(one.passed for one in judged)
    forms = [] if idle else fit_free_forms_of_known(state.current, state.bootstrap.folds)
    if not forms:
        return tuple(judged)

    def held(one: CandidateResult) -> CandidateResult:
        if not one.passed or predicts_better(state.bootstrap, one.fitted.score, forms[0].score, len(forms)):
            return one
        return replace(one, failures=(f"another form of what is known explains as much: {forms[0].description}",))

    return tuple(held(one) for one in judged)


def update_floors(
    state: SearchState, accepted: CandidateResult, left: Sequence[Effect], seed: int
) -> tuple[SearchState, CandidateResult]:
    """The same with floors that the better model shows: what were kinks of the signal had been taken for noise."""
    found = accepted.fitted
    floors = lower_floors(found.problem, found.fit, state.floors)
    ratios = [floors[p.run][p.name].sigma / state.floors[p.run][p.name].sigma for p in found.problem.pieces]
    if all(abs(np.log(ratio)) < LEAST_SHARE for ratio in ratios):
        return state, accepted
    free = build_problem(found.problem.model, [sigmas(own) for own in floors], counter=found.problem.counter)
    ways = tuple(free.with_options(problem.options) for problem in state.modes)
    problem = free.with_options(replace(found.problem.options, fidelity=free.options.fidelity))
    state, (again,) = rescore(problem, state, [found])
    state = replace(state, floors=floors, modes=ways)
    return state, _verdict(state, again, left, seed)


def refit_from_other_starts(
    state: SearchState, accepted: CandidateResult, left: Sequence[Effect], seed: int
) -> CandidateResult | None:
    """The same from where other starts lead, None where that is no likelier or passes no more."""
    again = refit_from_scattered_nuisance(state.current_mode, accepted.fitted, state.bootstrap.folds)
    if again is None:
        return None
    judged = _verdict(state, again, left, seed)
    return judged if judged.passed else None


def _rules_out(now: FittedModel, before: FittedModel) -> bool:
    """Whether the log rules out where the same effects were before: it is likelier now by more than as many parameters
    gain on noise (Wilks).
    """
    if now is before:
        return False
    there = fit(now.problem, now.fit.parameters, before.fit.values, iterations=0, jacobian_rows=now.fit.jacobian_rows)
    return there.cost - now.fit.cost > chi2_critical(len(now.fit.parameters))


def _verdict(state: SearchState, explained: FittedModel, left: Sequence[Effect], seed: int) -> CandidateResult:
    """The tests of what is new in an explanation: it foretells more than what is known, it pays for its parameters, the
    gap shrinks by enough, in other runs too, its sign is its own. left: of which the new effects were chosen.
    """
    known, blocks = state.current, state.bootstrap
    new = [effect for effect in explained.effects if effect.name not in known.names]
    rivals = max(len(left), comb(len(left), len(new)))
    closed, interval = gap_closed(blocks, known.score, explained.score)
    why = []
    if state.adequacy.adequate and not (
        exceeds_evidence_threshold(explained.score, known.score, rivals)
        and fit_exceeds_evidence_threshold(explained.fit, known.fit, rivals)
    ):
        why.append("without it no more than noise is left, and the log does not show it beyond doubt")
    # Unseen stretches alone can favour an effect by what the refits without it happened to do there.
    if not passes_likelihood_ratio_test(known.fit, explained.fit, rivals):
        why.append("the whole log is no likelier with it than free parameters make it by chance")
    if not shrinks(blocks, known.score, explained.score):
        why.append("the gap does not shrink for certain")
    for effect in new:
        if not effect.is_physical(explained.fit.values):
            why.append(f"not what its name says: it would be {effect.nonphysical}")
    certain = predicts_better_among(blocks, explained.score, known.score, rivals)
    # Replicates are dear: they are made only where nothing else speaks against the effect.
    if not certain and (why or not _suffices(state, explained, rivals, seed)):
        why.insert(0, "foretells no more of unseen data than without it, at the level shared among all candidates")
    if _small(state, explained) and (why or not check_adequacy(explained, seed, left).complete):
        why.append("nothing needs it: what it closes is next to nothing of what re-tuning left")
    judged = CandidateResult(explained.effects[-1], explained, closed, interval, tuple(why), known.names)
    return check_other_runs(state, judged)


def _small(state: SearchState, explained: FittedModel) -> bool:
    """Whether what is closed beyond what was enough already is next to nothing of what re-tuning left. That is worth a
    name only if something stood out in what was left, and nothing does any more.
    """
    gained = state.current.score.gap**2 - explained.score.gap**2
    return state.adequacy.adequate and not gained >= LEAST_SHARE * (state.calibrated.score.gap**2 - 1.0)


def find_masked_effects(state: SearchState, judged: Sequence[CandidateResult], rivals: int) -> tuple[str, ...]:
    """Laws that make the whole log likelier than what is known for certain, with a nuisance that is not far off."""
    found = [
        one for one in judged
        if passes_likelihood_ratio_test(state.current.fit, one.fitted.fit, rivals)
        and one.effect.is_physical(one.fitted.fit.values)
        and not outside_prior(one.fitted)
    ]  # fmt: skip
    return tuple(one.effect.name for one in sorted(found, key=lambda one: one.fitted.fit.cost))


def evaluate_within_limits(
    state: SearchState, judged: Sequence[CandidateResult], left: Sequence[Effect], seed: int
) -> tuple[SearchState, tuple[CandidateResult, ...], CandidateResult | None]:
    """What a re-tuning that went far may stand for, held against one that is kept near: the state with that one, all
    that was judged, and who passes and is likelier by the log alone than the one that went far, None where nobody is or
    the one kept near is enough.
    """
    near = calibrate_within_limits(state, left, seed)
    again = tuple(_kept_to(one, _verdict(near, one.fitted, left, seed)) for one in judged)
    passed = [one for one in again if one.passed and supported_without_prior(state.current, one, len(left))]
    return (
        near,
        again,
        None if near.adequacy.complete or not passed else min(passed, key=lambda one: one.fitted.fit.cost),
    )


def _kept_to(before: CandidateResult, held: CandidateResult) -> CandidateResult:
    """A verdict against re-tuning that is kept near, of which an effect that is not has no part."""
    if not outside_prior(before.fitted):
        return held
    return replace(
        held, failures=(*held.failures, "with it re-tuning still goes farther from the model than is common")
    )


def _suffices(state: SearchState, explained: FittedModel, rivals: int, seed: int) -> bool:
    """Whether an effect foretells more on the whole, shrinks the gap for certain at the level shared among all, and
    leaves no more than replicates of it do.

    A discrepancy forgives what is slow, so that a slow effect's gain is small in every stretch and one event outweighs
    it; the gap does not forgive. But many a wrong law shrinks a gap: only one that ends it is taken at that. What shows
    once in a log, resampled blocks hold as often as not: there the likelihood ratio has to be beyond doubt, and nothing
    at all may be left.
    """
    known, blocks = state.current.score, state.bootstrap
    if state.adequacy.within_thresholds or explained.score.held_out_deviance >= known.held_out_deviance:
        return False
    everywhere = (
        float(
            np.quantile(
                resampled_squared_gaps(blocks, known) - resampled_squared_gaps(blocks, explained.score), LEVEL / rivals
            )
        )
        > 0.0
    )
    if not everywhere and not exceeds_evidence_threshold(explained.score, known, rivals):
        return False
    left = check_adequacy(explained, seed)
    return left.within_thresholds if everywhere else left.adequate


def indistinguishable_from(
    blocks: BlockBootstrap, accepted: CandidateResult, judged: Sequence[CandidateResult]
) -> tuple[str, ...]:
    """Finalists that pass and that the one accepted does not beat by both measures: what it foretells, and the gap.

    A density that is certainly better beside a gap that is not tells a better description of what is left, not a cause.
    """
    rivals = [one for one in judged if one is not accepted and one.passed]
    level = LEVEL / max(len(rivals), 1)
    mine = accepted.fitted

    def told_apart(rival: FittedModel) -> bool:
        wider = resampled_squared_gaps(blocks, rival.score) - resampled_squared_gaps(blocks, mine.score)
        return predicts_better(blocks, mine.score, rival.score, len(rivals)) and float(np.quantile(wider, level)) > 0.0

    return tuple(one.effect.name for one in rivals if not told_apart(one.fitted))
