"""From one explanation to the next: re-tune, then add the effect that foretells most, for as long as one is needed.

`begin` gives the first state and `step` the next; neither changes what it was given, so an interrupt leaves the last
state whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from slider_drilling.gap.evidence.block_bootstrap import make_bootstrap
from slider_drilling.gap.evidence.compare import passes_likelihood_ratio_test, predicts_better, shrinks
from slider_drilling.gap.evidence.score import make_folds
from slider_drilling.gap.model import Effect, HasObserver, Model, SimulationOptions, Values
from slider_drilling.gap.problem.noise import NoiseFloor, sigmas
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.fine_fit import refit_in_fine_simulation, refit_with_correction
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import parameters_of, race, restart_leader
from slider_drilling.gap.selection.calibration import fit_from_starts, lower_floors, raise_floors, scattered_starts
from slider_drilling.gap.selection.candidates import (
    evaluate_candidates,
    evaluate_within_limits,
    exclude_like_free_forms,
    find_masked_effects,
    indistinguishable_from,
    refit_from_other_starts,
    update_floors,
)
from slider_drilling.gap.selection.nuisance_limits import outside_prior
from slider_drilling.gap.selection.refit import check_adequacy, cross_validate, finish_and_cross_validate, score_nominal
from slider_drilling.gap.selection.start_points import (
    StartPoint,
    find_start_points,
    race_entries,
    race_entries_of_pairs,
)
from slider_drilling.gap.selection.state import SearchState, SelectionStep

Report = Callable[[str, float], None]

# Gain of the weak observer (see `slider_drilling.gap.model.Pulled`).
OBSERVER_GAIN = 0.3


def calibrate(
    model: Model,
    effects: Sequence[Effect],
    floors: Sequence[dict[str, NoiseFloor]],
    starts: Sequence[Values],
    seed: int,
    report: Report,
) -> SearchState:
    """Re-tune the model and see whether that is enough."""
    report("re-tuning", 0.02)
    free = build_problem(model, [sigmas(own) for own in floors])
    tuned = fit_from_starts(free, starts)
    floors = lower_floors(free, tuned, floors)
    free = build_problem(model, [sigmas(own) for own in floors], counter=free.counter)
    blocks = make_bootstrap(make_folds(free), seed)
    tuned = fit(free, tuned.parameters, tuned.values, iterations=2)
    near, ended = refit_with_correction(free, tuned)
    raised = raise_floors(near, ended, floors, seed)
    if raised != floors:
        floors = raised
        free = build_problem(model, [sigmas(own) for own in floors], counter=free.counter)
        near, ended = refit_with_correction(free, fit(free, tuned.parameters, ended.values, iterations=1))
    explained = cross_validate(*refit_in_fine_simulation(near, ended), (), blocks.folds)
    enough = check_adequacy(explained, seed, effects)
    if not enough.complete:
        report("re-tuning from other starts", 0.06)
        again = fit_from_starts(free, scattered_starts(free, tuned))
        if again.cost < tuned.cost:
            explained = finish_and_cross_validate(free, (), again, blocks.folds)
            enough = check_adequacy(explained, seed, effects)
    given = score_nominal(free, explained)
    good = given.gap <= enough.threshold and all(given.by_channel[c] <= v for c, v in enough.channel_thresholds.items())
    ways = (free, free.with_options(SimulationOptions(0, OBSERVER_GAIN))) if _can_be_pulled(model) else (free,)
    return SearchState(
        tuple(floors), ways, given, explained, explained, enough, enough, good, blocks,
        done=enough.complete and not outside_prior(explained),
    )  # fmt: skip


def add_effect(
    state: SearchState, effects: Sequence[Effect], together: Sequence[Sequence[Effect]], seed: int, report: Report
) -> SearchState:
    """Race the effects that may come next, judge the finalists on unseen data, and accept the best that passes."""
    had = {one.accepted.effect.name for one in state.steps if one.accepted is not None} | set(state.current.names)
    left = [effect for effect in effects if effect.name not in had]
    if not left:
        return replace(state, done=True)
    turn = len(state.steps)
    report(f"racing {len(left)} effects" + (f", step {turn + 1}" if turn else ""), min(0.1 + 0.3 * turn, 0.8))
    places = find_start_points(state, left)
    arms, promised = race_entries(state, places, together if turn == 0 else ())
    ran = restart_leader(state.modes, race(state.modes, arms))
    report("judging the finalists", min(0.25 + 0.3 * turn, 0.9))
    known = state.current.effects
    state, judged, ruled_out = evaluate_candidates(state, ran, left, seed)
    ended = SelectionStep(judged, None, (), promised)
    over = replace(state, steps=(*state.steps, ended), done=True)
    if state.adequacy.adequate and not known and outside_prior(state.current):
        over = replace(over, masked_effects=find_masked_effects(state, judged, len(left)))
        taken = _in_its_place(over, ended, left, seed) if over.masked_effects else None
        if taken is not None:
            return taken
    found, ended = _accepted(state, ended, known, left, seed, report)
    if found is not None:
        return found
    if ruled_out:
        return replace(state, done=state.adequacy.complete)
    over = replace(over, steps=(*state.steps, ended))
    if state.adequacy.adequate or len(known) > 1:
        return over
    return _two_at_once(over, effects, () if known else places, seed, report) or over


def _accepted(
    state: SearchState, ended: SelectionStep, known: Sequence[Effect], left: Sequence[Effect], seed: int, report: Report
) -> tuple[SearchState | None, SelectionStep]:
    """The state with the first of those judged that passes, None where nobody does, and the step with what became of
    them; known: effects before.
    """
    for one in ended.candidates:
        if not one.passed:
            continue
        group = indistinguishable_from(state.bootstrap, one, ended.candidates)
        refloored, accepted = update_floors(state, one, left, seed)
        if accepted.passed:
            judged = tuple(accepted if other is one else other for other in ended.candidates)
            found = _with(
                refloored, replace(ended, candidates=judged, accepted=accepted, indistinguishable=group), left, seed
            )
            if not found.adequacy.complete:
                report("fitting from other starts", min(0.3 + 0.3 * len(state.steps), 0.95))
                found = _from_elsewhere(found, refloored, left, seed)
            return _without_needless(found, known, left, seed), found.steps[-1]
        # Compared with others it is in the noise that they were judged in.
        failed = replace(accepted, fitted=one.fitted)
        ended = replace(ended, candidates=tuple(failed if other is one else other for other in ended.candidates))
    return None, ended


def _two_at_once(
    over: SearchState, effects: Sequence[Effect], places: Sequence[StartPoint], seed: int, report: Report
) -> SearchState | None:
    """The state with two effects at once in the place of one or none, where that leaves something and nobody passes
    beside it: one may hide the other, make up for it, or both have been taken for a third. Among so many pairs some
    wrong one shrinks most gaps: only one that ends it is taken, and of which both are needed. None where there is no
    such pair; over: where it ends without; places: where single effects began beside re-tuning alone, if they did just
    now.
    """
    report("racing effects two by two", min(0.3 + 0.3 * len(over.steps), 0.9))
    bare = replace(over, current=over.calibrated, adequacy=over.calibrated_adequacy, steps=())
    arms = race_entries_of_pairs(places or find_start_points(bare, effects), over.calibrated_adequacy.threshold)
    ran = race(over.modes, arms, over.current.fit.cost)
    if not any(arm.fit is not None and passes_likelihood_ratio_test(over.current.fit, arm.fit) for arm in ran):
        return None
    state, judged, _ = evaluate_candidates(bare, restart_leader(over.modes, ran, 2), effects, seed)
    first = replace(over.steps[0], candidates=exclude_like_free_forms(over, judged))
    found, _ = _accepted(state, first, (), effects, seed, report)
    if found is None or not found.adequacy.adequate or len(found.current.effects) < 2:
        return None
    (told,) = found.steps
    before = tuple(one for step in over.steps for one in step.candidates)
    return replace(found, steps=(replace(told, candidates=(*told.candidates, *before)),))


def _in_its_place(over: SearchState, ended: SelectionStep, left: Sequence[Effect], seed: int) -> SearchState | None:
    """The state with an effect in the place of a re-tuning that was enough, but went far, where the log itself tells
    the two apart; over: where it ends without.
    """
    near, judged, accepted = evaluate_within_limits(over, ended.candidates, left, seed)
    if accepted is None:
        return None
    taken = replace(
        ended,
        candidates=judged,
        accepted=accepted,
        indistinguishable=indistinguishable_from(near.bootstrap, accepted, judged),
    )
    return _with(replace(near, steps=over.steps[:-1]), taken, left, seed)


def _with(state: SearchState, taken: SelectionStep, left: Sequence[Effect], seed: int) -> SearchState:
    """The state with one more effect in it; left: those that it was chosen from."""
    assert taken.accepted is not None
    found = taken.accepted.fitted
    others = [effect for effect in left if effect.name not in found.names]
    enough = check_adequacy(found, seed, others)
    return replace(state, current=found, adequacy=enough, steps=(*state.steps, taken), done=enough.complete)


def _from_elsewhere(found: SearchState, before: SearchState, left: Sequence[Effect], seed: int) -> SearchState:
    """The state with its newest effect fitted from other starts, where those lead to a likelier one: what an effect
    leaves may be no more than that it was fitted beside a nuisance that the race began with.
    """
    taken = found.steps[-1]
    assert taken.accepted is not None
    better = refit_from_other_starts(before, taken.accepted, left, seed)
    if better is None:
        return found
    judged = tuple(better if one is taken.accepted else one for one in taken.candidates)
    return _with(before, replace(taken, candidates=judged, accepted=better), left, seed)


def _without_needless(state: SearchState, before: Sequence[Effect], left: Sequence[Effect], seed: int) -> SearchState:
    """The state without an effect that the newest ones make needless: it no longer pays for its parameters, or without
    it nothing is foretold worse and the gap does not grow for certain. One that came alone was judged just now; those
    that came together must each be needed.
    """
    known = state.current.effects
    came = len(known) - len(before)
    for needless in known if came > 1 else known[:-1]:
        rest = tuple(effect for effect in state.current.effects if effect is not needless)
        if not rest:
            break
        own = {parameter.name for parameter in needless.parameters}
        problem = state.current_mode.at_fidelity_of(rest)
        begin = {name: value for name, value in state.current.fit.values.items() if name not in own}
        found = fit(problem, parameters_of(problem, rest), begin)
        reduced = finish_and_cross_validate(problem, rest, found, state.bootstrap.folds)
        needed = shrinks(state.bootstrap, reduced.score, state.current.score)
        better = needed or predicts_better(state.bootstrap, state.current.score, reduced.score)
        if not (better and passes_likelihood_ratio_test(reduced.fit, state.current.fit)):
            enough = check_adequacy(reduced, seed, left)
            state = replace(state, current=reduced, adequacy=enough, done=enough.complete)
    return state


def _can_be_pulled(model: Model) -> bool:
    return isinstance(model, HasObserver) and any(
        c.name == model.observed_channel for run in model.runs for c in run.channels
    )


__all__ = ["add_effect", "calibrate"]
