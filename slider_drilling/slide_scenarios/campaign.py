"""Campaigns on random rigs: one job per slide and controller, statistics of the scores, paired comparison."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

from slider_drilling.campaign.job import Job
from slider_drilling.control.controller_loader import DEFAULT_CONTROLLER
from slider_drilling.rig import load_rig
from slider_drilling.slide_scenarios.contenders import BASELINES, UNDER_TEST
from slider_drilling.slide_scenarios.drawn import DURATION_S, draw_slide
from slider_drilling.slide_scenarios.run import run_scenario
from slider_drilling.slide_scenarios.score import ALLOWED_TIME, MIN_DRILLED, MIN_HELD_SHARE, SlideScore
from slider_drilling.user_code import import_reference, source_files

SCHEMA = "slider_drilling/closed_loop_campaign/3"
QUANTILES = (0.5, 0.75, 0.9, 0.95)
WORST = 10
_CONFIDENCE, _INTERVAL = 0.95, (0.025, 0.975)
_BOOTSTRAP_SAMPLES = 2000


@dataclass(frozen=True)
class CampaignOptions:
    """What all jobs of a campaign share.

    Attributes:
        rig: Rig file that wells, strings and fluids are drawn around.
        seed: Of the campaign.
        elements: Of the string.
        duration: Of each slide, s.
        foreign: Whether plants and instruments have foreign structures.
    """

    rig: Path
    seed: int = 0
    elements: int = 60
    duration: float = DURATION_S
    foreign: bool = False


@dataclass(frozen=True)
class ScoredSlide:
    """One controller in one slide.

    Attributes:
        number: Of the slide in its campaign.
        well: Length of the string.
        about: Effects unknown to the controller.
        score: Figures of the slide.
        stops: Statuses that stopped lowering with an error.
    """

    number: int
    well: str
    about: str
    score: SlideScore
    stops: tuple[str, ...] = ()

    @property
    def error(self) -> float:
        """Mean toolface error, deg; infinite where nothing was drilled."""
        return math.inf if self.score.nothing_drilled else self.score.mean_abs_error_deg

    @property
    def set_in_time(self) -> bool:
        """Whether the toolface was set within the allowed time."""
        time = self.score.time_to_set_s
        return not self.score.nothing_drilled and time is not None and time <= ALLOWED_TIME


def slide_job(number: int, controller: str, campaign: CampaignOptions) -> Job:
    """Return the job of one slide.

    Args:
        number: Of the slide.
        controller: A baseline's name or ``module:Class``.
        campaign: What all jobs share.

    Raises:
        InputError: The controller cannot be imported.
    """
    inputs = {"rig": str(campaign.rig)}
    if controller not in BASELINES and controller != DEFAULT_CONTROLLER:
        import_reference(controller, f"controller = {controller!r}", DEFAULT_CONTROLLER)
        files = source_files(controller.partition(":")[0])
        inputs |= {f"controller {number}": str(path) for number, path in enumerate(files)}
    options = {"number": number, "controller": controller, "elements": campaign.elements,
               "duration": campaign.duration, "foreign": campaign.foreign}  # fmt: skip
    call = "slider_drilling.slide_scenarios.campaign:run_slide"
    return Job(call, f"slide {number} with {controller}", inputs, options, campaign.seed)


def run_slide(job: Job) -> dict[str, Any]:
    """Run one job and return its score as JSON values; figures that do not exist are null."""
    options = job.options
    scenario = draw_slide(options["number"], job.seed, load_rig(job.inputs["rig"]), options["duration"],
                          foreign=options["foreign"])  # fmt: skip
    controller = options["controller"]
    contender, name = (controller, DEFAULT_CONTROLLER) if controller in BASELINES else (UNDER_TEST, controller)
    noise = noise_seed(job.seed, options["number"])
    result = run_scenario(scenario, contender, noise, options["elements"], name)
    figures = {key: None if value is None or not math.isfinite(value) else value
               for key, value in asdict(result.score).items()}  # fmt: skip
    return {"number": options["number"], "well": scenario.well, "about": scenario.about, "score": figures,
            "stops": list(result.trace.stops)}  # fmt: skip


def noise_seed(seed: int, number: int) -> int:
    """Return the seed of a slide's noise: another for each slide, the same for every controller."""
    return int(np.random.default_rng((seed, number, 1)).integers(2**31))


def slide_of(tree: dict[str, Any], number: int) -> ScoredSlide:
    """Return the slide from what `run_slide` returned.

    Args:
        tree: What a job returned, read from a file that anybody may have edited.
        number: Of the job's slide.

    Raises:
        LookupError, TypeError, ValueError: It is something else, or another slide.
    """
    if type(tree["number"]) is not int or tree["number"] != number:
        raise ValueError
    if not isinstance(tree["well"], str) or not isinstance(tree["about"], str):
        raise ValueError
    if not isinstance(tree["stops"], list) or not all(isinstance(name, str) for name in tree["stops"]):
        raise ValueError
    figures: dict[str, Any] = {
        field.name: _figure(field.name, tree["score"][field.name]) for field in fields(SlideScore)
    }
    score = SlideScore(**figures)
    # Only a slide without new hole has no error.
    if math.isnan(score.mean_abs_error_deg) and score.drilled_m >= MIN_DRILLED:
        raise ValueError
    return ScoredSlide(number, tree["well"], tree["about"], score, tuple(tree["stops"]))


