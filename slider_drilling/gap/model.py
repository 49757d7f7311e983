"""What the gap engine asks of a model: logged runs, nuisance parameters, effects, and a batched simulation.

A model of your own imports everything from here. `Model` is all that is needed; `Has...` and `CanTruncate` are
optional: the engine uses what a model offers. The drill string (`slider_drilling.diagnosis.drill_string`) offers all of
them, the motor-driven slide of ``docs/examples/motor_slide.py`` programmes only.
"""

from slider_drilling.gap.capabilities import (
    CanTruncate,
    HasConditionalNuisance,
    HasCoupledEffects,
    HasFidelities,
    HasObserver,
    HasProbes,
    HasUserParameters,
)
from slider_drilling.gap.effect import Array, Effect, Parameter, Values
from slider_drilling.gap.free_form import FreeForm, HasFreeForms
from slider_drilling.gap.logged_run import Channel, LoggedRun
from slider_drilling.gap.next_runs import HasProgrammes, Manoeuvre, Programmes
from slider_drilling.gap.simulated_model import Model, SimulationOptions

__all__ = [
    "Array",
    "CanTruncate",
    "Channel",
    "Effect",
    "FreeForm",
    "HasConditionalNuisance",
    "HasCoupledEffects",
    "HasFidelities",
    "HasFreeForms",
    "HasObserver",
    "HasProbes",
    "HasProgrammes",
    "HasUserParameters",
    "LoggedRun",
    "Manoeuvre",
    "Model",
    "Parameter",
    "Programmes",
    "SimulationOptions",
    "Values",
]
