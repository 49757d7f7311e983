"""Which run to make next: the manoeuvre under which two explanations differ most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.model import Array, HasManoeuvres, Manoeuvre
from slider_drilling.gap.problem.noise import sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.least_squares import Fit
from slider_drilling.gap.selection.state import CandidateResult, SearchState

_STEP = 0.1


@dataclass(frozen=True)
class RecommendedManoeuvre:
    """separates: the two explanations; distance: how far they differ under it, RMS in noise units, beyond what the
    nuisance could make up for; now: the same in the log at hand; others: distance of every manoeuvre looked at.
    """

    description: str
    settings: dict[str, float]
    separates: tuple[str, str]
    distance: float
    distance_in_log: float
    all_distances: dict[str, float]


def recommend_manoeuvre(state: SearchState) -> RecommendedManoeuvre | None:
    """Compare the two leading explanations under each manoeuvre that the model offers; None without rivals, and where
    under none of them these differ more than in the log at hand.
    """
    model = state.current.problem.model
    pair = _rivals(state)
    if pair is None or not isinstance(model, HasManoeuvres):
        return None
    first, second = pair
    offered = {manoeuvre.description: manoeuvre for manoeuvre in model.manoeuvres()}
    distances = {
        description: _distance(_problem(state, manoeuvre), first.fitted.fit, second.fitted.fit, first)
        for description, manoeuvre in offered.items()
    }
    best = max(distances, key=lambda description: distances[description])
    now = _now(first, second)
    if distances[best] <= now:
        return None
    return RecommendedManoeuvre(
        best, dict(offered[best].settings), (first.effect.name, second.effect.name), distances[best],
        now, distances,
    )  # fmt: skip


def _rivals(state: SearchState) -> tuple[CandidateResult, CandidateResult] | None:
    """The accepted effect and what it cannot be told from; the two leading candidates where none was accepted and
    something is left to explain.
    """
    if not state.steps:
        return None
    first = state.steps[0]
    if first.accepted is None:
        idle = state.adequacy.adequate or len(first.candidates) < 2
        return None if idle else (first.candidates[0], first.candidates[1])
    group = state.indistinguishable[first.accepted.effect.name]
    rival = next((one for one in first.candidates if one.effect.name in group), None)
    return None if rival is None else (first.accepted, rival)


def _now(first: CandidateResult, second: CandidateResult) -> float:
    """How far two fits differ in the log at hand."""
    mine, other = first.fitted, second.fitted
    return _apart(mine.problem, mine.fit.simulated - other.fit.simulated, mine.fit.jacobian)


def _problem(state: SearchState, manoeuvre: Manoeuvre) -> Problem:
    """The manoeuvre's runs with the noise of the log at hand."""
    return build_problem(manoeuvre.model, [sigmas(state.floors[0]) for _ in manoeuvre.model.runs])


def _distance(problem: Problem, first: Fit, second: Fit, judged: CandidateResult) -> float:
    """RMS difference of two fits in noise units under another excitation."""
    own = {parameter.name for parameter in judged.effect.parameters}
    nuisance = [p for p in first.parameters if p.name not in own and not p.per_run]
    # A next run starts from its own rest: what belonged to the log at hand only is not carried over.
    shared = [{k: v for k, v in found.values.items() if "@" not in k} for found in (first, second)]
    sets = shared + [shared[0] | {p.name: shared[0][p.name] + _STEP * p.scale} for p in nuisance]
    simulated = problem.simulate(sets)
    return _apart(problem, simulated[1] - simulated[0], (simulated[2:] - simulated[0]) / _STEP)


def _apart(problem: Problem, difference: Array, jacobian: Array) -> float:
    weight = np.empty(problem.size)
    for piece in problem.pieces:
        weight[piece.rows] = 1.0 / np.sqrt(len(problem.pieces) * piece.channel.time.size)
    basis, _ = np.linalg.qr((weight * jacobian).T)
    rest = weight * difference
    return float(np.linalg.norm(rest - basis @ (basis.T @ rest)))