# Smallest and largest value of figures that have any.
_FIGURE_LIMITS = {
    "mean_abs_error_deg": (0.0, 180.0), "p95_abs_error_deg": (0.0, 180.0), "within_15_deg": (0.0, 1.0),
    "time_to_set_s": (0.0, math.inf), "peak_torque_n_m": (0.0, math.inf), "weight_spread_n": (0.0, math.inf),
    "drilled_m": (0.0, math.inf),
}  # fmt: skip


def _figure(name: str, value: object) -> float | None:
    """Return a figure of a score. Raise ValueError for a value that no slide gives."""
    if value is None:
        # A missing time means "never set"; every other missing figure was not a number.
        return None if name == "time_to_set_s" else math.nan
    low, high = _FIGURE_LIMITS.get(name, (-math.inf, math.inf))
    # An integer may be too large for a float; a comparison with one is exact.
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= sys.float_info.max:
        raise ValueError
    if not low <= value <= high:
        raise ValueError
    return float(value)


@dataclass(frozen=True)
class ScoreSummary:
    """Statistics of a controller's slides.

    Attributes:
        slides: Number of slides.
        error: Quantiles (`QUANTILES`) of the mean toolface error, deg; infinite where nothing was drilled.
        time_to_set: Quantiles of the time to set the toolface, s; infinite where it was never set.
        peak_torque: Quantiles of the peak torque, N m.
        set_in_time: Slides whose toolface was set within the allowed time.
        held: Slides whose toolface was within 15 deg for 95 % of the scored time.
        nothing_drilled: Slides without new hole.
        stopped: Slides in which an interlock stopped lowering with an error.
    """

    slides: int
    error: tuple[float, ...]
    time_to_set: tuple[float, ...]
    peak_torque: tuple[float, ...]
    set_in_time: int
    held: int
    nothing_drilled: int
    stopped: int


def summarise(slides: Sequence[ScoredSlide]) -> ScoreSummary:
    """Return the statistics of at least one slide."""

    def quantiles(values: list[float]) -> tuple[float, ...]:
        return tuple(float(value) for value in np.quantile(values, QUANTILES, method="higher"))

    scores = [slide.score for slide in slides]
    times = [math.inf if score.time_to_set_s is None else score.time_to_set_s for score in scores]
    return ScoreSummary(
        slides=len(slides), error=quantiles([slide.error for slide in slides]), time_to_set=quantiles(times),
        peak_torque=quantiles([score.peak_torque_n_m for score in scores]),
        set_in_time=sum(slide.set_in_time for slide in slides),
        held=sum(not score.nothing_drilled and score.within_15_deg >= MIN_HELD_SHARE for score in scores),
        nothing_drilled=sum(score.nothing_drilled for score in scores),
        stopped=sum(bool(slide.stops) for slide in slides),
    )  # fmt: skip


@dataclass(frozen=True)
class PairedComparison:
    """Two controllers on the same slides.

    Attributes:
        better: Slides in which the first controller has the smaller error.
        slides: Slides in which both drilled.
        probability: 95 % interval of the probability that the first is better (exact binomial test, without ties).
        difference: Mean error of the first minus the second, deg.
        interval: 95 % bootstrap interval of `difference`, deg.
    """

    better: int
    slides: int
    probability: tuple[float, float]
    difference: float
    interval: tuple[float, float]


def compare_paired(first: Sequence[ScoredSlide], second: Sequence[ScoredSlide]) -> PairedComparison | None:
    """Compare two controllers on the slides that both drilled; None where there are none."""
    errors = {slide.number: slide.error for slide in second}
    pairs = [(slide.error, errors[slide.number]) for slide in first if slide.number in errors]
    pairs = [pair for pair in pairs if all(map(math.isfinite, pair))]
    if not pairs:
        return None
    difference = np.array([a - b for a, b in pairs])
    untied = difference[difference != 0.0]
    better = int(np.sum(untied < 0.0))
    probability = binomtest(better, max(len(untied), 1)).proportion_ci(_CONFIDENCE, method="exact")
    samples = np.random.default_rng(0).integers(len(difference), size=(_BOOTSTRAP_SAMPLES, len(difference)))
    low, high = np.quantile(difference[samples].mean(axis=1), _INTERVAL)
    return PairedComparison(better, len(difference), (float(probability.low), float(probability.high)),
                            float(difference.mean()), (float(low), float(high)))  # fmt: skip


def worst(slides: Sequence[ScoredSlide]) -> list[ScoredSlide]:
    """Return the slides with the largest errors, largest first, at most `WORST`."""
    return sorted(slides, key=lambda slide: (-slide.error, slide.number))[:WORST]


def repeat_command(number: int, controller: str, campaign: CampaignOptions, custom_rig: bool) -> str:
    """Return the command that runs one slide again, with its time series on a page.

    Args:
        number: Of the slide.
        controller: A baseline's name or ``module:Class``.
        campaign: What all jobs share.
        custom_rig: Whether the campaign uses another rig file than the default.
    """
    words = ["slider-drilling closed-loop --slide", str(number), "--seed", str(campaign.seed), "--elements",
             str(campaign.elements)]  # fmt: skip
    if controller != DEFAULT_CONTROLLER and controller not in BASELINES:
        words += ["--controller", controller]
    if campaign.duration != DURATION_S:
        words += ["--duration", f"{campaign.duration:g}"]
    if campaign.foreign:
        words += ["--foreign"]
    if custom_rig:
        words += ["--rig", str(campaign.rig)]
    return " ".join([*words, "-o", f"slide_{number}"])
