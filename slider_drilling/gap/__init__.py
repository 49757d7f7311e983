"""The gap between a model and a log of the real thing: where it lies, which effect causes it, how far it shrinks.

The engine takes any model object (`slider_drilling.gap.model.Model`); the drill string is one.
"""

from slider_drilling.gap.explain import GapDiagnosis, explain
from slider_drilling.gap.model import Channel, Effect, LoggedRun, Manoeuvre, Model, Parameter, SimulationOptions

__all__ = [
    "Channel",
    "Effect",
    "GapDiagnosis",
    "LoggedRun",
    "Manoeuvre",
    "Model",
    "Parameter",
    "SimulationOptions",
    "explain",
]
