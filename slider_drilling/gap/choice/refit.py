"""What is known, fitted and scored again: in another problem, in another way, or from another place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.gap.choice.state import Explained, State
from slider_drilling.gap.choice.tuning import scattered, tuned_from
from slider_drilling.gap.evidence.adequacy import Adequacy, adequacy
from slider_drilling.gap.evidence.compare import pays
from slider_drilling.gap.evidence.score import Folds, Score, held_out, score_of
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.finish import corrected, fine, finished
from slider_drilling.gap.search.least_squares import TOLERANCE, Fit, fit, pace
from slider_drilling.gap.search.race import Arm
from slider_drilling.process.parallel_map import parallel_map


def scored(problem: Problem, effects: Sequence[Effect], found: Fit, folds: Folds) -> Explained:
    """A fit finished and held out."""
    return unseen(*finished(*corrected(problem, found)), effects, folds)


def unseen(exact: Problem, polished: Fit, effects: Sequence[Effect], folds: Folds) -> Explained:
    """A finished fit, held out."""
    return Explained(tuple(effects), exact, polished, held_out(exact, polished, folds))


def tested(explained: Explained, seed: int, effects: Sequence[Effect] = ()) -> Adequacy:
    """Whether an explanation is enough; effects: looked for in what it leaves."""
    return adequacy(explained.problem, explained.fit, explained.score, seed, effects, explained.effects)


def as_given(problem: Problem, tuned: Explained) -> Score:
    """Score of the model as given."""
    exact = problem.at({}, fine(problem.model))
    residual = exact.residuals([{}])[0]
    return score_of(exact, residual, replace(tuned.fit, discrepancy=exact.cost(residual)[1]))


def refitted(problem: Problem, known: Explained, folds: Folds) -> Explained:
    problem = problem.showing(known.effects)
    found = fit(problem, known.fit.parameters, known.fit.values)
    return scored(problem, known.effects, found, folds)


def scored_in(problem: Problem, state: State, others: Sequence[Explained] = ()) -> tuple[State, list[Explained]]:
    """The state with what is known fitted and scored again in another problem, and others likewise."""
    known = [state.tuned] if state.current is state.tuned else [state.tuned, state.current]
    again = parallel_map(lambda one: refitted(problem, one, state.blocks.folds), [*known, *others])
    tuned, current = again[0], again[len(known) - 1]
    return replace(state, tuned=tuned, current=current, nominal=as_given(problem, tuned)), again[len(known) :]


def at_its_best(state: State, leader: Explained, left: Sequence[Effect], seed: int) -> State:
    """The state with what is known fitted again from where the likeliest finalist got to, if that is likelier.

    A finalist began elsewhere too, and what it gains may be the other place's: what is known is held against it there,
    as far as it comes up with where it is.
    """
    known, freed = state.current, {parameter.name for parameter in state.current.fit.parameters}
    begin = {name: value for name, value in leader.fit.values.items() if name in freed}
    begun = fit(known.problem, known.fit.parameters, begin, iterations=0)
    again = fit(
        known.problem, begun.parameters, begin, tolerance=pace(begun.cost - known.fit.cost), simulated=begun.simulated,
        known=begun.rows, trusted=True,
    )  # fmt: skip
    if again.cost >= known.fit.cost - TOLERANCE:
        return state
    better = scored(state.way.showing(known.effects), known.effects, again, state.blocks.folds)
    if better.fit.cost >= known.fit.cost - TOLERANCE:
        return state
    enough = tested(better, seed, left)
    if known is not state.tuned:
        return replace(state, current=better, enough=enough)
    given = as_given(better.problem, better)
    return replace(state, nominal=given, tuned=better, current=better, enough=enough, tuned_enough=enough)


def no_less_likely(state: State, found: Explained) -> Explained:
    """An explanation that contains what is known, begun once more from there where it ended less likely: with what it
    adds where that had got to, and at nothing. Finished where it gains more than its added parameters do by chance.
    """
    known = state.current
    if found.fit.cost <= known.fit.cost:
        return found
    own = {p.name for effect in found.effects if effect.name not in known.names for p in effect.parameters}
    added = {name: value for name, value in found.fit.values.items() if name in own}
    near = known.problem.showing(found.effects)
    begun = tuned_from(near, [known.fit.values | added, known.fit.values], found.fit.parameters)
    if not pays(known.fit, begun):
        return found
    again = scored(state.way.showing(found.effects), found.effects, begun, state.blocks.folds)
    return min(found, again, key=lambda one: one.fit.cost)


def from_other_starts(way: Problem, known: Explained, folds: Folds) -> Explained | None:
    """An explanation fitted again from other places of its nuisance, None where none of them leads to a likelier one.

    Strokes of rocking hide how the string was wound at the beginning: a fit that began near one winding stays there.
    """
    own = {parameter.name for effect in known.effects for parameter in effect.parameters}
    problem, freed = way.showing(known.effects), known.fit.parameters
    nuisance = [parameter for parameter in freed if parameter.name not in own]
    here = fit(problem, freed, known.fit.values, iterations=0)
    again = tuned_from(problem, [here.values, *scattered(problem, here, nuisance)], freed)
    if again.cost >= here.cost - TOLERANCE:
        return None
    better = scored(problem, known.effects, again, folds)
    return better if better.fit.cost < known.fit.cost - TOLERANCE else None


def reached(state: State, own: Sequence[Arm], way: int) -> tuple[Problem, Fit]:
    """The best fit of a set in one way of running the model: its own arm's, or one that goes on from another way's."""
    problem = state.ways[way].showing(own[0].effects)
    fits = [arm.fit for arm in own if arm.way == way and arm.fit is not None]
    if own[0].way != way and own[0].fit is not None:
        fits.append(fit(problem, own[0].fit.parameters, own[0].fit.values))
    return problem, min(fits, key=lambda one: one.cost)
