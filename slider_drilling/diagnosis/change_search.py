"""Search for what has changed: every candidate is scanned, the most promising are fitted beside the baseline."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.diagnosis.baseline import Baseline
from slider_drilling.diagnosis.changed_string import ChangedString
from slider_drilling.diagnosis.rig_changes import changes_of_number, opposite_of
from slider_drilling.diagnosis.start_state import fit_start_state
from slider_drilling.diagnosis.usual_error import problem_in_units, usual_gap
from slider_drilling.gap.model import Effect, Parameter
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, KnownStart, fit, linearised_at_its_end
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.search.screen import ScreenedEffect, rank_starts, scan_effects, screen

# Candidates that are fitted, of all that are scanned; the first of them from two starts.
_FITTED, _FROM_TWO_STARTS = 6, 3
_BOTH_SHAPES = 2  # of the best candidates of the right sign are fitted as a step and as a ramp
# Calibration is tried again from where so many of the best candidates ended, of those that gain so much.
_STARTS, _WORTH_A_START = 2, 20.0
_MOVED = 2.5  # standard deviations of what a number may wander, from which its change is a candidate
# Standard deviations of what a calibrated number wanders, beyond which a candidate needs a second change beside it; and
# the share of its gain that a candidate keeps within them, if it needs none.
_WANDERED, _KEPT = 3.0, 0.8


@dataclass(frozen=True)
class TriedChange:
    """One candidate, fitted together with what the baseline leaves open.

    Attributes:
        effect: The candidate.
        growing: Whether it grows from the start of the log to its end.
        problem: The problem of its fit.
        fit: The fit.
        gain: ``-2 log p`` that it gains beyond calibration, less what it gains where nothing has changed.
    """

    effect: Effect
    growing: bool
    problem: Problem = field(repr=False)
    fit: Fit = field(repr=False)
    gain: float

    @property
    def gap(self) -> float:
        """E that it leaves, in the baseline's noise."""
        return usual_gap(self.problem, self.fit.residual)


@dataclass(frozen=True)
class ChangeSearch:
    """What the search found.

    Attributes:
        problem: The problem without changes.
        unchanged: The baseline's model: only the state at the start of each log is fitted.
        calibrated: With calibrated numbers as far off as they wander.
        tried: Fitted candidates, largest gain first.
        scanned: Gain that the scan predicted, by candidate.
        seen_in: Channel in which change detection saw the difference, None if unknown.
    """

    problem: Problem = field(repr=False)
    unchanged: Fit = field(repr=False)
    calibrated: Fit = field(repr=False)
    tried: tuple[TriedChange, ...]
    scanned: Mapping[str, float]
    seen_in: str | None = None


def search_change(model: ChangedString, baseline: Baseline) -> ChangeSearch:
    """Fit the baseline's model to later logs, then whatever may have changed.

    Args:
        model: Of the later logs.
        baseline: What they share with the earlier ones.
    """
    problem = problem_in_units(model, baseline.noise)
    unchanged = fit_start_state(problem)
    calibrated = linearised_at_its_end(problem, fit(problem, parameters_of(problem, ()), unchanged.values))
    entries, scanned = _scan(problem, calibrated, model, baseline.chance_gains)
    first = _moved_numbers(calibrated, model)
    names = {each.effect.name for each in first}
    entries = [(each, False) for each in first] + [entry for entry in entries if entry[0].effect.name not in names]
    tried = [
        _fit_change(problem, calibrated, each, growing, rank < _FROM_TWO_STARTS, baseline.chance_gains)
        for rank, (each, growing) in enumerate(entries[: _FITTED + len(first)])
    ]
    tried = under_their_names(tried, model.effects)
    again = calibrated_again(problem, calibrated, tried)
    tried = [replace(each, gain=each.gain - calibrated.cost + again.cost) for each in tried]
    calibrated = again
    likely = worth_both_shapes(tried)
    tried = [
        _in_better_shape(problem, calibrated, each, baseline.chance_gains) if each.effect.name in likely else each
        for each in tried
    ]
    tried = sorted((within_wander(each, calibrated) for each in tried), key=lambda each: -each.gain)
    return ChangeSearch(problem, unchanged, calibrated, tuple(tried), scanned)


