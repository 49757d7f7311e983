"""Where a race starts: which effects, beside which fit, and in which simulation mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import NamedTuple

from slider_drilling.gap.model import Effect
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.global_search import first_part, global_search
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.multi_start import plausible_range
from slider_drilling.gap.search.race import FINALISTS, Arm, parameters_of
from slider_drilling.gap.search.screen import (
    STARTS,
    Scan,
    ScreenedEffect,
    rank_starts,
    scan_effects,
    screen,
    screen_pairs,
)
from slider_drilling.gap.selection.state import SearchState
from slider_drilling.process.parallel_map import parallel_map


class _GridRound(NamedTuple):
    """Short fits from the points of a grid: iterations, first part of the runs that counts, and how many go on."""

    iterations: int
    fraction: float
    kept: int


_GRID_ROUNDS = (_GridRound(1, 0.5, 10), _GridRound(3, 1.0, STARTS))


@dataclass(frozen=True)
class StartPoint:
    """A fit that arms start beside.

    Attributes:
        mode: Index of the simulation mode.
        scan: Scan of the effects that may be added there.
        calibrated: Whether its nuisance is calibrated, or as given.
    """

    mode: int
    scan: Scan
    calibrated: bool

    @property
    def base(self) -> Fit:
        """The fit."""
        return self.scan.base


def find_start_points(state: SearchState, effects: Sequence[Effect]) -> list[StartPoint]:
    """In every active simulation mode: the current model, and the same effects with the nuisance as given.

    The mode that predicts better without an effect need not do so with it: an observer makes up for much of what is
    missing, and where it lets the nuisance go astray the free run finds the effect. A nuisance that was calibrated
    without the effect has moved to make up for it, while the real system is more likely near the model as given.

    Args:
        state: State of the search.
        effects: Effects that may be added.
    """
    current, as_given = state.current, _as_given(state)

    def start_point(choice: tuple[int, bool]) -> StartPoint:
        mode, calibrated = choice
        problem = state.modes[mode].at_fidelity_of(current.effects)
        start, iterations = (current.fit.values, None) if calibrated else (as_given, 1)
        base = fit(problem, current.fit.parameters, start, iterations=iterations)
        return StartPoint(mode, scan_effects(problem, base, effects), calibrated)

    choices = [(mode, calibrated) for mode in state.active_modes for calibrated in (True, False)]
    return parallel_map(start_point, choices)


def _as_given(state: SearchState) -> dict[str, float]:
    """The current values without the calibrated ones: what belongs to a run ("@") or to an effect (".") is kept."""
    return {name: value for name, value in state.current.fit.values.items() if "@" in name or "." in name}


def race_entries(
    state: SearchState,
    start_points: Sequence[StartPoint],
    coupled: Sequence[Sequence[Effect]],
) -> tuple[list[Arm], dict[str, float]]:
    """The arms of a race.

    Args:
        state: State of the search.
        start_points: Fits to start beside.
        coupled: Sets of effects that also start together.

    Returns:
        One arm for each start of each effect and set; and by name of effect the gain of ``-2 log p`` that its scan
        predicts.
    """
    known = state.current.effects
    arms: list[Arm] = []
    predicted_gain: dict[str, float] = {}
    screens = parallel_map(lambda point: screen(point.scan), start_points)
    for point, screened in zip(start_points, screens, strict=True):
        by_name = {each.effect.name: each for each in screened}
        for each in screened:
            name = each.effect.name
            predicted_gain[name] = max(predicted_gain.get(name, 0.0), each.predicted_gain)
            for start, simulated in rank_starts(point.scan, each)[: 1 if point.calibrated else STARTS]:
                arms.append(Arm((*known, each.effect), point.mode, start, point.base, simulated))
        for effects in coupled:
            if all(effect.name in by_name for effect in effects):
                arms.append(_joint_arm(known, effects, by_name, point))
    bases = {point.mode: point.base for point in start_points if point.calibrated}
    for effects in coupled:
        for mode, base in bases.items():
            arms += _global_arms(state, mode, base, known, effects)
    return arms, predicted_gain


def race_entries_of_pairs(start_points: Sequence[StartPoint], threshold: float) -> list[Arm]:
    """Arms of the most promising pairs of effects, beside calibration alone.

    Args:
        start_points: Fits to start beside.
        threshold: E that the pair may leave.
    """
    screens = parallel_map(lambda point: screen_pairs(point.scan, FINALISTS, threshold), start_points)
    return [
        Arm(pair.effects, point.mode, pair.start, point.base)
        for point, pairs in zip(start_points, screens, strict=True) for pair in pairs
    ]  # fmt: skip


def _joint_arm(
    known: Sequence[Effect], effects: Sequence[Effect], by_name: dict[str, ScreenedEffect], point: StartPoint
) -> Arm:
    """An arm in which several effects start together, each where it would start alone."""
    start = dict(point.base.values)
    for effect in effects:
        own = {parameter.name for parameter in effect.parameters}
        start |= {name: value for name, value in by_name[effect.name].starts[0].items() if name in own}
    return Arm((*known, *effects), point.mode, start, point.base)


def grid_arms(state: SearchState, conditional: Sequence[Effect]) -> list[Arm]:
    """Arms in which all conditional nuisance starts together: the best of short fits from the points of a grid.

    The grid has every other point of each scan: with all of them it would be five times as large.

    One number alone may leave as much as before while another is wrong too, and a start alone does not show how near
    an optimum is. All else starts as given: from a calibration that has made up for it no fit finds back.

    Args:
        state: State of the search.
        conditional: Conditional nuisance, at least two.
    """
    effects, mode = (*state.current.effects, *conditional), state.active_modes[0]
    problem = state.modes[mode].at_fidelity_of(effects)
    freed = parameters_of(problem, effects)

    def advanced(arm: Arm, part: Problem, iterations: int) -> Arm:
        values = arm.start if arm.fit is None else arm.fit.values
        return replace(arm, fit=fit(part, freed, values, iterations=iterations))

    arms = []
    for scanned in product(*(effect.scan[::2] for effect in conditional)):
        start = _as_given(state)
        for effect, point in zip(conditional, scanned, strict=True):
            start |= effect.values(point)
        arms.append(Arm(effects, mode, start, None))
    for stage in _GRID_ROUNDS:
        advance = partial(advanced, part=first_part(problem, stage.fraction), iterations=stage.iterations)
        arms = sorted(parallel_map(advance, arms), key=lambda arm: arm.cost)[: stage.kept]
    return arms


def _global_arms(
    state: SearchState, mode: int, calibrated: Fit, known: Sequence[Effect], effects: Sequence[Effect]
) -> list[Arm]:
    """Arms of several effects together, from a global search in one simulation mode.

    While one of the effects is missing the phase is off, so that no scan of a single effect leads there. Fed back, a
    simulation keeps the phase where a free run has lost it, and the search sees the way to an optimum.
    """
    problem = state.modes[mode]
    spans = {parameter.name: plausible_range(parameter) for parameter in calibrated.parameters}
    for effect in effects:
        for index, parameter in enumerate(effect.parameters):
            scanned = [point[index] for point in effect.scan]
            low, high = min(scanned), max(scanned)
            spans[parameter.name] = (0.3 * low if low > 0.0 else low, high)
    fine = problem.at_fidelity_of((*known, *effects))
    starts = global_search(problem, fine, spans, calibrated.values, seed=1)
    return [Arm((*known, *effects), mode, values, None) for values in starts]
