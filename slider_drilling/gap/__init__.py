"""The gap engine: where a model and a log of the real thing differ, which effect causes it, and how much it closes.

You provide a `Model`: logged runs, nuisance parameters, a catalogue of effects, and a batched simulation. The engine
knows nothing of drill strings. `explain` then works in this order:

1. Noise floor of every channel, from the log (`problem.noise`).
2. Calibration: the nuisance parameters are fitted from several starts (`selection.calibration`).
3. Adequacy: does the calibrated model leave more than its own replicates do (`evidence.adequacy`)? If not, stop.
4. Screen: every effect is scored by one linearised step (`search.screen`).
5. Race: fits of all effects run side by side, and the worse half stops early (`search.race`).
6. Refit: the finalists are finished in fine simulations and cross-validated (`selection.candidates`).
7. Criteria: each is tested against the current model (`selection.naming_criteria`, `criteria_table`).
8. Accept the best that passes, drop effects that are no longer needed, and go back to 3
   (`selection.forward_selection`).
9. Free-form alternatives: does a curve without a law, at any site, predict better than the named effects
   (`evidence.free_forms`)?
10. Verdict (`selection.verdict`), with breakdown, intervals and the recommended next run (`results`).
"""

from slider_drilling.gap.explain import GapDiagnosis, explain
from slider_drilling.gap.model import Channel, Effect, LoggedRun, Manoeuvre, Model, Parameter, SimulationOptions
from slider_drilling.gap.selection.naming_criteria import criteria_table

__all__ = [
    "Channel",
    "Effect",
    "GapDiagnosis",
    "LoggedRun",
    "Manoeuvre",
    "Model",
    "Parameter",
    "SimulationOptions",
    "criteria_table",
    "explain",
]
