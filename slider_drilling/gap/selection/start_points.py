"""Where a race begins: which effects, beside which fit, in which way of running the model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.global_search import global_search
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.race import FINALISTS, Arm
from slider_drilling.gap.search.screen import (
    STARTS,
    Scan,
    ScreenedEffect,
    rank_starts,
    scan_effects,
    screen,
    screen_pairs,
)
from slider_drilling.gap.selection.calibration import plausible_range
from slider_drilling.gap.selection.state import SearchState
from slider_drilling.process.parallel_map import parallel_map


@dataclass(frozen=True)
class StartPoint:
    """A fit that arms begin beside, in one way of running the model, and the scan of what may be added there; starts:
    places that an effect begins from.
    """

    mode: int
    scan: Scan
    start_count: int

    @property
    def base(self) -> Fit:
        return self.scan.base


def find_start_points(state: SearchState, effects: Sequence[Effect]) -> list[StartPoint]:
    """In every way of running the model, once something was found in that way alone: what is known, tuned, and the rig
    as given.

    Which way foretells more without the effect says nothing of which does with it: a pull makes up for much of what is
    missing, and where it lets the nuisance go astray the free run is what finds the effect. A nuisance that was tuned
    without the effect has gone as far as it could to make up for it; a rig is more likely near its file.
    """
    known = state.current
    given = {name: value for name, value in known.fit.values.items() if "@" in name or "." in name}

    def place(asked: tuple[int, bool]) -> StartPoint:
        way, tuned = asked
        problem = state.modes[way].at_fidelity_of(known.effects)
        begin, iterations = (known.fit.values, None) if tuned else (given, 1)
        base = fit(problem, known.fit.parameters, begin, iterations=iterations)
        return StartPoint(way, scan_effects(problem, base, effects), 1 if tuned else STARTS)

    return parallel_map(place, [(way, tuned) for way in state.active_modes for tuned in (True, False)])


def race_entries(
    state: SearchState, places: Sequence[StartPoint], together: Sequence[Sequence[Effect]]
) -> tuple[list[Arm], dict[str, float]]:
    """Every effect from several places, and those that the model wants together; besides the arms, what each effect's
    scan promises, by name.
    """
    known = state.current
    arms: list[Arm] = []
    promised: dict[str, float] = {}
    for place, candidates in zip(places, parallel_map(lambda place: screen(place.scan), places), strict=True):
        by_name = {candidate.effect.name: candidate for candidate in candidates}
        for candidate in candidates:
            promised[candidate.effect.name] = max(promised.get(candidate.effect.name, 0.0), candidate.predicted_gain)
            for start, simulated in rank_starts(place.scan, candidate)[: place.start_count]:
                arms.append(Arm((*known.effects, candidate.effect), place.mode, start, place.base, simulated))
        for chosen in together:
            if all(effect.name in by_name for effect in chosen):
                arms.append(_joined(known.effects, chosen, by_name, place))
    for chosen in together:
        arms += _spread_out(state.modes[0], places[0].base, known.effects, chosen)
    return arms, promised


def race_entries_of_pairs(places: Sequence[StartPoint], enough: float) -> list[Arm]:
    """The most promising pairs of effects beside re-tuning alone that may leave no more than enough, E."""
    found = parallel_map(lambda place: screen_pairs(place.scan, FINALISTS, enough), places)
    return [
        Arm(pair.effects, place.mode, pair.start, place.base)
        for place, pairs in zip(places, found, strict=True) for pair in pairs
    ]  # fmt: skip


def _joined(
    known: Sequence[Effect], chosen: Sequence[Effect], by_name: dict[str, ScreenedEffect], place: StartPoint
) -> Arm:
    """An arm in which several effects start at once, each where it does alone."""
    start = dict(place.base.values)
    for effect in chosen:
        own = {parameter.name for parameter in effect.parameters}
        start |= {name: value for name, value in by_name[effect.name].starts[0].items() if name in own}
    return Arm((*known, *chosen), place.mode, start, place.base)


def _spread_out(problem: Problem, tuned: Fit, known: Sequence[Effect], chosen: Sequence[Effect]) -> list[Arm]:
    """Arms of several effects at once, searched for widely: as long as one is missing the phase is off, and no scan of
    an effect alone leads there.
    """
    spans = {parameter.name: plausible_range(parameter) for parameter in tuned.parameters}
    for effect in chosen:
        for index, parameter in enumerate(effect.parameters):
            scanned = [point[index] for point in effect.scan]
            low, high = min(scanned), max(scanned)
            spans[parameter.name] = (0.3 * low if low > 0.0 else low, high)
    shows = problem.at_fidelity_of((*known, *chosen))
    return [
        Arm((*known, *chosen), 0, values, None) for values in global_search(problem, shows, spans, tuned.values, seed=1)
    ]
