"""test_plan.json: a planned test, field by field. docs/reference/test_plan.md explains every key."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite
from typing import Any

from slider_drilling import __version__
from slider_drilling.diagnosis.programme_words import programme_in_words
from slider_drilling.gap.experiment_design.criterion import Prospect
from slider_drilling.gap.experiment_design.plan import PlannedRun
from slider_drilling.programmes import dump_programme
from slider_drilling.test_planning.drilling_plan import DrillingPlan, programme_in
from slider_drilling.test_planning.effect_sizes import cannot_tell, effect_rows

SCHEMA = "slider_drilling/test_plan/1"


def plan_json(plan: DrillingPlan) -> dict[str, Any]:
    """The tree of test_plan.json: SI units and rad, null for what no size shows."""
    steps = programme_in_words(plan.programme, plan.rig)
    swing = plan.programmes.limits.tool_face_swing
    return {
        "schema": SCHEMA,
        "version": __version__,
        "after": None if plan.after is None else {
            "logs": list(plan.after.logs), "verdict": plan.after.verdict, "effects": list(plan.after.effects),
        },
        "minutes": plan.options.minutes,
        "duration_s": steps[-1].begin + steps[-1].duration,
        "programme": dump_programme(plan.programme),
        "steps": [{"begin_s": step.begin, "duration_s": step.duration, "text": str(step.text)} for step in steps],
        "limits": asdict(plan.programmes.limits.steps),
        "tool_face_swing": swing if isfinite(swing) else None,
        "limit_use": plan.plan.planned.limit_use,
        "effects": [asdict(row) for row in effect_rows(plan)],
        "explanations": [
            {"effects": list(each.effects), "weight": each.weight} for each in plan.plan.knowledge.explanations
        ],
        "separations": _separations(plan.plan.planned.prospect),
        "alternatives": [
            _alternative("planned", plan.plan.planned),
            *(_alternative(name, run) for name, run in plan.plan.fixed.items()),
        ],
        "programmes_compared": plan.plan.evaluations,
        "cannot_tell": [str(line) for line in cannot_tell(plan)],
    }  # fmt: skip


def _separations(prospect: Prospect) -> list[dict[str, Any]]:
    return [asdict(each) for each in prospect.separations]


def _alternative(name: str, run: PlannedRun) -> dict[str, Any]:
    """One programme beside the others: the smaller its loss, the more information it is expected to give."""
    detectable = {each.name: each.size.amplitude for each in run.prospect.effects}
    return {
        "name": name,
        "loss": run.prospect.loss,
        "limit_use": run.limit_use,
        "steps": len(programme_in(run).steps),
        "detectable": {key: value if isfinite(value) else None for key, value in detectable.items()},
    }