def under_their_names(tried: Sequence[TriedChange], effects: Sequence[Effect]) -> list[TriedChange]:
    """The candidates, each under the name that its sign has: a plugged nozzle that lowers the pressure is a washout.

    Of two with the same name then, the one that gains more.
    """
    by_name = {effect.name: effect for effect in effects}
    best: dict[str, TriedChange] = {}
    for each in tried:
        opposite = opposite_of(each.effect.name)
        other = None if opposite is None else by_name.get(opposite.name)
        named = each if other is None or each.effect.is_physical(each.fit.values) else _turned(each, other)
        if named.effect.name not in best or named.gain > best[named.effect.name].gain:
            best[named.effect.name] = named
    return list(best.values())


def _turned(tried: TriedChange, other: Effect) -> TriedChange:
    """The same fit in terms of a change that multiplies the same numbers the other way."""
    own, new = tried.effect.parameters[0], other.parameters[0]
    values = {name: value for name, value in tried.fit.values.items() if name != own.name}
    index = [parameter.name for parameter in tried.fit.parameters].index(own.name)
    parameters, jacobian = list(tried.fit.parameters), tried.fit.jacobian.copy()
    parameters[index], jacobian[index] = new, -jacobian[index] * new.scale / own.scale
    turned = replace(
        tried.fit, values=values | {new.name: -tried.fit.values[own.name]}, parameters=tuple(parameters),
        jacobian=jacobian,
    )  # fmt: skip
    return replace(tried, effect=other, fit=turned)


def calibrated_again(problem: Problem, calibrated: Fit, tried: Sequence[TriedChange]) -> Fit:
    """The calibration, or a better one from where the best candidates ended: what it misses, any candidate gains."""
    best = sorted((each for each in tried if each.gain > _WORTH_A_START), key=lambda each: -each.gain)[:_STARTS]
    fits = []
    for each in best:
        own = {parameter.name: parameter.nominal for parameter in each.effect.parameters}
        fits.append(fit(problem, calibrated.parameters, each.fit.values | own))
    found = min((calibrated, *fits), key=lambda each: each.cost)
    return found if found is calibrated else linearised_at_its_end(problem, found)


def worth_both_shapes(tried: Sequence[TriedChange]) -> list[str]:
    """Names of the candidates that are fitted as a step and as a ramp: the best that may be named by their sign."""
    physical = [each for each in tried if each.effect.is_physical(each.fit.values)]
    return [each.effect.name for each in sorted(physical, key=lambda each: -each.gain)[:_BOTH_SHAPES]]


def only_wandered(calibrated: Fit) -> bool:
    """Whether no calibrated number is farther from the baseline than it wanders."""
    shared = _shared(calibrated)
    return all(abs(calibrated.values[each.name] - each.nominal) <= _WANDERED * each.spread for each in shared)


def changed_beside(tried: TriedChange, calibrated: Fit) -> str:
    """A calibrated number that a candidate moves beyond three standard deviations, and beyond calibration; or empty."""
    values = tried.fit.values
    for each in _beside(tried, calibrated):
        # A fit at its bound is not beyond it, whatever its last digit.
        if each.name in values and abs(values[each.name] - each.nominal) > 1.001 * _farthest(each, calibrated):
            return each.name
    return ""


def _shared(calibrated: Fit) -> list[Parameter]:
    """The calibrated numbers, without those of a single run."""
    return [each for each in calibrated.parameters if "@" not in each.name]


def _beside(tried: TriedChange, calibrated: Fit) -> list[Parameter]:
    """The calibrated numbers beside a candidate: those that are not its own, as a standing effect's may be."""
    own = {each.name for each in tried.effect.parameters}
    return [each for each in _shared(calibrated) if each.name not in own]


def _farthest(parameter: Parameter, calibrated: Fit) -> float:
    """How far from the baseline a calibrated number may be beside a candidate."""
    alone = abs(calibrated.values[parameter.name] - parameter.nominal)
    return max(_WANDERED * parameter.spread, alone + parameter.spread)


def within_wander(tried: TriedChange, calibrated: Fit) -> TriedChange:
    """The candidate with calibrated numbers no farther off than they wander, where it explains nearly as much so.

    A fit may push a number farther for little: that does not mean that the candidate needs it.
    """
    if not changed_beside(tried, calibrated):
        return tried
    spans = {each.name: _farthest(each, calibrated) for each in _beside(tried, calibrated)}
    narrow = [_narrowed(each, spans.get(each.name, math.inf)) for each in tried.fit.parameters]
    start = {each.name: float(np.clip(tried.fit.values[each.name], each.lower, each.upper)) for each in narrow}
    found = fit(tried.problem, narrow, tried.fit.values | start)
    gain = tried.gain + tried.fit.cost - found.cost
    return replace(tried, fit=found, gain=gain) if gain >= _KEPT * tried.gain else tried


