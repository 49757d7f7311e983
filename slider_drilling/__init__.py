"""Simulation, control and diagnosis of slide drilling.

All numbers are SI and radians. Positive axial is downhole, positive rotation is clockwise looking downhole.

`import slider_drilling as sd` offers the names of `__all__`. Each is imported when it is first used:

    run = sd.simulate(sd.load_rig(), "slider_drilling.control:SlideController", 300.0)
"""

import importlib
from typing import Any

__version__ = "0.1.0"

# Module of each public name; `__init__.pyi` has the types.
_MODULES = {
    "ActivitiesResult": "api.activities",
    "AnalysisResult": "api.analyse",
    "Batch": "api.batch",
    "ClosedLoopResult": "api.closed_loop",
    "Commands": "drillstring",
    "DiagnosisResult": "api.diagnose",
    "DrillerWeights": "analysis.driller_weights",
    "InitialState": "drillstring",
    "InputError": "errors",
    "Measurements": "control.interface",
    "PlanOptions": "rocking_design.plan",
    "Programme": "programmes",
    "PlanTestOptions": "test_planning.drilling_plan",
    "ReplayResult": "api.replay",
    "Rig": "rig",
    "RigCommand": "control.interface",
    "RigLog": "log",
    "RockingPlanResult": "api.rocking_plan",
    "Run": "api.simulate",
    "StudyResult": "api.study",
    "TestPlanResult": "api.plan_test",
    "TorqueDragResult": "api.torque_drag",
    "Twin": "twin",
    "TwinSettings": "twin",
    "WatchResult": "api.watch",
    "activities": "api.activities",
    "analyse": "api.analyse",
    "batch": "api.batch",
    "closed_loop": "api.closed_loop",
    "diagnose": "api.diagnose",
    "import_log": "api.import_log",
    "load_programme": "programmes",
    "load_rig": "api.rigs",
    "new_rig": "api.new_rig",
    "plan_test": "api.plan_test",
    "read_log": "log",
    "replay": "api.replay",
    "rocking": "api.rocking",
    "rocking_plan": "api.rocking_plan",
    "simulate": "api.simulate",
    "study": "api.study",
    "torque_drag": "api.torque_drag",
    "watch": "api.watch",
    "vector_env": "api.vector_env",
    "with_effect": "api.with_effect",
}
__all__ = ["__version__", *_MODULES]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'slider_drilling' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"slider_drilling.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_MODULES})
