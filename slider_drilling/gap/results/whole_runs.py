"""How well fitted parameters explain the runs as wholes, the end of them that no fit has seen, and how far ahead."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from slider_drilling.gap.model import Array, HasFidelities, Model, SimulationOptions
from slider_drilling.gap.problem.cycles import block_length
from slider_drilling.gap.problem.noise import sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.selection.state import SearchState

Rms = dict[str, dict[str, float]]


@dataclass(frozen=True)
class WholeRunErrors:
    """RMS residuals by stage (nominal, tuned, with_effect) and channel, in the channel's unit, pooled over the runs.

    One free simulation of every run with one set of parameters, unlike the held-out gap, whose parameters differ from
    stretch to stretch. share: first part of every run that was fitted; fitted, rest: over that part and over what
    follows (empty when all was fitted); whole: over both; freed: how many parameters each stage fitted; horizon: s by
    channel (`prediction_horizon`); foretold: channels whose horizon is where the runs end; left: (N,) residuals in the
    channels' units, by stage.
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
        """The plain numbers of it."""
        return {name: getattr(self, name) for name in ("share", "fitted", "rest", "whole", "freed")}


def simulate_whole_runs(model: Model, state: SearchState, share: float) -> WholeRunErrors:
    """Simulate the whole runs of ``model`` with what was learnt from their first ``share`` (0 to 1)."""
    finest = max(model.max_fidelity - 1, 0) if isinstance(model, HasFidelities) else 0
    problem = build_problem(model, [sigmas(own) for own in state.floors], SimulationOptions(finest))
    stages = {"nominal": {}, "tuned": dict(state.calibrated.fit.values)}
    if state.current.effects:
        stages["with_effect"] = dict(state.current.fit.values)
    residuals = problem.residuals(list(stages.values()))
    left = {}
    parts: dict[str, Rms] = {"fitted": {}, "rest": {}, "whole": {}}
    for stage, row in zip(stages, residuals, strict=True):
        left[stage] = np.empty(problem.size)
        squares: dict[str, dict[str, list[Array]]] = {}
        for piece in problem.pieces:
            own = row[piece.rows] * piece.noise
            left[stage][piece.rows] = own
            run = model.runs[piece.run]
            seen = piece.channel.time <= run.time[0] + share * run.duration
            for place, kept in (("fitted", seen), ("rest", ~seen), ("whole", np.ones_like(seen))):
                squares.setdefault(place, {}).setdefault(piece.name, []).append(own[kept] ** 2)
        for place, channels in squares.items():
            found = {name: np.concatenate(pieces) for name, pieces in channels.items()}
            rms = {name: float(np.sqrt(np.mean(values))) for name, values in found.items() if values.size}
            if rms:
                parts[place][stage] = rms
    freed = {"nominal": 0, "tuned": len(state.calibrated.fit.parameters)}
    if state.current.effects:
        freed["with_effect"] = len(state.current.fit.parameters)
    last = list(stages)[-1]
    horizon, foretold = prediction_horizon(problem, left[last])
    return WholeRunErrors(
        share, parts["fitted"], parts["rest"], parts["whole"], freed, horizon, foretold, problem, left
    )


def prediction_horizon(problem: Problem, left: Array) -> tuple[dict[str, float], tuple[str, ...]]:
    """How far from its start a free run foretells each channel, s: until its error over one block is as large as the
    channel's own spread; the run's length where it never is. The shortest of the runs. Besides, the channels of which
    it never is in any run.
    """
    found: dict[str, float] = {}
    lost_in: set[str] = set()
    for piece in problem.pieces:
        run, time = problem.model.runs[piece.run], piece.channel.time
        if time.size < 8:
            continue
        samples = max(round(block_length(run) / max(float(np.median(np.diff(time))), 1e-9)), 3)
        error = uniform_filter1d(left[piece.rows] ** 2, min(samples, time.size), mode="nearest")
        measured = piece.channel.measured
        if piece.channel.period is not None:
            measured = np.unwrap(measured, period=piece.channel.period)
        lost = np.flatnonzero(error > np.var(measured))
        until = float(time[lost[0]] - run.time[0]) if lost.size else run.duration
        found[piece.name] = min(found.get(piece.name, until), until)
        if lost.size:
            lost_in.add(piece.name)
    return found, tuple(name for name in found if name not in lost_in)
