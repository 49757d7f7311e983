"""Random wells for sealed logs; string and fluids are those of a rig file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from slider_drilling.rig import FrictionInterval, Rig, StringSection

_ASSEMBLY_M = 60.0  # length of the bottom-hole assembly


def horizontal(generator: np.random.Generator, base: Rig) -> Rig:
    """Returns a rig with a vertical section, a build and a horizontal of 0.7 to 1.6 km."""
    return _well(generator, base, generator.uniform(80.0, 90.0), 90.0, generator.uniform(700.0, 1600.0))


def deviated(generator: np.random.Generator, base: Rig) -> Rig:
    """Returns a rig with a vertical section, a build and a tangent at 40 to 65 degrees."""
    tangent = float(generator.uniform(40.0, 65.0))
    return _well(generator, base, tangent, tangent, generator.uniform(800.0, 1600.0))


def extended(generator: np.random.Generator, base: Rig) -> Rig:
    """Returns a rig with a horizontal of 1.8 to 2.6 km."""
    return _well(generator, base, generator.uniform(85.0, 90.0), 90.0, generator.uniform(1800.0, 2600.0))


def own(generator: np.random.Generator, base: Rig) -> Rig:
    """Returns the rig file's own well."""
    return base


WELLS: dict[str, Callable[[np.random.Generator, Rig], Rig]] = {
    make.__name__: make for make in (horizontal, deviated, extended, own)
}
DEFAULT_WELLS = ("horizontal", "deviated", "extended")


def _well(generator: np.random.Generator, base: Rig, landing: float, end: float, hold: float) -> Rig:
    kick, build = generator.uniform(700.0, 1400.0), generator.uniform(600.0, 1000.0)
    length = kick + build + hold
    survey = ((0.0, 0.0, 10.0), (kick, 0.0, 10.0), (kick + build, landing, 14.0), (length, end, 14.0))
    pipe, assembly = base.string.sections[0], base.string.sections[-1]
    sections = (
        StringSection(pipe.name, length - _ASSEMBLY_M, pipe.outer_diameter, pipe.inner_diameter),
        StringSection(assembly.name, _ASSEMBLY_M, assembly.outer_diameter, assembly.inner_diameter),
    )
    intervals = (FrictionInterval(kick + build, 0.8), FrictionInterval(length, 1.0))
    well = replace(base.well, survey=survey, friction_intervals=intervals)
    return replace(base, well=well, string=replace(base.string, sections=sections))
