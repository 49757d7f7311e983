"""From one explanation to the next: re-tune, then add the effect that foretells most, for as long as one is needed.

`begin` gives the first state and `step` the next; neither changes what it was given, so an interrupt leaves the last
state whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from slider_drilling.gap.choice.state import Explained, Judged, State, Step
from slider_drilling.gap.choice.tuning import TUNING, floors_lowered, floors_raised, plausible, scattered, tuned_from
from slider_drilling.gap.evidence.adequacy import adequacy
from slider_drilling.gap.evidence.compare import LEVEL, Blocks, beats, closed_between, gaps, make_blocks
from slider_drilling.gap.evidence.score import Folds, Score, held_out, make_folds, score_of
from slider_drilling.gap.model import Effect, How, Model, Pulled, Values
from slider_drilling.gap.problem.noise import NoiseFloor, sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.at_once import at_once
from slider_drilling.gap.search.finish import POLISH, fine, finished
from slider_drilling.gap.search.least_squares import TOLERANCE, Fit, fit
from slider_drilling.gap.search.race import Arm, begun_again, finalists, parameters_of, race
from slider_drilling.gap.search.screen import Candidate, screen
from slider_drilling.gap.search.wide import wide

Report = Callable[[str, float], None]

# Gain of the weak observer (see `slider_drilling.gap.model.Pulled`).
PULL = 0.3
# An effect is worth a name if it closes at least this share of the gap.
LEAST_SHARE = 0.05
# Effects that may be named together.
MOST_EFFECTS = 3
# A floor that falls or rises by less is the same.
_SAME_FLOOR = 0.95


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
    floors = floors_raised(*finished(free, tuned), floors, seed)
    free = build_problem(model, [sigmas(own) for own in floors], spent=free.spent)
    tuned = fit(free, tuned.parameters, tuned.values, iterations=1)
    explained = _explained(free, (), tuned, blocks.folds)
    enough = adequacy(explained.problem, explained.fit, explained.score, seed, effects)
    if not enough.done:
        report("re-tuning from other starts", 0.06)
        again = tuned_from(free, scattered(free, tuned))
        if again.cost < tuned.cost:
            explained = _explained(free, (), again, blocks.folds)
            enough = adequacy(explained.problem, explained.fit, explained.score, seed, effects)
    given = _as_given(free, explained)
    good = given.gap <= enough.threshold and all(given.by_channel[c] <= v for c, v in enough.by_channel.items())
    ways = (free, free.run_as(How(0, PULL))) if _can_be_pulled(model) else (free,)
    return State(
        tuple(floors), ways, given, explained, explained, enough, enough, good, blocks, done=enough.done,
    )  # fmt: skip


def step(
    state: State, effects: Sequence[Effect], together: Sequence[Sequence[Effect]], seed: int, report: Report
) -> State:
    """Race the effects that may come next, judge the finalists on unseen data, and accept the best that passes."""
    had = {one.accepted.effect.name for one in state.steps if one.accepted is not None}
    left = [effect for effect in effects if effect.name not in had]
    if not left or len(state.current.effects) >= MOST_EFFECTS:
        return replace(state, done=True)
    turn = len(state.steps)
    report(f"racing {len(left)} effects" + (f", step {turn + 1}" if turn else ""), min(0.1 + 0.3 * turn, 0.8))
    arms, promised, ways = _arms(state, left, together if turn == 0 else ())
    ran = begun_again(state.ways, race(state.ways, arms))
    report("judging the finalists", min(0.25 + 0.3 * turn, 0.9))
    before = state.current
    state, judged = _judge(state, ran, ways, left, seed)
    for one in judged:
        if one.passed:
            group = _group(state.blocks, one, judged)
            refloored, accepted = _refloored(state, one, len(left), seed)
            judged = tuple(accepted if other is one else other for other in judged)
            if accepted.passed:
                taken = _with(refloored, Step(judged, accepted, group, promised), left, seed)
                return _without_needless(taken, left, seed)
    if state.current.names == before.names and beats(state.blocks, state.current.score, before.score):
        # The race ran from a worse place than is known by now.
        return replace(state, done=state.enough.done)
    return replace(state, steps=(*state.steps, Step(judged, None, (), promised)), done=True)


def _with(state: State, taken: Step, left: Sequence[Effect], seed: int) -> State:
    """The state with one more effect in it; left: those that it was chosen from."""
    assert taken.accepted is not None
    found = taken.accepted.explained
    others = [effect for effect in left if effect.name not in found.names]
    enough = adequacy(found.problem, found.fit, found.score, seed, others)
    return replace(state, current=found, enough=enough, steps=(*state.steps, taken), done=enough.done)


def _without_needless(state: State, left: Sequence[Effect], seed: int) -> State:
    """The state without an earlier effect that the newest makes needless: without it nothing is foretold worse, and the
    gap does not grow for certain.
    """
    for earlier in state.current.effects[:-1]:
        rest = tuple(effect for effect in state.current.effects if effect is not earlier)
        own = {parameter.name for parameter in earlier.parameters}
        way = next(way for way in state.ways if way.how.pull == state.current.problem.how.pull)
        problem = way.showing(rest)
        begin = {name: value for name, value in state.current.fit.values.items() if name not in own}
        found = fit(problem, parameters_of(problem, rest), begin, iterations=TUNING)
        reduced = _explained(problem, rest, found, state.blocks.folds)
        shrinks = closed_between(state.blocks, reduced.score, state.current.score)[1][0] > 0.0
        if not shrinks and not beats(state.blocks, state.current.score, reduced.score):
            enough = adequacy(reduced.problem, reduced.fit, reduced.score, seed, left)
            state = replace(state, current=reduced, enough=enough, done=enough.done)
    return state


def _judge(
    state: State, ran: Sequence[Arm], ways: Sequence[int], left: Sequence[Effect], seed: int
) -> tuple[State, tuple[Judged, ...]]:
    """Refit the finalists in the way that foretells most, and hold them out against what is known so far.

    Which way that is, the leader shows where it is finished. Where it is not the one the state was scored in, what is
    known is scored anew in it.
    """
    folds = state.blocks.folds
    sets = finalists(ran)
    led = dict(zip(ways, at_once(lambda one: finished(*_reached(state, sets[0], one)), ways), strict=True))
    way = min(led, key=lambda one: led[one][1].cost)
    if state.current.problem.how.pull != state.ways[way].how.pull:
        state = _in_way(state, state.ways[way], seed)

    def explained(arms: Sequence[Arm]) -> Explained:
        problem, found = led[way] if arms is sets[0] else finished(*_reached(state, arms, way))
        return Explained(arms[0].effects, problem, found, held_out(problem, found, folds))

    found = at_once(explained, sets)
    state = _at_its_best(state, min(found, key=lambda one: one.fit.cost), left, seed)
    judged = [_verdict(state, one, len(left), seed) for one in found]
    judged.sort(key=lambda one: float(np.sum(one.explained.score.density)))
    return state, tuple(judged)


def _at_its_best(state: State, leader: Explained, left: Sequence[Effect], seed: int) -> State:
    """The state with what is known fitted again from where the likeliest finalist got to, if that is likelier.

    A finalist began elsewhere too, and what it gains may be the other place's: what is known is held against it there.
    """
    known, freed = state.current, {parameter.name for parameter in state.current.fit.parameters}
    begin = {name: value for name, value in leader.fit.values.items() if name in freed}
    again = fit(known.problem, known.fit.parameters, begin, iterations=TUNING)
    if again.cost >= known.fit.cost - TOLERANCE:
        return state
    way = next(way for way in state.ways if way.how.pull == known.problem.how.pull)
    better = _explained(way.showing(known.effects), known.effects, again, state.blocks.folds)
    if better.fit.cost >= known.fit.cost - TOLERANCE:
        return state
    enough = adequacy(better.problem, better.fit, better.score, seed, left)
    if known is not state.tuned:
        return replace(state, current=better, enough=enough)
    given = _as_given(better.problem, better)
    return replace(state, nominal=given, tuned=better, current=better, enough=enough, tuned_enough=enough)


def _reached(state: State, own: Sequence[Arm], way: int) -> tuple[Problem, Fit]:
    """The best fit of a set in one way of running the model: its own arm's, or one that goes on from another way's."""
    problem = state.ways[way].showing(own[0].effects)
    fits = [arm.fit for arm in own if arm.way == way and arm.fit is not None]
    if own[0].way != way and own[0].fit is not None:
        fits.append(fit(problem, own[0].fit.parameters, own[0].fit.values, iterations=TUNING))
    return problem, min(fits, key=lambda one: one.cost)


def _refloored(state: State, accepted: Judged, rivals: int, seed: int) -> tuple[State, Judged]:
    """The same with floors that the better model shows: what were kinks of the signal had been taken for noise."""
    found = accepted.explained
    floors = floors_lowered(found.problem, found.fit, state.floors)
    ratios = [floors[p.run][p.name].sigma / state.floors[p.run][p.name].sigma for p in found.problem.pieces]
    if all(_SAME_FLOOR < ratio < 1.0 / _SAME_FLOOR for ratio in ratios):
        return state, accepted
    free = build_problem(found.problem.model, [sigmas(own) for own in floors], spent=found.problem.spent)
    ways = tuple(free.run_as(problem.how) for problem in state.ways)
    problem = free.run_as(replace(found.problem.how, fidelity=free.how.fidelity))
    folds = state.blocks.folds
    state = replace(_scored_in(problem, state, POLISH), floors=floors, ways=ways)
    return state, _verdict(state, _refitted(problem, found, folds, POLISH), rivals, seed)


def _scored_in(problem: Problem, state: State, iterations: int) -> State:
    """The state with what is known fitted and scored again, in another problem."""
    folds = state.blocks.folds
    tuned = _refitted(problem, state.tuned, folds, iterations)
    current = tuned if state.current is state.tuned else _refitted(problem, state.current, folds, iterations)
    return replace(state, tuned=tuned, current=current, nominal=_as_given(problem, tuned))


def _refitted(problem: Problem, known: Explained, folds: Folds, iterations: int) -> Explained:
    problem = problem.showing(known.effects)
    found = fit(problem, known.fit.parameters, known.fit.values, iterations=iterations)
    return _explained(problem, known.effects, found, folds)


def _as_given(problem: Problem, tuned: Explained) -> Score:
    """Score of the model as given."""
    exact = problem.at({}, fine(problem.model))
    residual = exact.residuals([{}])[0]
    return score_of(exact, residual, replace(tuned.fit, discrepancy=exact.cost(residual)[1]))


def _verdict(state: State, explained: Explained, rivals: int, seed: int) -> Judged:
    """The tests of an effect: it foretells more than what is known, it pays for its parameters, the gap shrinks by
    enough, its sign is its own.
    """
    known, blocks = state.current, state.blocks
    effect = explained.effects[-1]
    closed, interval = closed_between(blocks, known.score, explained.score)
    why = []
    if not (beats(blocks, explained.score, known.score, rivals) or _suffices(state, explained, rivals, seed)):
        why.append("foretells no more of unseen data than without it, at the level shared among all candidates")
    if not _pays(known, explained, rivals):
        why.append("the whole log is no likelier with it than free parameters make it by chance")
    if not (closed >= LEAST_SHARE and interval[0] > 0.0):
        why.append("the gap does not shrink for certain")
    gained = known.score.gap**2 - explained.score.gap**2
    if state.enough.adequate and not gained >= LEAST_SHARE * (state.tuned.score.gap**2 - 1.0):
        why.append("nothing needs it: what it closes is next to nothing of what re-tuning left")
    if not effect.means_its_name(explained.fit.values):
        why.append(f"not what its name says: it would be {effect.nonphysical}")
    return Judged(effect, explained, closed, interval, tuple(why))


def _pays(known: Explained, explained: Explained, rivals: int) -> bool:
    """Whether the likelihood ratio over the whole log is more than its added parameters gain on noise (Wilks), at the
    level shared among all.

    Unseen stretches alone can favour an effect by what the refits without it happened to do there.
    """
    added = len(explained.fit.parameters) - len(known.fit.parameters)
    return known.fit.cost - explained.fit.cost > float(chi2.ppf(1.0 - LEVEL / rivals, max(added, 1)))


def _suffices(state: State, explained: Explained, rivals: int, seed: int) -> bool:
    """Whether an effect foretells more on the whole, shrinks the gap for certain at the level shared among all, and
    leaves no more than replicates of it do.

    A discrepancy forgives what is slow, so that a slow effect's gain is small in every stretch and one event outweighs
    it; the gap does not forgive. But many a wrong law shrinks a gap: only one that ends it is taken at that.
    """
    known, blocks = state.current.score, state.blocks
    shrinks = float(np.quantile(gaps(blocks, known) - gaps(blocks, explained.score), LEVEL / rivals)) > 0.0
    if not shrinks or float(np.sum(explained.score.density)) >= float(np.sum(known.density)) or state.enough.within:
        return False
    return adequacy(explained.problem, explained.fit, explained.score, seed).within


def _group(blocks: Blocks, accepted: Judged, judged: Sequence[Judged]) -> tuple[str, ...]:
    """Finalists that pass and that the one accepted does not beat by both measures: what it foretells, and the gap.

    A density that is certainly better beside a gap that is not tells a better description of what is left, not a cause.
    """
    rivals = [one for one in judged if one is not accepted and one.passed]
    level = LEVEL / max(len(rivals), 1)
    mine = accepted.explained

    def told_apart(rival: Explained) -> bool:
        wider = gaps(blocks, rival.score) - gaps(blocks, mine.score)
        return beats(blocks, mine.score, rival.score, len(rivals)) and float(np.quantile(wider, level)) > 0.0

    return tuple(one.effect.name for one in rivals if not told_apart(one.explained))


def _in_way(state: State, problem: Problem, seed: int) -> State:
    """The state with what is known fitted and scored in another way of running the model."""
    state = _scored_in(problem, state, TUNING)
    tuned = state.tuned
    return replace(state, tuned_enough=adequacy(tuned.problem, tuned.fit, tuned.score, seed))


def _explained(problem: Problem, effects: Sequence[Effect], found: Fit, folds: Folds) -> Explained:
    """A fit finished and held out."""
    exact, polished = finished(problem, found)
    return Explained(tuple(effects), exact, polished, held_out(exact, polished, folds))


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
        for base, starts in ((tuned_here, 1), (as_given, 2)):
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
            tuned[way] = fit(problem, known.fit.parameters, known.fit.values, iterations=TUNING // 2)
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
    return [Arm((*known, *chosen), 0, values, None) for values in wide(problem, spans, tuned.values, seed=1)]


def _can_be_pulled(model: Model) -> bool:
    return isinstance(model, Pulled) and any(c.name == model.pulled for run in model.runs for c in run.channels)


__all__ = ["begin", "step"]
