"""Controllers on many random rigs: a job for each slide and controller, how the figures are spread, who wins."""

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
from slider_drilling.closed_loop.contenders import BASELINES, UNDER_TEST
from slider_drilling.closed_loop.drawn import draw_slide
from slider_drilling.closed_loop.run import run_scenario
from slider_drilling.closed_loop.score import ALLOWED, HELD_SHARE, SlideScore
from slider_drilling.control.controller_loader import DEFAULT_CONTROLLER
from slider_drilling.rig import load_rig
from slider_drilling.user_code import import_reference

SCHEMA = "slider_drilling/closed_loop_campaign/1"
QUANTILES = (0.5, 0.75, 0.9, 0.95)
WORST = 10
_RESAMPLES = 2000


@dataclass(frozen=True)
class CampaignOptions:
    """What every job of a campaign shares. rig: file that wells, string and fluids are drawn from."""

    rig: Path
    seed: int = 0
    elements: int = 60
    duration: float = 900.0


@dataclass(frozen=True)
class ScoredSlide:
    """One controller in one slide. error: mean of its magnitude after setting, deg, infinite where nothing was
    drilled."""

    number: int
    well: str
    about: str
    score: SlideScore

    @property
    def error(self) -> float:
        return math.inf if self.score.nothing_drilled else self.score.mean_abs_error_deg

    @property
    def set_in_time(self) -> bool:
        """Whether the toolface was set within the time that is allowed for it."""
        after = self.score.time_to_set_s
        return not self.score.nothing_drilled and after is not None and after <= ALLOWED


def slide_job(number: int, controller: str, setting: CampaignOptions) -> Job:
    """The job of one slide. controller: a baseline's name or ``module:Class``. Raises InputError."""
    inputs = {"rig": str(setting.rig)}
    if controller not in BASELINES and controller != DEFAULT_CONTROLLER:
        import_reference(controller, f"controller = {controller!r}", DEFAULT_CONTROLLER)
        inputs["controller"] = str(sys.modules[controller.partition(":")[0]].__file__)
    options = {"number": number, "controller": controller, "elements": setting.elements, "duration": setting.duration}
    call = "slider_drilling.closed_loop.campaign:run_slide"
    return Job(call, f"slide {number} with {controller}", inputs, options, setting.seed)


def run_slide(job: Job) -> dict[str, Any]:
    """The score of one slide; figures that do not exist are null."""
    options = job.options
    scenario = draw_slide(options["number"], job.seed, load_rig(job.inputs["rig"]), options["duration"])
    name = options["controller"]
    contender, under_test = (name, DEFAULT_CONTROLLER) if name in BASELINES else (UNDER_TEST, name)
    noise = noise_seed(job.seed, options["number"])
    outcome = run_scenario(scenario, contender, noise, options["elements"], under_test)
    figures = {key: None if value is None or not math.isfinite(value) else value
               for key, value in asdict(outcome.score).items()}  # fmt: skip
    return {"number": options["number"], "well": scenario.well, "about": scenario.about, "score": figures}


def noise_seed(seed: int, number: int) -> int:
    """Every slide has noise of its own, the same for every controller."""
    return int(np.random.default_rng((seed, number, 1)).integers(2**31))


def slide_of(tree: dict[str, Any]) -> ScoredSlide:
    """From what `run_slide` returned."""
    figures = tree["score"]
    known = {field.name: figures[field.name] for field in fields(SlideScore)}
    # Only a time may be missing; a figure that does not exist is not a number.
    known = {key: math.nan if value is None and key != "time_to_set_s" else value for key, value in known.items()}
    return ScoredSlide(tree["number"], tree["well"], tree["about"], SlideScore(**known))


@dataclass(frozen=True)
class ScoreSummary:
    """How a controller's slides are spread: quantiles at `QUANTILES` of the mean error deg, the time to set s
    (infinite where it never was) and the peak torque N m; set_in_time, held (95 % of the time within 15 deg), idle
    (nothing drilled): slides."""

    slides: int
    error: tuple[float, ...]
    time_to_set: tuple[float, ...]
    peak_torque: tuple[float, ...]
    set_in_time: int
    held: int
    idle: int


def summarise(slides: Sequence[ScoredSlide]) -> ScoreSummary:
    """The spread of at least one slide."""

    def quantiles(values: list[float]) -> tuple[float, ...]:
        return tuple(float(value) for value in np.quantile(values, QUANTILES, method="higher"))

    times = [math.inf if one.score.time_to_set_s is None else one.score.time_to_set_s for one in slides]
    return ScoreSummary(
        slides=len(slides), error=quantiles([one.error for one in slides]), time_to_set=quantiles(times),
        peak_torque=quantiles([one.score.peak_torque_n_m for one in slides]),
        set_in_time=sum(one.set_in_time for one in slides),
        held=sum(not one.score.nothing_drilled and one.score.within_15_deg >= HELD_SHARE for one in slides),
        idle=sum(one.score.nothing_drilled for one in slides),
    )  # fmt: skip


@dataclass(frozen=True)
class PairedComparison:
    """Two controllers on the same slides. better: slides in which the first has the smaller error; low, high: 95 % of
    that chance; difference: mean of first minus second, deg, with its 95 % interval by resampling the slides; of:
    slides in which both drilled."""

    better: int
    of: int
    low: float
    high: float
    difference: float
    interval: tuple[float, float]


def compare_paired(first: Sequence[ScoredSlide], second: Sequence[ScoredSlide]) -> PairedComparison | None:
    """Compare two controllers over the slides that both have drilled; None where there are none."""
    other = {one.number: one.error for one in second}
    pairs = [(one.error, other[one.number]) for one in first if one.number in other]
    pairs = [pair for pair in pairs if all(map(math.isfinite, pair))]
    if not pairs:
        return None
    off = np.array([a - b for a, b in pairs])
    told = off[off != 0.0]
    better = int(np.sum(told < 0.0))
    chance = binomtest(better, max(len(told), 1)).proportion_ci(0.95, method="exact")
    picks = np.random.default_rng(0).integers(len(off), size=(_RESAMPLES, len(off)))
    low, high = np.quantile(off[picks].mean(axis=1), (0.025, 0.975))
    interval = float(low), float(high)
    return PairedComparison(better, len(off), float(chance.low), float(chance.high), float(off.mean()), interval)


def worst(slides: Sequence[ScoredSlide]) -> list[ScoredSlide]:
    """The slides with the largest error first, at most `WORST`."""
    return sorted(slides, key=lambda one: (-one.error, one.number))[:WORST]


def repeat_command(number: int, controller: str, setting: CampaignOptions, own_rig: bool) -> str:
    """The command that runs one slide again, with its traces on a page."""
    words = ["slider-drilling closed-loop --slide", str(number), "--seed", str(setting.seed), "--elements",
             str(setting.elements)]  # fmt: skip
    if controller != DEFAULT_CONTROLLER and controller not in BASELINES:
        words += ["--controller", controller]
    if own_rig:
        words += ["--rig", str(setting.rig)]
    return " ".join([*words, "-o", f"slide_{number}"])
