"""The drill string in its well: the compiled plant, and all that other packages use of it."""

from slider_drilling.drillstring.assemble import Modifiers
from slider_drilling.drillstring.depth_profile import DepthProfile
from slider_drilling.drillstring.initial_state import InitialState
from slider_drilling.drillstring.lane_block import PlantState
from slider_drilling.drillstring.observer import Observer
from slider_drilling.drillstring.recorded_channels import Commands, Response
from slider_drilling.drillstring.simulate import ELEMENTS, Plant, Switch, simulate, simulate_batch
from slider_drilling.drillstring.virtual_rig import GroundTruth, VirtualRig, VirtualRigState

__all__ = [
    "ELEMENTS",
    "Commands",
    "DepthProfile",
    "GroundTruth",
    "InitialState",
    "Modifiers",
    "Observer",
    "Plant",
    "PlantState",
    "Response",
    "Switch",
    "VirtualRig",
    "VirtualRigState",
    "simulate",
    "simulate_batch",
]
