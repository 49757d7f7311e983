"""Slide drilling: a plant, ROS 2 nodes, and the diagnosis of where the two part.

Everything inside is SI and radians; positive axial is downhole, positive rotation is clockwise
looking downhole.

`import slider_drilling as sd` offers what `__all__` names, each imported when it is first used:

    run = sd.simulate(sd.load_rig(), "slider_drilling.control:SlideController", 300.0)
"""

import importlib
from typing import Any

__version__ = "0.1.0"

# Where each name of the public face is; `__init__.pyi` has their types.
_FACE = {
    "Batch": "api.batch",
    "Commands": "drillstring",
    "DiagnosisResult": "api.diagnose",
    "InputError": "errors",
    "Measurements": "control.interface",
    "ReplayResult": "api.replay",
    "Rig": "rig",
    "RigCommand": "control.interface",
    "RigLog": "log",
    "Run": "api.simulate",
    "InitialState": "drillstring",
    "StudyResult": "api.study",
    "batch": "api.batch",
    "diagnose": "api.diagnose",
    "load_rig": "api.rigs",
    "read_log": "log",
    "replay": "api.replay",
    "rocking": "api.rocking",
    "simulate": "api.simulate",
    "study": "api.study",
    "with_effect": "api.with_effect",
}
__all__ = ["__version__", *_FACE]


def __getattr__(name: str) -> Any:
    if name not in _FACE:
        raise AttributeError(f"module 'slider_drilling' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"slider_drilling.{_FACE[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_FACE})
