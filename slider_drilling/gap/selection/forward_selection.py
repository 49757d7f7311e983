"""Forward selection: effects are added to the calibrated model one at a time, for as long as one is needed.

`add_effect` gives the next state and never changes the one it was given, so that an interrupt leaves the last state
whole.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from slider_drilling.gap.evidence.compare import passes_likelihood_ratio_test
from slider_drilling.gap.model import Effect
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import Arm, parameters_of, race, restart_leader
from slider_drilling.gap.selection.candidates import (
    evaluate_candidates,
    evaluate_within_limits,
    exclude_like_free_forms,
    find_masked_effects,
    indistinguishable_from,
    refit_from_other_starts,
    update_floors,
)
from slider_drilling.gap.selection.evidence_tests import Evidence
from slider_drilling.gap.selection.naming_criteria import Stage, failures
from slider_drilling.gap.selection.nuisance_limits import outside_prior
from slider_drilling.gap.selection.refit import check_adequacy, finish_and_cross_validate
from slider_drilling.gap.selection.start_points import (
    StartPoint,
    find_start_points,
    grid_arms,
    race_entries,
    race_entries_of_pairs,
)
from slider_drilling.gap.selection.state import CandidateResult, FittedModel, SearchState, SelectionStep

# `-2 log p` by which conditional nuisance leads where no test of an effect can turn the order round: that of four
# parameters by chance is beyond 20 once in two thousand times.
CLEAR_LEAD = 100.0


@dataclass(frozen=True)
class SearchTask:
    """What a forward selection tries.

    Attributes:
        effects: All candidate effects.
        coupled: Sets of effects that start together in the first step.
        conditional: Nuisance that races beside the effects (`slider_drilling.gap.model.HasConditionalNuisance`).
        seed: Seed of the replicates.
        report: Called with the stage and the share done.
    """

    effects: Sequence[Effect]
    coupled: Sequence[Sequence[Effect]]
    conditional: Sequence[Effect]
    seed: int
    report: Progress


@dataclass(frozen=True)
class _Raced:
    """What a race left.

    Attributes:
        finishers: Arms, cheapest first.
        start_points: From which they started.
        predicted_gain: Gain of ``-2 log p`` that the screen predicts, by effect.
    """

    finishers: Sequence[Arm]
    start_points: Sequence[StartPoint]
    predicted_gain: dict[str, float]


def add_effect(state: SearchState, task: SearchTask) -> SearchState:
    """One step: race the effects that may come next, test the candidates, and accept the best that passes.

    Args:
        state: State before the step.
        task: What is tried.

    Returns:
        The state after the step; it is done if nothing was accepted or nothing is left to find. Where conditional
        nuisance explains more than every effect, the state before the step, with that nuisance missing.
    """
    tried = {step.accepted.effect.name for step in state.steps if step.accepted is not None} | set(state.current.names)
    remaining = [effect for effect in task.effects if effect.name not in tried]
    if not remaining:
        return replace(state, done=True)
    raced = _race(state, remaining, task)
    leaders = clear_leaders(raced.finishers, task.conditional)
    if leaders:
        rescored, candidates, _ = evaluate_candidates(state, leaders, remaining, task.seed)
        if (missing := _missing_nuisance(rescored, candidates, task.conditional)) is not None:
            return replace(rescored, missing_nuisance=missing)
    finishers = restart_leader(state.modes, raced.finishers)
    state, candidates, former_optimum_ruled_out = evaluate_candidates(state, finishers, remaining, task.seed)
    if (missing := _missing_nuisance(state, candidates, task.conditional)) is not None:
        return replace(state, missing_nuisance=missing)
    nameable = tuple(candidate for candidate in candidates if candidate.effect not in task.conditional)
    step = SelectionStep(nameable, None, (), raced.predicted_gain)
    masked, unmasked = _replace_implausible_calibration(state, step, remaining, task.seed)
    if unmasked is not None:
        return unmasked
    accepted, step = _accept_best(state, step, state.current.effects, remaining, task.seed, task.report)
    if accepted is not None:
        return accepted
    if former_optimum_ruled_out:
        # The race started from the wrong place: the next step races from the better one.
        return replace(state, done=state.adequacy.complete)
    return _end_with_pair(state, replace(masked, steps=(*state.steps, step)), raced, task)


def _race(state: SearchState, remaining: Sequence[Effect], task: SearchTask) -> _Raced:
    """The race of the effects that may come next, and of conditional nuisance beside them."""
    number = len(state.steps)
    step_name = f", step {number + 1}" if number else ""
    task.report(f"racing {len(remaining)} effects{step_name}", min(0.1 + 0.3 * number, 0.8))
    start_points = find_start_points(state, [*remaining, *task.conditional])
    coupled = task.coupled if number == 0 else ()
    arms, predicted_gain = race_entries(state, start_points, coupled)
    finishers = race(state.modes, arms)
    least = min((arm.cost for arm in finishers if arm.physical), default=math.inf)
    if len(task.conditional) > 1 and _something_is_left(state, least):
        from_grid = race(state.modes, grid_arms(state, task.conditional), least)
        finishers = sorted([*finishers, *from_grid], key=lambda arm: arm.cost)
    task.report("testing the candidates", min(0.25 + 0.3 * number, 0.9))
    return _Raced(finishers, start_points, predicted_gain)


def _something_is_left(state: SearchState, least_cost: float) -> bool:
    """Whether conditional nuisance together could explain more than a race left: its grid takes a third of a race.

    It cannot beside effects that leave no more than noise, nor where a fit is as likely as white noise of the floors'
    size, whose ``-2 log p`` is the number of samples.

    Args:
        state: State before the race.
        least_cost: ``-2 log p`` of the best physical fit of the race.
    """
    beside_enough = bool(state.current.effects) and state.adequacy.adequate
    return not beside_enough and least_cost > state.modes[0].size


def _replace_implausible_calibration(
    state: SearchState, step: SelectionStep, remaining: Sequence[Effect], seed: int
) -> tuple[SearchState, SearchState | None]:
    """The state as it ends with this step, with effects that calibration may hide; and one that names such an effect.

    The second is None if calibration is plausible, or the log supports no effect in its place.
    """
    ended = replace(state, steps=(*state.steps, step), done=True)
    if not state.adequacy.adequate or state.current.effects or not outside_prior(state.current):
        return ended, None
    ended = replace(ended, masked_effects=find_masked_effects(state, step.candidates, len(remaining)))
    return ended, _replace_calibration(ended, remaining, seed) if ended.masked_effects else None


def _end_with_pair(state: SearchState, ended: SearchState, raced: _Raced, task: SearchTask) -> SearchState:
    """The state at the end of the search: with two effects in the place of one or none where they end the gap.

    Args:
        state: State before the step.
        ended: As the search ends without a pair.
        raced: The race of the step.
        task: What is tried.
    """
    known = state.current.effects
    if state.adequacy.adequate or len(known) > 1:
        return ended
    start_points = () if known else raced.start_points
    pair = _add_pair(ended, [*task.effects, *task.conditional], start_points, task.seed, task.report)
    if pair is None:
        return ended
    is_nuisance = any(effect in task.conditional for effect in pair.current.effects)
    return replace(state, missing_nuisance=pair.current) if is_nuisance else pair


def clear_leaders(finishers: Sequence[Arm], conditional: Sequence[Effect]) -> list[Arm]:
    """The arms of conditional nuisance alone, if the best of them is far ahead of every arm with an effect; else none.

    No effect of these arms will be named then: testing them would take most of the time of the search.

    Args:
        finishers: Arms that a race left, cheapest first.
        conditional: Nuisance that raced beside the effects.
    """
    nuisance: list[Arm] = []
    others: list[Arm] = []
    for arm in finishers:
        (nuisance if all(effect in conditional for effect in arm.effects) else others).append(arm)
    physical = [arm for arm in nuisance if arm.physical]
    followed = others[0].cost if others else math.inf
    return physical if physical and followed - physical[0].cost >= CLEAR_LEAD else []


def _missing_nuisance(
    state: SearchState, candidates: Sequence[CandidateResult], conditional: Sequence[Effect]
) -> FittedModel | None:
    """The model with conditional nuisance that explains more than every effect that may be named, else None."""
    best = next((candidate for candidate in candidates if candidate.passed), None)
    if best is None or best.effect not in conditional:
        return None
    # Whether it is one number of the nuisance or another need not be decided.
    nameable = [candidate for candidate in candidates if candidate.effect not in conditional]
    return None if indistinguishable_from(state.bootstrap, best, nameable) else best.fitted


def _accept_best(
    state: SearchState,
    step: SelectionStep,
    known: Sequence[Effect],
    remaining: Sequence[Effect],
    seed: int,
    report: Progress,
) -> tuple[SearchState | None, SelectionStep]:
    """The state with the first candidate that passes, None if none does; and the step with what became of each.

    ``known``: effects before the step.
    """
    for candidate in step.candidates:
        if not candidate.passed:
            continue
        group = indistinguishable_from(state.bootstrap, candidate, step.candidates)
        rescored, accepted = update_floors(state, candidate, remaining, seed)
        if not accepted.passed:
            # Its scores stay those in the noise of the other candidates, so that all can be compared.
            step = _with_candidate(step, candidate, replace(accepted, fitted=candidate.fitted))
            continue
        step = _with_candidate(step, candidate, accepted)
        step = replace(step, accepted=accepted, indistinguishable=group)
        new_state = _accept(rescored, step, remaining, seed)
        if not new_state.adequacy.complete:
            report("fitting from other starts", min(0.3 + 0.3 * len(state.steps), 0.95))
            new_state = _restart_nuisance(new_state, rescored, remaining, seed)
        return _drop_needless_effects(new_state, known, remaining, seed), new_state.steps[-1]
    return None, step


def _with_candidate(step: SelectionStep, old: CandidateResult, new: CandidateResult) -> SelectionStep:
    """The step with one candidate in the place of another."""
    return replace(step, candidates=tuple(new if each is old else each for each in step.candidates))


def _accept(state: SearchState, step: SelectionStep, remaining: Sequence[Effect], seed: int) -> SearchState:
    """The state after a step that accepted an effect."""
    assert step.accepted is not None
    model = step.accepted.fitted
    others = [effect for effect in remaining if effect.name not in model.names]
    adequacy = check_adequacy(model, seed, others)
    return replace(state, current=model, adequacy=adequacy, steps=(*state.steps, step), done=adequacy.complete)


def _restart_nuisance(
    accepted: SearchState, before: SearchState, remaining: Sequence[Effect], seed: int
) -> SearchState:
    """The state with its newest effect refitted from other values of the nuisance, where these lead to a likelier fit.

    What an effect seems to leave may come from the nuisance values that the race started with.
    """
    step = accepted.steps[-1]
    assert step.accepted is not None
    better = refit_from_other_starts(before, step.accepted, remaining, seed)
    if better is None:
        return accepted
    step = replace(_with_candidate(step, step.accepted, better), accepted=better)
    return _accept(before, step, remaining, seed)


def _drop_needless_effects(
    state: SearchState, before: Sequence[Effect], remaining: Sequence[Effect], seed: int
) -> SearchState:
    """The state without effects that are not needed beside the newest.

    An effect that was accepted alone has just been tested. Of several accepted together each must be needed.
    """
    effects = state.current.effects
    accepted_together = len(effects) - len(before) > 1
    for effect in effects if accepted_together else effects[:-1]:
        rest = tuple(other for other in state.current.effects if other is not effect)
        if not rest:
            break
        reduced = _refitted_without(state, effect)
        if failures(Stage.STILL_NEEDED, Evidence(state, reduced, state.current)):
            adequacy = check_adequacy(reduced, seed, remaining)
            state = replace(state, current=reduced, adequacy=adequacy, done=adequacy.complete)
    return state


def drop_uncertain_effects(state: SearchState, effects: Sequence[Effect], seed: int) -> SearchState:
    """The state at the end of the search, without effects whose size may be none beside all others.

    Args:
        state: State at the end.
        effects: All candidate effects.
        seed: Seed of the replicates.
    """
    while uncertain := _uncertain_effects(state):
        effect, without, messages = min(uncertain, key=lambda each: each[1].fit.cost)
        steps = tuple(_rejected(step, effect, messages) for step in state.steps)
        if without.effects:
            others = [each for each in effects if each.name not in without.names]
            state = replace(state, current=without, adequacy=check_adequacy(without, seed, others), steps=steps)
        else:
            state = replace(state, current=state.calibrated, adequacy=state.calibrated_adequacy, steps=steps)
    return state


def _uncertain_effects(state: SearchState) -> list[tuple[Effect, FittedModel, tuple[str, ...]]]:
    """Effects that may not stay at the end: each with a refit without it, and why."""
    uncertain = []
    for effect in reversed(state.current.effects):
        rest = tuple(other for other in state.current.effects if other is not effect)
        as_fitted = Evidence(state, replace(state.current, effects=rest), state.current)
        # A refit takes as long as a step of the search: only where the interval does not settle it.
        if not failures(Stage.END, as_fitted):
            continue
        without = _refitted_without(state, effect)
        if messages := failures(Stage.END, Evidence(state, without, state.current)):
            uncertain.append((effect, without, messages))
    return uncertain


def _refitted_without(state: SearchState, effect: Effect) -> FittedModel:
    """The current model refitted without one of its effects."""
    rest = tuple(other for other in state.current.effects if other is not effect)
    own = {parameter.name for parameter in effect.parameters}
    problem = state.current_mode.at_fidelity_of(rest)
    start = {name: value for name, value in state.current.fit.values.items() if name not in own}
    refitted = fit(problem, parameters_of(problem, rest), start)
    return finish_and_cross_validate(problem, rest, refitted, state.bootstrap.folds)


def _rejected(step: SelectionStep, effect: Effect, messages: tuple[str, ...]) -> SelectionStep:
    """The step with an effect that it accepted rejected after all."""
    if step.accepted is None or step.accepted.effect.name != effect.name:
        return step
    rejected = replace(step.accepted, failures=messages)
    return replace(_with_candidate(step, step.accepted, rejected), accepted=None, indistinguishable=())


def _replace_calibration(ended: SearchState, remaining: Sequence[Effect], seed: int) -> SearchState | None:
    """The state with an effect in the place of an implausible calibration, None if the log supports none.

    ``ended``: the state without it.
    """
    near, candidates, accepted = evaluate_within_limits(ended, ended.steps[-1].candidates, remaining, seed)
    if accepted is None:
        return None
    group = indistinguishable_from(near.bootstrap, accepted, candidates)
    step = replace(ended.steps[-1], candidates=candidates, accepted=accepted, indistinguishable=group)
    return _accept(replace(near, steps=ended.steps[:-1]), step, remaining, seed)


def _add_pair(
    ended: SearchState, effects: Sequence[Effect], start_points: Sequence[StartPoint], seed: int, report: Progress
) -> SearchState | None:
    """The state with two effects in the place of one or none, None if no pair ends the gap.

    One effect may hide another or make up for it, or both may have been taken for a third.

    ``ended``: the state without a pair; ``start_points``: those beside calibration alone, if they were just computed.
    """
    report("racing pairs of effects", min(0.3 + 0.3 * len(ended.steps), 0.9))
    bare = replace(ended, current=ended.calibrated, adequacy=ended.calibrated_adequacy, steps=())
    arms = race_entries_of_pairs(start_points or find_start_points(bare, effects), ended.calibrated_adequacy.threshold)
    finishers = race(ended.modes, arms, ended.current.fit.cost)
    current = ended.current.fit
    if not any(arm.fit is not None and passes_likelihood_ratio_test(current, arm.fit) for arm in finishers):
        return None
    state, candidates, _ = evaluate_candidates(bare, restart_leader(ended.modes, finishers, 2), effects, seed)
    step = replace(ended.steps[0], candidates=exclude_like_free_forms(ended, candidates))
    accepted, _ = _accept_best(state, step, (), effects, seed, report)
    if accepted is None or failures(Stage.PAIR, Evidence(accepted, accepted.calibrated, accepted.current)):
        return None
    (step,) = accepted.steps
    before = tuple(candidate for taken in ended.steps for candidate in taken.candidates)
    return replace(accepted, steps=(replace(step, candidates=(*step.candidates, *before)),))
