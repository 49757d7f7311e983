"""From one explanation to the next: re-tune, then add the effect that foretells most, for as long as one is needed.

`begin` gives the first state and `step` the next; neither changes what it was given, so an interrupt leaves the last
state whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from slider_drilling.gap.choice.judge import elsewhere, group_of, judge, judged_near, likelier, shrinks, with_new_floors
from slider_drilling.gap.choice.refit import as_given, scored, tested, unseen
from slider_drilling.gap.choice.stand_in import far_off
from slider_drilling.gap.choice.state import State, Step
from slider_drilling.gap.choice.tuning import TUNING, floors_lowered, floors_raised, plausible, scattered, tuned_from
from slider_drilling.gap.evidence.compare import beats, closed_between, make_blocks
from slider_drilling.gap.evidence.score import make_folds
from slider_drilling.gap.model import Effect, How, Model, Pulled, Values
from slider_drilling.gap.problem.noise import NoiseFloor, sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.finish import finished
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.race import Arm, begun_again, parameters_of, race
from slider_drilling.gap.search.screen import STARTS, Candidate, screen
from slider_drilling.gap.search.wide import wide

Report = Callable[[str, float], None]

# Gain of the weak observer (see `slider_drilling.gap.model.Pulled`).
PULL = 0.3
# Effects that may be named together.
MOST_EFFECTS = 3


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
    exact, ended = finished(free, tuned)
    raised = floors_raised(exact, ended, floors, seed)
    if raised != floors:
        floors = raised
        free = build_problem(model, [sigmas(own) for own in floors], spent=free.spent)
        exact, ended = finished(free, fit(free, tuned.parameters, tuned.values, iterations=1))
    explained = unseen(exact, (), ended, blocks.folds)
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
    if not left or len(state.current.effects) >= MOST_EFFECTS:
        return replace(state, done=True)
    turn = len(state.steps)
    report(f"racing {len(left)} effects" + (f", step {turn + 1}" if turn else ""), min(0.1 + 0.3 * turn, 0.8))
    arms, promised, ways = _arms(state, left, together if turn == 0 else ())
    ran = begun_again(state.ways, race(state.ways, arms))
    report("judging the finalists", min(0.25 + 0.3 * turn, 0.9))
    state, judged, ruled_out = judge(state, ran, ways, left, seed)
    ended = Step(judged, None, (), promised)
    over = replace(state, steps=(*state.steps, ended), done=True)
    if state.enough.adequate and not state.current.effects and far_off(state.current):
        over = replace(over, instead=likelier(state, judged, len(left)))
        taken = _in_its_place(over, ended, left, seed) if over.instead else None
        if taken is not None:
            return taken
    for one in judged:
        if one.passed:
            group = group_of(state.blocks, one, judged)
            refloored, accepted = with_new_floors(state, one, len(left), seed)
            judged = tuple(accepted if other is one else other for other in judged)
            if accepted.passed:
                found = _with(refloored, Step(judged, accepted, group, promised), left, seed)
                if not found.enough.done:
                    report("fitting from other starts", min(0.3 + 0.3 * turn, 0.95))
                    found = _from_elsewhere(found, refloored, left, seed)
                return _without_needless(found, state.current.effects, left, seed)
    return replace(state, done=state.enough.done) if ruled_out else over


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
    better = elsewhere(before, taken.accepted, len(left), seed)
    if better is None:
        return found
    judged = tuple(better if one is taken.accepted else one for one in taken.judged)
    return _with(before, replace(taken, judged=judged, accepted=better), left, seed)


def _without_needless(state: State, before: Sequence[Effect], left: Sequence[Effect], seed: int) -> State:
    """The state without an effect that the newest ones make needless: without it nothing is foretold worse, and the gap
    does not grow for certain. One that came alone was judged just now; those that came together must each be needed.
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
        found = fit(problem, parameters_of(problem, rest), begin, iterations=TUNING)
        reduced = scored(problem, rest, found, state.blocks.folds)
        needed = shrinks(*closed_between(state.blocks, reduced.score, state.current.score))
        if not needed and not beats(state.blocks, state.current.score, reduced.score):
            enough = tested(reduced, seed, left)
            state = replace(state, current=reduced, enough=enough, done=enough.done)
    return state


