"""Where a race begins: which effects, beside which fit, in which way of running the model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from slider_drilling.gap.choice.state import State
from slider_drilling.gap.choice.tuning import plausible
from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.race import FINALISTS, Arm
from slider_drilling.gap.search.screen import STARTS, Candidate, screen, screen_pairs
from slider_drilling.gap.search.wide import wide


def arms_of(
    state: State, effects: Sequence[Effect], together: Sequence[Sequence[Effect]]
) -> tuple[list[Arm], dict[str, float], list[int]]:
    """Every effect from several places, and those that the model wants together; besides the arms, what each effect's
    scan promises, by name, and the ways.
    """
    known = state.current
    arms: list[Arm] = []
    promised: dict[str, float] = {}
    tuned = _known_in_each_way(state)
    for way, base, starts in _bases(state, tuned):
        candidates = screen(state.ways[way].showing(known.effects), base, effects)
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


def arms_of_pairs(state: State, effects: Sequence[Effect]) -> list[Arm]:
    """The most promising pairs of effects beside re-tuning alone, each within what its name stands for."""
    named = [effect.as_named for effect in effects]
    return [
        Arm(pair.effects, way, pair.start, base)
        for way, base, _ in _bases(state, _known_in_each_way(state))
        for pair in screen_pairs(state.ways[way], base, named, FINALISTS)
    ]


def _bases(state: State, tuned: dict[int, Fit]) -> Iterator[tuple[int, Fit, int]]:
    """(way, fit to begin beside, places that an effect begins from): what is known, tuned; and the rig as given.

    A nuisance that was tuned without the effect has gone as far as it could to make up for it; a rig is more likely
    near its file.
    """
    known = state.current
    given = {name: value for name, value in known.fit.values.items() if "@" in name or "." in name}
    for way, tuned_here in tuned.items():
        problem = state.ways[way].showing(known.effects)
        yield way, tuned_here, 1
        yield way, fit(problem, known.fit.parameters, given, iterations=1), STARTS


def _known_in_each_way(state: State) -> dict[int, Fit]:
    """What is known, tuned in every way of running the model; once something was found, in that way alone.

    Which way foretells more without the effect says nothing of which does with it: a pull makes up for much of what is
    missing, and where it lets the nuisance go astray the free run is what finds the effect.
    """
    known = state.current
    tuned = {}
    for way, problem in enumerate(state.ways):
        if not known.effects or problem.how.pull == known.problem.how.pull:
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
