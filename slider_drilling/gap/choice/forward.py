"""From one explanation to the next: re-tune, then add the effect that foretells most, for as long as one is needed.

`begin` gives the first state and `step` the next; neither changes what it was given, so an interrupt leaves the last
state whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from slider_drilling.gap.choice.arms import Place, arms_of, arms_of_pairs, places_of
from slider_drilling.gap.choice.judge import (
    beside_other_forms,
    elsewhere,
    group_of,
    judge,
    judged_near,
    likelier,
    with_new_floors,
)
from slider_drilling.gap.choice.refit import as_given, scored, tested, unseen
from slider_drilling.gap.choice.stand_in import far_off
from slider_drilling.gap.choice.state import State, Step
from slider_drilling.gap.choice.tuning import floors_lowered, floors_raised, scattered, tuned_from
from slider_drilling.gap.evidence.blocks import make_blocks
from slider_drilling.gap.evidence.compare import beats, pays, shrinks
from slider_drilling.gap.evidence.score import make_folds
from slider_drilling.gap.model import Effect, How, Model, Pulled, Values
from slider_drilling.gap.problem.noise import NoiseFloor, sigmas
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.finish import corrected, finished
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import begun_again, parameters_of, race

Report = Callable[[str, float], None]

# Gain of the weak observer (see `slider_drilling.gap.model.Pulled`).
PULL = 0.3


def begin(
    model: Model,
    effects: Sequence[Effect],
    floors: Sequence[dict[str, NoiseFloor]],
    starts: Sequence[Values],
    seed: int,
    report: Report,
) -> State:
    """Re-tune the model and see whether that is enough."""
    report("re-tuning", 0.02)
    free = build_problem(model, [sigmas(own) for own in floors])
    tuned = tuned_from(free, starts)
    floors = floors_lowered(free, tuned, floors)
    free = build_problem(model, [sigmas(own) for own in floors], spent=free.spent)
    blocks = make_blocks(make_folds(free), seed)
    tuned = fit(free, tuned.parameters, tuned.values, iterations=2)
    near, ended = corrected(free, tuned)
    raised = floors_raised(near, ended, floors, seed)
    if raised != floors:
        floors = raised
        free = build_problem(model, [sigmas(own) for own in floors], spent=free.spent)
        near, ended = corrected(free, fit(free, tuned.parameters, ended.values, iterations=1))
    explained = unseen(*finished(near, ended), (), blocks.folds)
    enough = tested(explained, seed, effects)
    if not enough.done:
        report("re-tuning from other starts", 0.06)
        again = tuned_from(free, scattered(free, tuned))
        if again.cost < tuned.cost:
            explained = scored(free, (), again, blocks.folds)
            enough = tested(explained, seed, effects)
    given = as_given(free, explained)
    good = given.gap <= enough.threshold and all(given.by_channel[c] <= v for c, v in enough.by_channel.items())
    ways = (free, free.run_as(How(0, PULL))) if _can_be_pulled(model) else (free,)
    return State(
        tuple(floors), ways, given, explained, explained, enough, enough, good, blocks,
        done=enough.done and not far_off(explained),
    )  # fmt: skip


def step(
    state: State, effects: Sequence[Effect], together: Sequence[Sequence[Effect]], seed: int, report: Report
) -> State:
    """Race the effects that may come next, judge the finalists on unseen data, and accept the best that passes."""
    had = {one.accepted.effect.name for one in state.steps if one.accepted is not None} | set(state.current.names)
    left = [effect for effect in effects if effect.name not in had]
    if not left:
        return replace(state, done=True)
    turn = len(state.steps)
    report(f"racing {len(left)} effects" + (f", step {turn + 1}" if turn else ""), min(0.1 + 0.3 * turn, 0.8))
    places = places_of(state, left)
    arms, promised = arms_of(state, places, together if turn == 0 else ())
    ran = begun_again(state.ways, race(state.ways, arms))
    report("judging the finalists", min(0.25 + 0.3 * turn, 0.9))
    known = state.current.effects
    state, judged, ruled_out = judge(state, ran, left, seed)
    ended = Step(judged, None, (), promised)
    over = replace(state, steps=(*state.steps, ended), done=True)
    if state.enough.adequate and not known and far_off(state.current):
        over = replace(over, instead=likelier(state, judged, len(left)))
        taken = _in_its_place(over, ended, left, seed) if over.instead else None
        if taken is not None:
            return taken
    found, ended = _accepted(state, ended, known, left, seed, report)
    if found is not None:
        return found
    if ruled_out:
        return replace(state, done=state.enough.done)
    over = replace(over, steps=(*state.steps, ended))
    if state.enough.adequate or len(known) > 1:
        return over
    return _two_at_once(over, effects, () if known else places, seed, report) or over


def _accepted(
    state: State, ended: Step, known: Sequence[Effect], left: Sequence[Effect], seed: int, report: Report
) -> tuple[State | None, Step]:
    """The state with the first of those judged that passes, None where nobody does, and the step with what became of
    them; known: effects before.
    """
    for one in ended.judged:
        if not one.passed:
            continue
        group = group_of(state.blocks, one, ended.judged)
        refloored, accepted = with_new_floors(state, one, left, seed)
        if accepted.passed:
            judged = tuple(accepted if other is one else other for other in ended.judged)
            found = _with(refloored, replace(ended, judged=judged, accepted=accepted, group=group), left, seed)
            if not found.enough.done:
                report("fitting from other starts", min(0.3 + 0.3 * len(state.steps), 0.95))
                found = _from_elsewhere(found, refloored, left, seed)
            return _without_needless(found, known, left, seed), found.steps[-1]
        # Compared with others it is in the noise that they were judged in.
        failed = replace(accepted, explained=one.explained)
        ended = replace(ended, judged=tuple(failed if other is one else other for other in ended.judged))
    return None, ended


def _two_at_once(
    over: State, effects: Sequence[Effect], places: Sequence[Place], seed: int, report: Report
) -> State | None:
    """The state with two effects at once in the place of one or none, where that leaves something and nobody passes
    beside it: one may hide the other, make up for it, or both have been taken for a third. Among so many pairs some
    wrong one shrinks most gaps: only one that ends it is taken, and of which both are needed. None where there is no
    such pair; over: where it ends without; places: where single effects began beside re-tuning alone, if they did just
    now.
    """
    report("racing effects two by two", min(0.3 + 0.3 * len(over.steps), 0.9))
    bare = replace(over, current=over.tuned, enough=over.tuned_enough, steps=())
    arms = arms_of_pairs(places or places_of(bare, effects), over.tuned_enough.threshold)
    ran = race(over.ways, arms, over.current.fit.cost)
    if not any(arm.fit is not None and pays(over.current.fit, arm.fit) for arm in ran):
        return None
    state, judged, _ = judge(bare, begun_again(over.ways, ran, 2), effects, seed)
    first = replace(over.steps[0], judged=beside_other_forms(over, judged))
    found, _ = _accepted(state, first, (), effects, seed, report)
    if found is None or not found.enough.adequate or len(found.current.effects) < 2:
        return None
    (told,) = found.steps
    before = tuple(one for step in over.steps for one in step.judged)
    return replace(found, steps=(replace(told, judged=(*told.judged, *before)),))


def _in_its_place(over: State, ended: Step, left: Sequence[Effect], seed: int) -> State | None:
    """The state with an effect in the place of a re-tuning that was enough, but went far, where the log itself tells
    the two apart; over: where it ends without.
    """
    near, judged, accepted = judged_near(over, ended.judged, left, seed)
    if accepted is None:
        return None
    taken = replace(ended, judged=judged, accepted=accepted, group=group_of(near.blocks, accepted, judged))
    return _with(replace(near, steps=over.steps[:-1]), taken, left, seed)


def _with(state: State, taken: Step, left: Sequence[Effect], seed: int) -> State:
    """The state with one more effect in it; left: those that it was chosen from."""
    assert taken.accepted is not None
    found = taken.accepted.explained
    others = [effect for effect in left if effect.name not in found.names]
    enough = tested(found, seed, others)
    return replace(state, current=found, enough=enough, steps=(*state.steps, taken), done=enough.done)


def _from_elsewhere(found: State, before: State, left: Sequence[Effect], seed: int) -> State:
    """The state with its newest effect fitted from other starts, where those lead to a likelier one: what an effect
    leaves may be no more than that it was fitted beside a nuisance that the race began with.
    """
    taken = found.steps[-1]
    assert taken.accepted is not None
    better = elsewhere(before, taken.accepted, left, seed)
    if better is None:
        return found
    judged = tuple(better if one is taken.accepted else one for one in taken.judged)
    return _with(before, replace(taken, judged=judged, accepted=better), left, seed)


def _without_needless(state: State, before: Sequence[Effect], left: Sequence[Effect], seed: int) -> State:
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
        problem = state.way.showing(rest)
        begin = {name: value for name, value in state.current.fit.values.items() if name not in own}
        found = fit(problem, parameters_of(problem, rest), begin)
        reduced = scored(problem, rest, found, state.blocks.folds)
        needed = shrinks(state.blocks, reduced.score, state.current.score)
        better = needed or beats(state.blocks, state.current.score, reduced.score)
        if not (better and pays(reduced.fit, state.current.fit)):
            enough = tested(reduced, seed, left)
            state = replace(state, current=reduced, enough=enough, done=enough.done)
    return state


def _can_be_pulled(model: Model) -> bool:
    return isinstance(model, Pulled) and any(c.name == model.pulled for run in model.runs for c in run.channels)


__all__ = ["begin", "step"]
