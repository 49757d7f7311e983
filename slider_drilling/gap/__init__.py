"""The gap between a model and a log of the real thing: where it lies, which effect causes it, how far it shrinks.

The engine takes any model object (`slider_drilling.gap.model.Model`); the drill string is one.
"""

from slider_drilling.gap.explain import Answer, explain
from slider_drilling.gap.model import Channel, Effect, How, Manoeuvre, Model, Parameter, Run

__all__ = ["Answer", "Channel", "Effect", "How", "Manoeuvre", "Model", "Parameter", "Run", "explain"]
