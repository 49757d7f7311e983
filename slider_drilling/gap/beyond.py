"""How well fitted parameters explain the runs as wholes, and the end of them that no fit has seen."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from slider_drilling.gap.findings import Findings
from slider_drilling.gap.model import Array, Model
from slider_drilling.gap.residuals import Problem, build_problem

Rms = dict[str, dict[str, float]]


@dataclass(frozen=True)
class Beyond:
    """RMS residuals by stage (nominal, tuned, with_effect) and channel, in the channel's unit, pooled over the runs.

    One exact simulation of every run with one set of parameters, unlike the held-out gap, whose parameters differ
    from stretch to stretch. share: first part of every run that was fitted; fitted, rest: over that part and over what
    follows (empty when all was fitted); whole: over both; freed: how many parameters each stage fitted.
    """

    share: float
    fitted: Rms
    rest: Rms
    whole: Rms
    freed: dict[str, int]
    problem: Problem = field(repr=False)
    left: dict[str, Array] = field(repr=False)

    def figures(self) -> dict[str, Any]:
        """The plain numbers of it."""
        return {name: getattr(self, name) for name in ("share", "fitted", "rest", "whole", "freed")}


def look_beyond(model: Model, findings: Findings, share: float) -> Beyond:
    """Simulate the whole runs of ``model`` with what ``findings`` learnt from their first ``share`` (0 to 1)."""
    problem = build_problem(model, findings.problem.floors)
    stages: dict[str, dict[str, float]] = {"nominal": {}}
    freed = {"nominal": 0}
    for name, base in (("tuned", findings.tuned), ("with_effect", findings.current)):
        if base is not None and (name == "tuned" or findings.accepted):
            stages[name] = dict(base.fit.values)
            freed[name] = len(base.fit.parameters)
    ends = np.array([run.time[0] + share * run.duration for run in model.runs])
    seen = problem.time <= ends[problem.run]
    parts: dict[str, Rms] = {"fitted": {}, "rest": {}, "whole": {}}
    left = {}
    for stage, values in stages.items():
        problem.anchor(values)
        left[stage] = residual = problem.floor * problem.residuals([values])[0]
        for place, kept in (("fitted", seen), ("rest", ~seen), ("whole", np.ones_like(seen))):
            for index, name in enumerate(problem.channel_names):
                here = kept & (problem.channel == index)
                if here.any():
                    parts[place].setdefault(stage, {})[name] = float(np.sqrt(np.mean(residual[here] ** 2)))
    return Beyond(share, parts["fitted"], parts["rest"], parts["whole"], freed, problem, left)
