"""Parameters of a model that is used without feedback: those whose free run is best.

What a search finds with the measured channel fed back holds for predictions from what was measured so far. A free run
of a system that sticks and slips loses its phase with such parameters: its error over the whole run has many local
minima, the widest of which is a system that does not oscillate. Fits therefore begin with the first part of the run,
and follow the optimum while the part grows (progressive horizon, as in Voss, Timmer and Kurths, International Journal
of Bifurcation and Chaos 14, 2004).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

from slider_drilling.gap.evidence.compare import share_closed
from slider_drilling.gap.evidence.score import squared_residuals
from slider_drilling.gap.model import Array, CanTruncate, Effect, Parameter, SimulationOptions, Values
from slider_drilling.gap.problem.noise import sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.results.prediction_horizon import prediction_horizon
from slider_drilling.gap.search.fine_fit import fit_fidelity
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.search.multi_start import plausible_range
from slider_drilling.gap.selection.evidence_tests import MIN_GAP_CLOSED
from slider_drilling.gap.selection.state import FittedModel, SearchState
from slider_drilling.process.parallel_map import parallel_map

# Parts of a run that are fitted one after the other; the whole more than once.
_HORIZONS = (*np.linspace(0.25, 1.0, 16), 1.0, 1.0)
# Points at which the first part is simulated, and how many of them are fitted.
_POINTS, _FIRST = 512, 24
# Fits that go on to the next part; points scattered around them there; iterations on each part.
_KEPT, _AROUND, _ITERATIONS = 4, 96, 2
# Smallest and largest spread of the scattered points, in shares of each parameter's span.
_NEAR, _FAR = 0.003, 0.5
# How far beyond what is scanned of an effect alone its parameters are looked for beside others.
_WIDER = 3.0
_BATCH = 64


@dataclass(frozen=True)
class FreeRunModels:
    """The calibrated and the final model, each with the parameters whose free run is best.

    Attributes:
        calibrated: With nuisance alone.
        final: With the effects of the final model; the calibrated one where there are none.
        gaps: E over the whole fitted runs in one free run: as given, calibrated, final.
        refitted: Whether they were fitted again.
    """

    calibrated: FittedModel
    final: FittedModel
    gaps: tuple[float, float, float]
    refitted: bool

    @property
    def best(self) -> FittedModel:
        """The one with the best free run: what a simulator should use."""
        return self.final if self.gaps[2] <= self.gaps[1] else self.calibrated

    @property
    def effects_close_enough(self) -> bool:
        """Whether the effects close some of the gap of a free run too, where the models were refitted in free runs."""
        return not self.refitted or not share_closed(self.gaps[1] ** 2, self.gaps[2] ** 2) < MIN_GAP_CLOSED

    @property
    def without_effects(self) -> FreeRunModels:
        """The calibrated model alone."""
        given, calibrated, _ = self.gaps
        return FreeRunModels(self.calibrated, self.calibrated, (given, calibrated, calibrated), self.refitted)


def best_free_runs(state: SearchState) -> FreeRunModels:
    """The models of a state as they are used without feedback.

    Models that were scored in the free run are kept. Those that were scored with feedback are fitted again:
    calibration is then no worse than the model as given, and the final model no worse than calibration. Where the free
    run keeps its phase to the end, the model cannot be cut off, or the search was interrupted, no fit to growing parts
    is made.
    """
    exact = _free_problem(state, 1.0, fit_fidelity(state.current.problem.model))
    given = {parameter.name: parameter.nominal for parameter in state.calibrated.fit.parameters}
    fed_back = state.current.problem.options.observer_gain > 0.0
    calibrated, final = state.calibrated, state.current
    if fed_back:
        calibrated = _refitted(state, exact, calibrated, given)
        final = calibrated
    if fed_back and state.current.effects:
        neutral = {p.name: p.nominal for effect in state.current.effects for p in effect.parameters}
        final = _refitted(state, exact, state.current, calibrated.fit.values | neutral)
    given_gap, calibrated_gap, final_gap = _rms(exact, [given, calibrated.fit.values, final.fit.values])
    gaps = (float(given_gap), float(calibrated_gap), float(final_gap))
    return FreeRunModels(calibrated, final, gaps, fed_back and not state.interrupted)


def _refitted(state: SearchState, exact: Problem, model: FittedModel, simpler: Values) -> FittedModel:
    """The model with the values whose free run is best: its own, those of a simpler model, or fitted again."""
    candidates = [dict(model.fit.values), dict(simpler)]
    grows = isinstance(model.problem.model, CanTruncate) and not state.interrupted
    if grows and not _keeps_its_phase(exact, model.fit.values):
        candidates += _grow(state, model, candidates)
    gaps = _rms(exact, candidates)
    best = candidates[int(np.argmin(np.where(np.isfinite(gaps), gaps, np.inf)))]
    problem = replace(exact, white_discrepancy=state.modes[0].white_discrepancy)
    return replace(model, problem=problem, fit=fit(problem, model.fit.parameters, best, iterations=0))


def _keeps_its_phase(exact: Problem, values: Values) -> bool:
    """Whether the error of a free run stays below the spread of every channel that shows the phase of a vibration.

    A channel that accumulates does not: one step that it misses stays, though all others come at their times.
    """
    (residual,) = exact.residuals([values])
    in_units = np.concatenate([residual[piece.rows] * piece.noise for piece in exact.pieces])
    horizon, to_end = prediction_horizon(exact, in_units)
    showing = {piece.name for piece in exact.pieces if not piece.channel.accumulates} & set(horizon)
    return (showing or set(horizon)) <= set(to_end)


def _grow(state: SearchState, model: FittedModel, starts: Sequence[Values]) -> list[dict[str, float]]:
    """Values of fits that followed their optimum from the first part of the runs to the whole.

    Where the next part shows an event that a fit misses, the optimum jumps. Points scattered around the fits therefore
    compete with them at the start of each part (a genetic step, as in population Monte Carlo).
    """
    # Cheaper simulations lead astray: a coarse mesh sticks and slips at other times.
    fidelity, parameters = fit_fidelity(model.problem.model), model.fit.parameters
    spans, random = _spans(state, model), np.random.default_rng(1)
    first = points = [*starts, *_best(_free_problem(state, _HORIZONS[0], 0), _spread_over(spans), _FIRST)]
    for horizon in _HORIZONS:
        part = _free_problem(state, horizon, fidelity)
        if points is not first:
            points = _best(part, [*points, *_scattered_around(points, parameters, spans, random)], _KEPT)

        def advance(start: Values, part: Problem = part) -> tuple[float, dict[str, float]]:
            found = fit(part, parameters, start, iterations=_ITERATIONS)
            return found.cost, found.values

        fits = sorted(parallel_map(advance, points), key=lambda entry: entry[0])
        points = [values for _, values in fits[:_KEPT]]
    return [dict(values) for values in points]


def _best(problem: Problem, points: Sequence[Values], count: int) -> list[Values]:
    """The points whose free run is best."""
    return [points[index] for index in np.argsort(_rms(problem, points))[:count]]


def _spans(state: SearchState, model: FittedModel) -> dict[str, tuple[float, float]]:
    """By parameter: what is plausible of the nuisance; of the effects, what is scanned and around."""
    spans = {parameter.name: plausible_range(parameter) for parameter in state.calibrated.fit.parameters}
    for effect in model.effects:
        spans |= _wide_spans(effect)
    return spans


def _spread_over(spans: Mapping[str, tuple[float, float]]) -> list[dict[str, float]]:
    """Points spread evenly over the spans."""
    unit = qmc.Sobol(len(spans), seed=1).random(_POINTS) if spans else np.empty((0, 0))
    columns = [_between(*span, unit[:, index]) for index, span in enumerate(spans.values())]
    return [dict(zip(spans, map(float, row), strict=True)) for row in np.array(columns).T]


def _scattered_around(
    points: Sequence[Values],
    parameters: Sequence[Parameter],
    spans: Mapping[str, tuple[float, float]],
    random: np.random.Generator,
) -> list[dict[str, float]]:
    """Points around others, near and far in turn, within the bounds of the parameters."""
    scattered = []
    for index, size in enumerate(np.geomspace(_NEAR, _FAR, _AROUND)):
        point = dict(points[index % len(points)])
        for parameter in parameters:
            low, high = spans[parameter.name]
            moved = point[parameter.name] + size * (high - low) * random.standard_normal()
            point[parameter.name] = float(np.clip(moved, parameter.lower, parameter.upper))
        scattered.append(point)
    return scattered


def _wide_spans(effect: Effect) -> dict[str, tuple[float, float]]:
    """By parameter, the scanned span, `_WIDER` either way, within bounds."""
    spans = {}
    for index, parameter in enumerate(effect.parameters):
        scanned = [point[index] for point in effect.scan]
        low, high = min(scanned), max(scanned)
        low, high = (low / _WIDER if low > 0.0 else low), (high * _WIDER if high > 0.0 else high)
        spans[parameter.name] = max(low, parameter.lower), min(high, parameter.upper)
    return spans


def _between(low: float, high: float, unit: Array) -> Array:
    """(K,) values of a span for K numbers from 0 to 1, even in the logarithm where the span is wide."""
    if low > 0.0 and high > _WIDER * low:
        return np.asarray(low * (high / low) ** unit)
    return np.asarray(low + (high - low) * unit)


def _free_problem(state: SearchState, fraction: float, fidelity: int) -> Problem:
    """The free run of the first part of the runs, in which all errors count alike."""
    model = state.current.problem.model
    if fraction < 1.0 and isinstance(model, CanTruncate):
        model = model.truncated(fraction)
    noise = [sigmas(own) for own in state.floors]
    problem = build_problem(model, noise, SimulationOptions(fidelity), state.current.problem.counter)
    return replace(problem, white_discrepancy=True)


def _rms(problem: Problem, sets: Sequence[Values]) -> Array:
    """(K,) E of K parameter sets."""
    parts = [problem.residuals(sets[begin : begin + _BATCH]) for begin in range(0, len(sets), _BATCH)]
    return np.array([np.sqrt(np.mean(squared_residuals(problem, row))) for part in parts for row in part])