def _arms(
    state: State, effects: Sequence[Effect], together: Sequence[Sequence[Effect]]
) -> tuple[list[Arm], dict[str, float], list[int]]:
    """Where the race begins: in every way of running the model, from what is known and from the rig as given.

    A nuisance that was tuned without the effect has gone as far as it could to make up for it; a rig is more likely
    near its file. Besides the arms, what each effect's scan promises, by name, and the ways.
    """
    known = state.current
    arms: list[Arm] = []
    promised: dict[str, float] = {}
    tuned = _known_in_each_way(state)
    for way, tuned_here in tuned.items():
        problem = state.ways[way].showing(known.effects)
        given = {name: value for name, value in known.fit.values.items() if "@" in name or "." in name}
        as_given = fit(problem, known.fit.parameters, given, iterations=1)
        for base, starts in ((tuned_here, 1), (as_given, STARTS)):
            candidates = screen(problem, base, effects)
            by_name = {candidate.effect.name: candidate for candidate in candidates}
            for candidate in candidates:
                promised[candidate.effect.name] = max(promised.get(candidate.effect.name, 0.0), candidate.promise)
                for start in candidate.starts[:starts]:
                    arms.append(Arm((*known.effects, candidate.effect), way, start, base))
            for chosen in together:
                if all(effect.name in by_name for effect in chosen):
                    arms.append(_joined(known.effects, chosen, by_name, way, base))
    for chosen in together:
        arms += _spread_out(state.ways[0], tuned[0], known.effects, chosen)
    return arms, promised, list(tuned)


def _known_in_each_way(state: State) -> dict[int, Fit]:
    """What is known, tuned in every way of running the model; once something was found, in that way alone.

    Which way foretells more without the effect says nothing of which does with it: a pull makes up for much of what is
    missing, and where it lets the nuisance go astray the free run is what finds the effect.
    """
    known = state.current
    tuned = {}
    for way, problem in enumerate(state.ways):
        if not state.steps or problem.how.pull == known.problem.how.pull:
            problem = problem.showing(known.effects)
            tuned[way] = fit(problem, known.fit.parameters, known.fit.values)
    return tuned


def _joined(
    known: Sequence[Effect], chosen: Sequence[Effect], by_name: dict[str, Candidate], way: int, base: Fit
) -> Arm:
    """An arm in which several effects start at once, each where it does alone."""
    start = dict(base.values)
    for effect in chosen:
        own = {parameter.name for parameter in effect.parameters}
        start |= {name: value for name, value in by_name[effect.name].starts[0].items() if name in own}
    return Arm((*known, *chosen), way, start, base)


def _spread_out(problem: Problem, tuned: Fit, known: Sequence[Effect], chosen: Sequence[Effect]) -> list[Arm]:
    """Arms of several effects at once, searched for widely: as long as one is missing the phase is off, and no scan of
    an effect alone leads there.
    """
    spans = {parameter.name: plausible(parameter) for parameter in tuned.parameters}
    for effect in chosen:
        for index, parameter in enumerate(effect.parameters):
            scanned = [point[index] for point in effect.scan]
            low, high = min(scanned), max(scanned)
            spans[parameter.name] = (0.3 * low if low > 0.0 else low, high)
    shows = problem.showing((*known, *chosen))
    return [Arm((*known, *chosen), 0, values, None) for values in wide(problem, shows, spans, tuned.values, seed=1)]


def _can_be_pulled(model: Model) -> bool:
    return isinstance(model, Pulled) and any(c.name == model.pulled for run in model.runs for c in run.channels)


__all__ = ["begin", "step"]