def _narrowed(parameter: Parameter, span: float) -> Parameter:
    """The parameter, no farther from its nominal value than a span."""
    low, high = parameter.nominal - span, parameter.nominal + span
    return replace(parameter, lower=max(parameter.lower, low), upper=min(parameter.upper, high))


def _moved_numbers(calibrated: Fit, model: ChangedString) -> list[ScreenedEffect]:
    """Changes of the rig's numbers for which calibration has moved: their fits start from there, the number unmoved."""
    by_name = {effect.name: effect for effect in model.effects}
    starts = []
    for parameter in calibrated.parameters:
        moved = calibrated.values[parameter.name] - parameter.nominal
        if abs(moved) < _MOVED * parameter.spread or parameter.nominal == 0.0:
            continue
        for name, share in changes_of_number(parameter.name, moved / parameter.nominal).items():
            effect = by_name.get(name)
            if effect is not None:
                start = calibrated.values | {parameter.name: parameter.nominal, effect.parameters[0].name: share}
                start |= effect.values((share, *effect.scan[0][1:]))
                starts.append(ScreenedEffect(effect, 0.0, (start,)))
    return list({each.effect.name: each for each in starts}.values())


def _scan(
    problem: Problem, calibrated: Fit, model: ChangedString, chance: Mapping[str, float]
) -> tuple[list[tuple[ScreenedEffect, bool]], dict[str, float]]:
    """Every candidate as a step and as a ramp, most promising first; and the gain predicted, by candidate."""
    entries = []
    for growing in (False, True):
        shaped = replace(problem, model=model.changed_in(model.effects, growing, calibrated.values))
        entries += [(each, growing) for each in screen(scan_effects(shaped, calibrated, model.effects))]

    def beyond_chance(entry: tuple[ScreenedEffect, bool]) -> float:
        return entry[0].predicted_gain - chance.get(entry[0].effect.name, 0.0) * problem.size

    entries.sort(key=lambda entry: -beyond_chance(entry))
    best: dict[str, tuple[ScreenedEffect, bool]] = {}
    for entry in entries:
        best.setdefault(entry[0].effect.name, entry)
    return list(best.values()), {name: beyond_chance(entry) for name, entry in best.items()}


def _fit_change(
    problem: Problem, calibrated: Fit, screened: ScreenedEffect, growing: bool, two_starts: bool,
    chance: Mapping[str, float],
) -> TriedChange:  # fmt: skip
    """One candidate fitted, and what it gains in simulations of the same fidelity."""
    effect, model = screened.effect, problem.model
    assert isinstance(model, ChangedString)
    shaped = replace(problem, model=model.changed_in((effect,), growing, calibrated.values)).at_fidelity_of((effect,))
    freed = parameters_of(shaped, ())
    own = {parameter.name for parameter in effect.parameters}
    freed = [parameter for parameter in freed if parameter.name not in own] + list(effect.parameters)
    starts = [start for start, _ in rank_starts(scan_effects(shaped, calibrated, []), screened)]
    fits = [
        fit(shaped, freed, start, known=KnownStart(jacobian_rows=calibrated.jacobian_rows))
        for start in starts[: 2 if two_starts else 1]
    ]  # fmt: skip
    found = min(fits, key=lambda each: each.cost)
    reference = calibrated.cost
    if shaped.options != problem.options:
        reference = fit(shaped, calibrated.parameters, calibrated.values, iterations=2).cost
    return TriedChange(
        effect, growing, shaped, found, reference - found.cost - chance.get(effect.name, 0.0) * problem.size
    )


def _in_better_shape(problem: Problem, calibrated: Fit, tried: TriedChange, chance: Mapping[str, float]) -> TriedChange:
    """A candidate as a step or as a ramp, whichever gains more."""
    other = ScreenedEffect(tried.effect, tried.gain, (tried.fit.values,))
    reshaped = _fit_change(problem, calibrated, other, not tried.growing, False, chance)
    return max((tried, reshaped), key=lambda each: each.gain)


def all_values(model: ChangedString, found: Fit) -> dict[str, float]:
    """Every value of a fit, shared ones included, without those of a single run."""
    return {name: value for name, value in {**model.shared, **found.values}.items() if "@" not in name}
