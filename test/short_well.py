"""A well of 1 km whose runs are cheap."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.blind.manoeuvres import steady
from slider_drilling.blind.recorder import write_sealed_log
from slider_drilling.diagnosis import build_model
from slider_drilling.drillstring import simulate
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import RigLog, read_log
from slider_drilling.rig import FrictionInterval, Rig, StringSection, load_rig


@contextlib.contextmanager
def coarse_meshes() -> Iterator[None]:
    """Meshes as fine as these short wells need."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build_model, "MESHES", (16, 24, 30))
        yield


def routine_slide(path: Path, true: Rig, seed: int, duration: float) -> RigLog:
    """A routine slide of so many s of what the short rig truly is; the seed is that of the recorder's noise."""
    rig = short_rig()
    commands = steady(np.random.default_rng(5), rig, duration)
    write_sealed_log(path, rig, commands, simulate(true, commands, 50), np.random.default_rng(seed))
    return read_log(path)


def short_rig() -> Rig:
    """The example rig with a kick-off at 300 m, horizontal from 1000 m on."""
    rig = load_rig(installed_file("config/rig.example.yaml"))
    survey = ((0.0, 0.0, 0.0), (300.0, 0.0, 0.0), (700.0, 80.0, 0.0), (1000.0, 88.0, 0.0))
    pipe, assembly = rig.string.sections
    sections = (
        StringSection("pipe", 940.0, pipe.outer_diameter, pipe.inner_diameter),
        StringSection("assembly", 60.0, assembly.outer_diameter, assembly.inner_diameter),
    )
    well = replace(
        rig.well, survey=survey, friction_intervals=(FrictionInterval(700.0, 0.8), FrictionInterval(1000.0, 1.0))
    )
    return replace(rig, well=well, string=replace(rig.string, sections=sections))
