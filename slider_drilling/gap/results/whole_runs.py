"""Errors of one simulation of each whole run, where parameters were fitted and beyond, and its prediction horizon."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from slider_drilling.gap.model import Array, Model, SimulationOptions
from slider_drilling.gap.problem.noise import sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.results.free_run import FreeRunModels
from slider_drilling.gap.results.prediction_horizon import prediction_horizon
from slider_drilling.gap.search.fine_fit import fit_fidelity
from slider_drilling.gap.selection.state import SearchState

# By stage and channel, in the channel's unit.
Rms = dict[str, dict[str, float]]


@dataclass(frozen=True)
class WholeRunErrors:
    """RMS errors by stage (nominal, tuned, with_effect) and channel, in the channel's unit, over all runs.

    They come from one free simulation of every run with one set of parameters. In the held-out gap, by contrast,
    parameters differ from stretch to stretch.

    Attributes:
        share: First part of every run that was fitted, 0 to 1.
        fitted: Errors over that part.
        rest: Errors over what follows, empty when all was fitted.
        whole: Errors over both.
        freed: How many parameters each stage fitted.
        horizon: By channel, s, how far ahead a free run predicts, see `prediction_horizon`.
        predictable_to_end: Channels whose horizon is the end of every run.
        problem: The problem of the whole runs.
        residuals: By stage, (N,) residuals in the channels' units.
    """

    share: float
    fitted: Rms
    rest: Rms
    whole: Rms
    freed: dict[str, int]
    horizon: dict[str, float]
    predictable_to_end: tuple[str, ...]
    problem: Problem = field(repr=False)
    residuals: dict[str, Array] = field(repr=False)

    def figures(self) -> dict[str, Any]:
        """Its plain numbers, by name."""
        return {name: getattr(self, name) for name in ("share", "fitted", "rest", "whole", "freed")}


def simulate_whole_runs(
    model: Model, state: SearchState, share: float, free_runs: FreeRunModels | None = None
) -> WholeRunErrors:
    """Simulate the whole runs with what was fitted to their first part.

    Args:
        model: The model with its whole runs.
        state: Last state of a search over their first part.
        share: That part, 0 to 1.
        free_runs: The models with the parameters whose free run is best; by default those of the search.
    """
    calibrated, final = (
        (state.calibrated, state.current) if free_runs is None else (free_runs.calibrated, free_runs.final)
    )
    options = SimulationOptions(fit_fidelity(model))
    problem = build_problem(model, [sigmas(own) for own in state.floors], options)
    stages = {"nominal": {}, "tuned": dict(calibrated.fit.values)}
    freed = {"nominal": 0, "tuned": len(calibrated.fit.parameters)}
    if state.current.effects:
        stages["with_effect"] = dict(final.fit.values)
        freed["with_effect"] = len(final.fit.parameters)
    simulated = problem.residuals(list(stages.values()))
    residuals = {stage: _in_units(problem, row) for stage, row in zip(stages, simulated, strict=True)}
    parts: dict[str, Rms] = {"fitted": {}, "rest": {}, "whole": {}}
    for stage, residual in residuals.items():
        for part, rms in _rms_by_part(problem, residual, share).items():
            parts[part][stage] = rms
    horizon, to_end = prediction_horizon(problem, residuals[list(stages)[-1]])
    return WholeRunErrors(
        share, parts["fitted"], parts["rest"], parts["whole"], freed, horizon, to_end, problem, residuals
    )


def _in_units(problem: Problem, residual: Array) -> Array:
    """A residual (N,) in the channels' units."""
    converted = np.empty(problem.size)
    for piece in problem.pieces:
        converted[piece.rows] = residual[piece.rows] * piece.noise
    return converted


def _rms_by_part(problem: Problem, residual: Array, share: float) -> dict[str, dict[str, float]]:
    """RMS by part of the runs and channel; parts and channels without samples are left out."""
    squares: dict[str, dict[str, list[Array]]] = {}
    for piece in problem.pieces:
        own, run = residual[piece.rows], problem.model.runs[piece.run]
        seen = piece.channel.time <= run.time[0] + share * run.duration
        for part, kept in (("fitted", seen), ("rest", ~seen), ("whole", np.ones_like(seen))):
            squares.setdefault(part, {}).setdefault(piece.name, []).append(own[kept] ** 2)
    by_part = {}
    for part, channels in squares.items():
        joined = {name: np.concatenate(pieces) for name, pieces in channels.items()}
        rms = {name: float(np.sqrt(np.mean(values))) for name, values in joined.items() if values.size}
        if rms:
            by_part[part] = rms
    return by_part
