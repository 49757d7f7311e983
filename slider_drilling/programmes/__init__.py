"""Programmes: what a crew or a rig computer does to a string, step by step, within limits."""

from slider_drilling.programmes.limits import StepLimits
from slider_drilling.programmes.open_loop import open_loop_commands
from slider_drilling.programmes.programme import (
    Programme,
    Step,
    dump_programme,
    load_programme,
    parse_programme,
)
from slider_drilling.programmes.steps import (
    BlockSpeed,
    DrillOff,
    Flow,
    MakeConnection,
    PickUp,
    Rest,
    Rock,
    Rotate,
    SlackOff,
    Slide,
)

__all__ = [
    "BlockSpeed",
    "DrillOff",
    "Flow",
    "MakeConnection",
    "PickUp",
    "Programme",
    "Rest",
    "Rock",
    "Rotate",
    "SlackOff",
    "Slide",
    "Step",
    "StepLimits",
    "dump_programme",
    "load_programme",
    "open_loop_commands",
    "parse_programme",
]
