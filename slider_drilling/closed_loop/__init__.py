"""Controllers on the virtual rig, without DDS: fixed scenarios, scored on truth."""

from slider_drilling.closed_loop.every_effect import every_effect
from slider_drilling.closed_loop.run import Outcome, run_all, run_scenario, tasks
from slider_drilling.closed_loop.scenario import WELLS, Scenario
from slider_drilling.closed_loop.scenarios import SCENARIOS
from slider_drilling.closed_loop.score import Score, score
from slider_drilling.closed_loop.trace import Trace

__all__ = ["SCENARIOS", "WELLS", "Outcome", "Scenario", "Score", "Trace", "every_effect", "run_all", "run_scenario",
           "score", "tasks"]
