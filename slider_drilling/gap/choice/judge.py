"""The finalists of a step are refitted, held out, and put to the tests that a name has to pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import comb

import numpy as np

from slider_drilling.gap.choice.other_runs import held_to_other_runs, told_in_other_runs_first
from slider_drilling.gap.choice.refit import (
    at_its_best,
    from_other_starts,
    no_less_likely,
    reached,
    scored_in,
    tested,
    unseen,
)
from slider_drilling.gap.choice.stand_in import far_off, kept_near, told_by_the_log
from slider_drilling.gap.choice.state import Explained, Judged, State
from slider_drilling.gap.choice.tuning import floors_lowered
from slider_drilling.gap.evidence.compare import (
    LEAST_SHARE,
    LEVEL,
    Blocks,
    beats,
    beyond_doubt,
    by_chance,
    closed_between,
    foretells_more,
    gaps,
    likelier_beyond_doubt,
    pays,
    shrinks,
)
from slider_drilling.gap.evidence.rivals import other_forms
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.noise import sigmas
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.finish import corrected, finished
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.race import Arm, finalists
from slider_drilling.process.parallel_map import parallel_map


def judge(
    state: State, ran: Sequence[Arm], left: Sequence[Effect], seed: int
) -> tuple[State, tuple[Judged, ...], bool]:
    """Refit the finalists in the way that foretells most, and hold them out against what is known so far; whether what
    was known is ruled out now, so that the race ran from the wrong place.

    Which way that is, the leader shows, corrected. Where it is not the one the state was scored in, what is known is
    scored anew in it.
    """
    sets, ways = finalists(ran), state.open_ways
    led = dict(zip(ways, parallel_map(lambda one: corrected(*reached(state, sets[0], one)), ways), strict=True))
    way = min(led, key=lambda one: led[one][1].cost)
    leader = led[way][1].cost
    before = state
    if state.current.problem.how.pull != state.ways[way].how.pull:
        state, _ = scored_in(state.ways[way], state)

    def refit(arms: Sequence[Arm]) -> Explained:
        near = led[way] if arms is sets[0] else corrected(*reached(state, arms, way))
        ended = finished(*near, leader=None if arms is sets[0] else leader)
        return unseen(*ended, arms[0].effects, state.blocks.folds)

    found = parallel_map(refit, sets)
    known = state.current
    state = at_its_best(state, min(found, key=lambda one: one.fit.cost), left, seed)
    if state.tuned is not before.tuned and state.tuned_enough is before.tuned_enough:
        state = replace(state, tuned_enough=tested(state.tuned, seed))
    found = parallel_map(lambda one: no_less_likely(state, one), found)
    judged = [_verdict(state, one, left, seed) for one in found]
    judged.sort(key=lambda one: one.explained.score.surprise)
    told = told_in_other_runs_first(beside_other_forms(state, judged))
    return state, told, _rules_out(state.current, known)


def beside_other_forms(state: State, judged: Sequence[Judged]) -> tuple[Judged, ...]:
    """The same, but for effects that foretell no more than another form of a law which is known would: a cause that is
    not quite the catalogue's leaves what something else can bend to.
    """
    idle = not state.current.effects or not any(one.passed for one in judged)
    forms = [] if idle else other_forms(state.current, state.blocks.folds)
    if not forms:
        return tuple(judged)

    def held(one: Judged) -> Judged:
        if not one.passed or beats(state.blocks, one.explained.score, forms[0].score, len(forms)):
            return one
        return replace(one, why_not=(f"another form of what is known explains as much: {forms[0].words}",))

    return tuple(held(one) for one in judged)


def with_new_floors(state: State, accepted: Judged, left: Sequence[Effect], seed: int) -> tuple[State, Judged]:
    """The same with floors that the better model shows: what were kinks of the signal had been taken for noise."""
    found = accepted.explained
    floors = floors_lowered(found.problem, found.fit, state.floors)
    ratios = [floors[p.run][p.name].sigma / state.floors[p.run][p.name].sigma for p in found.problem.pieces]
    if all(abs(np.log(ratio)) < LEAST_SHARE for ratio in ratios):
        return state, accepted
    free = build_problem(found.problem.model, [sigmas(own) for own in floors], spent=found.problem.spent)
    ways = tuple(free.run_as(problem.how) for problem in state.ways)
    problem = free.run_as(replace(found.problem.how, fidelity=free.how.fidelity))
    state, (again,) = scored_in(problem, state, [found])
    state = replace(state, floors=floors, ways=ways)
    return state, _verdict(state, again, left, seed)


def elsewhere(state: State, accepted: Judged, left: Sequence[Effect], seed: int) -> Judged | None:
    """The same from where other starts lead, None where that is no likelier or passes no more."""
    again = from_other_starts(state.way, accepted.explained, state.blocks.folds)
    if again is None:
        return None
    judged = _verdict(state, again, left, seed)
    return judged if judged.passed else None


def _rules_out(now: Explained, before: Explained) -> bool:
    """Whether the log rules out where the same effects were before: it is likelier now by more than as many parameters
    gain on noise (Wilks).
    """
    if now is before:
        return False
    there = fit(now.problem, now.fit.parameters, before.fit.values, iterations=0, known=now.fit.rows)
    return there.cost - now.fit.cost > by_chance(len(now.fit.parameters))


def _verdict(state: State, explained: Explained, left: Sequence[Effect], seed: int) -> Judged:
    """The tests of what is new in an explanation: it foretells more than what is known, it pays for its parameters, the
    gap shrinks by enough, in other runs too, its sign is its own. left: of which the new effects were chosen.
    """
    known, blocks = state.current, state.blocks
    new = [effect for effect in explained.effects if effect.name not in known.names]
    rivals = max(len(left), comb(len(left), len(new)))
    closed, interval = closed_between(blocks, known.score, explained.score)
    why = []
    if state.enough.adequate and not (
        beyond_doubt(explained.score, known.score, rivals) and likelier_beyond_doubt(explained.fit, known.fit, rivals)
    ):
        why.append("without it no more than noise is left, and the log does not show it beyond doubt")
    # Unseen stretches alone can favour an effect by what the refits without it happened to do there.
    if not pays(known.fit, explained.fit, rivals):
        why.append("the whole log is no likelier with it than free parameters make it by chance")
    if not shrinks(blocks, known.score, explained.score):
        why.append("the gap does not shrink for certain")
    for effect in new:
        if not effect.means_its_name(explained.fit.values):
            why.append(f"not what its name says: it would be {effect.nonphysical}")
    certain = foretells_more(blocks, explained.score, known.score, rivals)
    # Replicates are dear: they are made only where nothing else speaks against the effect.
    if not certain and (why or not _suffices(state, explained, rivals, seed)):
        why.insert(0, "foretells no more of unseen data than without it, at the level shared among all candidates")
    if _small(state, explained) and (why or not tested(explained, seed, left).done):
        why.append("nothing needs it: what it closes is next to nothing of what re-tuning left")
    judged = Judged(explained.effects[-1], explained, closed, interval, tuple(why), known.names)
    return held_to_other_runs(state, judged)


def _small(state: State, explained: Explained) -> bool:
    """Whether what is closed beyond what was enough already is next to nothing of what re-tuning left. That is worth a
    name only if something stood out in what was left, and nothing does any more.
    """
    gained = state.current.score.gap**2 - explained.score.gap**2
    return state.enough.adequate and not gained >= LEAST_SHARE * (state.tuned.score.gap**2 - 1.0)


def likelier(state: State, judged: Sequence[Judged], rivals: int) -> tuple[str, ...]:
    """Laws that make the whole log likelier than what is known for certain, with a nuisance that is not far off."""
    found = [
        one for one in judged
        if pays(state.current.fit, one.explained.fit, rivals) and one.effect.means_its_name(one.explained.fit.values)
        and not far_off(one.explained)
    ]  # fmt: skip
    return tuple(one.effect.name for one in sorted(found, key=lambda one: one.explained.fit.cost))


def judged_near(
    state: State, judged: Sequence[Judged], left: Sequence[Effect], seed: int
) -> tuple[State, tuple[Judged, ...], Judged | None]:
    """What a re-tuning that went far may stand for, held against one that is kept near: the state with that one, all
    that was judged, and who passes and is likelier by the log alone than the one that went far, None where nobody is or
    the one kept near is enough.
    """
    near = kept_near(state, left, seed)
    again = tuple(_kept_to(one, _verdict(near, one.explained, left, seed)) for one in judged)
    passed = [one for one in again if one.passed and told_by_the_log(state.current, one, len(left))]
    return near, again, None if near.enough.done or not passed else min(passed, key=lambda one: one.explained.fit.cost)


def _kept_to(before: Judged, held: Judged) -> Judged:
    """A verdict against re-tuning that is kept near, of which an effect that is not has no part."""
    if not far_off(before.explained):
        return held
    return replace(held, why_not=(*held.why_not, "with it re-tuning still goes farther from the model than is common"))


def _suffices(state: State, explained: Explained, rivals: int, seed: int) -> bool:
    """Whether an effect foretells more on the whole, shrinks the gap for certain at the level shared among all, and
    leaves no more than replicates of it do.

    A discrepancy forgives what is slow, so that a slow effect's gain is small in every stretch and one event outweighs
    it; the gap does not forgive. But many a wrong law shrinks a gap: only one that ends it is taken at that. What shows
    once in a log, resampled blocks hold as often as not: there the likelihood ratio has to be beyond doubt, and nothing
    at all may be left.
    """
    known, blocks = state.current.score, state.blocks
    if state.enough.within or explained.score.surprise >= known.surprise:
        return False
    everywhere = float(np.quantile(gaps(blocks, known) - gaps(blocks, explained.score), LEVEL / rivals)) > 0.0
    if not everywhere and not beyond_doubt(explained.score, known, rivals):
        return False
    left = tested(explained, seed)
    return left.within if everywhere else left.adequate


def group_of(blocks: Blocks, accepted: Judged, judged: Sequence[Judged]) -> tuple[str, ...]:
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
