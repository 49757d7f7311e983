"""How far from its start a free run predicts."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from slider_drilling.gap.model import Array
from slider_drilling.gap.problem.cycles import block_length
from slider_drilling.gap.problem.problem import Problem


def prediction_horizon(problem: Problem, residual: Array) -> tuple[dict[str, float], tuple[str, ...]]:
    """How far from its start a free run predicts each channel.

    The horizon ends where the mean square error over one block is as large as the channel's own variance.

    Args:
        problem: The problem.
        residual: (N,) in the channels' units.

    Returns:
        By channel, the shortest horizon of all runs, s (the run's length where it does not end); and the channels whose
        horizon ends in no run.
    """
    horizon: dict[str, float] = {}
    ends: set[str] = set()
    for piece in problem.pieces:
        run, time = problem.model.runs[piece.run], piece.channel.time
        if time.size < 8:
            continue
        samples = max(round(block_length(run) / max(float(np.median(np.diff(time))), 1e-9)), 3)
        error = uniform_filter1d(residual[piece.rows] ** 2, min(samples, time.size), mode="nearest")
        measured = piece.channel.measured
        if piece.channel.period is not None:
            measured = np.unwrap(measured, period=piece.channel.period)
        lost = np.flatnonzero(error > np.var(measured))
        until = float(time[lost[0]] - run.time[0]) if lost.size else run.duration
        horizon[piece.name] = min(horizon.get(piece.name, until), until)
        if lost.size:
            ends.add(piece.name)
    return horizon, tuple(name for name in horizon if name not in ends)
