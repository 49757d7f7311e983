"""The run to make next: the manoeuvre under which the leading explanations differ most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.model import Array, HasManoeuvres, Manoeuvre
from slider_drilling.gap.problem.noise import sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.least_squares import Fit
from slider_drilling.gap.selection.state import CandidateResult, SearchState

# Finite-difference step of the nuisance, in scales.
_STEP = 0.1


@dataclass(frozen=True)
class RecommendedManoeuvre:
    """The recommended run.

    Attributes:
        description: What to do, in words.
        settings: What to do, in numbers.
        separates: Names of the two effects.
        distance: How far their fits differ under it: RMS in noise units, beyond what the nuisance could make up for.
        distance_in_log: The same in the present log.
        all_distances: ``distance`` of every manoeuvre that was compared, by description.
    """

    description: str
    settings: dict[str, float]
    separates: tuple[str, str]
    distance: float
    distance_in_log: float
    all_distances: dict[str, float]


def recommend_manoeuvre(state: SearchState) -> RecommendedManoeuvre | None:
    """Compare the two leading explanations under each manoeuvre that the model offers.

    Returns:
        The best manoeuvre; None if there are no two explanations, or if they differ more in the present log.
    """
    model = state.current.problem.model
    pair = _leading_pair(state)
    if pair is None or not isinstance(model, HasManoeuvres):
        return None
    first, second = pair
    offered = {manoeuvre.description: manoeuvre for manoeuvre in model.manoeuvres()}
    distances = {
        description: _distance(_problem_of(state, manoeuvre), first.fitted.fit, second.fitted.fit, first)
        for description, manoeuvre in offered.items()
    }
    best = max(distances, key=lambda description: distances[description])
    in_log = _distance_in_log(first, second)
    if distances[best] <= in_log:
        return None
    names = first.effect.name, second.effect.name
    return RecommendedManoeuvre(best, dict(offered[best].settings), names, distances[best], in_log, distances)


def _leading_pair(state: SearchState) -> tuple[CandidateResult, CandidateResult] | None:
    """The first accepted effect and one that is indistinguishable from it.

    Where none was accepted and something is left to explain, the two best candidates.
    """
    if not state.steps:
        return None
    first = state.steps[0]
    if first.accepted is None:
        nothing_to_separate = state.adequacy.adequate or len(first.candidates) < 2
        return None if nothing_to_separate else (first.candidates[0], first.candidates[1])
    group = state.indistinguishable[first.accepted.effect.name]
    rival = next((candidate for candidate in first.candidates if candidate.effect.name in group), None)
    return None if rival is None else (first.accepted, rival)


def _problem_of(state: SearchState, manoeuvre: Manoeuvre) -> Problem:
    """The manoeuvre's runs, with the noise floors of the present log."""
    return build_problem(manoeuvre.model, [sigmas(state.floors[0]) for _ in manoeuvre.model.runs])


def _distance(problem: Problem, first: Fit, second: Fit, candidate: CandidateResult) -> float:
    """RMS difference of two fits under a manoeuvre, noise units, beyond what the nuisance of the first can make up."""
    own = {parameter.name for parameter in candidate.effect.parameters}
    nuisance = [p for p in first.parameters if p.name not in own and not p.per_run]
    # The next run has its own start: parameters of the present run are left out.
    shared = [{k: v for k, v in each.values.items() if "@" not in k} for each in (first, second)]
    sets = shared + [shared[0] | {p.name: shared[0][p.name] + _STEP * p.scale} for p in nuisance]
    simulated = problem.simulate(sets)
    return _rms_beyond(problem, simulated[1] - simulated[0], (simulated[2:] - simulated[0]) / _STEP)


def _distance_in_log(first: CandidateResult, second: CandidateResult) -> float:
    """The same in the present log."""
    mine, other = first.fitted, second.fitted
    return _rms_beyond(mine.problem, mine.fit.simulated - other.fit.simulated, mine.fit.jacobian)


def _rms_beyond(problem: Problem, difference: Array, jacobian: Array) -> float:
    """RMS of a difference (N,) outside the span of a Jacobian (p, N); every channel weighs the same."""
    weight = np.empty(problem.size)
    for piece in problem.pieces:
        weight[piece.rows] = 1.0 / np.sqrt(len(problem.pieces) * piece.channel.time.size)
    basis, _ = np.linalg.qr((weight * jacobian).T)
    rest = weight * difference
    return float(np.linalg.norm(rest - basis @ (basis.T @ rest)))
