"""The studies by name, each imported when it is run."""

from __future__ import annotations

import importlib
from dataclasses import dataclass

from slider_drilling.errors import InputError
from slider_drilling.paper_studies.study import Study


@dataclass(frozen=True)
class StudyEntry:
    """The module of a study and what it is about."""

    module: str
    about: str


STUDIES: dict[str, StudyEntry] = {
    "wear_modes": StudyEntry("wear_modes", "asperity wear-mode diagram (Fig. 8, eq. 1-6)"),
    "longitudinal": StudyEntry("longitudinal", "NOV hydraulic oscillation system: shaking along the hole"),
    "radial": StudyEntry("radial", "radial hydraulic oscillator: normal force that comes and goes"),
    "torsional": StudyEntry("torsional", "3-D hydraulic oscillation system, torsional part"),
    "three_d": StudyEntry("three_d", "3-D hydraulic oscillation system, axial and torsional at once"),
    "rocking": StudyEntry("rocking", "slider drilling: rocking from the surface (Fig. 22-25)"),
    "comparison": StudyEntry("comparison", "all tools over the field's ranges"),
    "zones": StudyEntry("zones", "three zones along the string (Fig. 5)"),
    "weight_transfer": StudyEntry("weight_transfer", "slide of a whole well, with and without rocking and each tool"),
}


def run_study(name: str) -> Study:
    """Run one study. Raises InputError for a name that is not in STUDIES."""
    if name not in STUDIES:
        raise InputError(f"study: NAME = {name}: no such study; choose one of {', '.join(STUDIES)}, or all")
    module = importlib.import_module(f"slider_drilling.paper_studies.{STUDIES[name].module}")
    study: Study = module.study()
    return study
