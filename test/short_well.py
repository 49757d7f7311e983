"""A well of 1 km whose runs are cheap."""

from dataclasses import replace

from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import FrictionInterval, Rig, StringSection, load_rig


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
