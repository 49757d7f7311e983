"""Controllers on the virtual rig, without DDS: scenarios, random rigs, and scores from the true state."""

from slider_drilling.slide_scenarios.every_effect import every_effect
from slider_drilling.slide_scenarios.run import ScenarioResult, contender_pairs, run_all, run_scenario
from slider_drilling.slide_scenarios.scenario import WELLS, Scenario
from slider_drilling.slide_scenarios.scenarios import SCENARIOS
from slider_drilling.slide_scenarios.score import SlideScore, score_slide
from slider_drilling.slide_scenarios.trace import SlideTrace

__all__ = [
    "SCENARIOS",
    "WELLS",
    "Scenario",
    "ScenarioResult",
    "SlideScore",
    "SlideTrace",
    "contender_pairs",
    "every_effect",
    "run_all",
    "run_scenario",
    "score_slide",
]
