"""The state of the string at the start of a log, which no log tells."""

from __future__ import annotations

import numpy as np

from slider_drilling.diagnosis.nuisance import START_TWISTS
from slider_drilling.gap.model import Values
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import Fit, fit
from slider_drilling.gap.search.race import parameters_of


def fit_start_state(problem: Problem) -> Fit:
    """The state of the string at the start of each log, with everything else as the baseline has it."""
    own = [parameter for parameter in parameters_of(problem, ()) if "@" in parameter.name]
    runs = range(len(problem.model.runs))
    starts = [{f"start_twist@{run}": twist for run in runs} for twist in START_TWISTS]
    aligned = [_with_tool_face(problem, start) for start in starts]
    return min((fit(problem, own, start) for start in aligned), key=lambda each: each.cost)


def _with_tool_face(problem: Problem, start: Values) -> dict[str, float]:
    """A start whose toolface begins where it was measured: the first samples' circular mean."""
    residual = problem.residuals([start])[0]
    aligned = dict(start)
    for piece in problem.pieces:
        if piece.name == "tool_face":
            first = residual[piece.rows][:3] * piece.noise
            aligned[f"tool_face_offset@{piece.run}"] = float(np.angle(np.mean(np.exp(1j * first))))
    return aligned
