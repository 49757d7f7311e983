"""The drill string in its well: the compiled plant and the one door to it."""

from slider_drilling.drillstring.assemble import Modifiers
from slider_drilling.drillstring.depth_profile import Profile
from slider_drilling.drillstring.observer import Observer
from slider_drilling.drillstring.recorded_channels import Commands, Response
from slider_drilling.drillstring.simulate import ELEMENTS, Plant, PlantState, simulate, simulate_batch
from slider_drilling.drillstring.start import Start
from slider_drilling.drillstring.virtual_rig import Truth, VirtualRig, VirtualRigState

__all__ = [
    "ELEMENTS",
    "Commands",
    "Modifiers",
    "Observer",
    "Plant",
    "PlantState",
    "Profile",
    "Response",
    "Start",
    "Truth",
    "VirtualRig",
    "VirtualRigState",
    "simulate",
    "simulate_batch",
]
