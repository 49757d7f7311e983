"""Results of a campaign: JSON, the table of the terminal, and a page."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from slider_drilling.pages import Chart, Headline, Line, Page, Panel, Section, Table
from slider_drilling.slide_scenarios.campaign import (
    QUANTILES,
    SCHEMA,
    CampaignOptions,
    PairedComparison,
    ScoredSlide,
    ScoreSummary,
    compare_paired,
    summarise,
    worst,
)
from slider_drilling.slide_scenarios.report import set_after
from slider_drilling.slide_scenarios.score import ALLOWED_TIME, SET_TIME, TOLERANCE_DEG

TERMINAL_HEADER = ("controller", "slides", "50 %\ndeg", "90 %\ndeg", "95 %\ndeg", "held\nslides", "set\nslides",
                   "stopped\nslides", "nothing\ndrilled")  # fmt: skip
_ERROR_HEADER = ("controller", "slides", *(f"{share:.0%} below, deg" for share in QUANTILES),
                 f"within {TOLERANCE_DEG:.0f} deg for 95 % of the time, slides",
                 "stopped by an interlock, slides", "nothing drilled, slides")  # fmt: skip
_TIME_HEADER = ("controller", f"set within {ALLOWED_TIME:.0f} s, slides", "50 % set after, s", "95 % set after, s",
                "50 % peak torque below, kN m", "95 % peak torque below, kN m")  # fmt: skip
_WORST_HEADER = ("slide", "well", "effects", "mean error, deg", "within 15 deg, %", "set after, s", "repeat with")

Repeat = Callable[[int], str]


def as_json(
    slides: Mapping[str, Sequence[ScoredSlide]], options: CampaignOptions, code: str, repeat: Mapping[str, Repeat]
) -> dict[str, Any]:
    """Return the tree of closed_loop_campaign.json; figures that are not finite become null.

    Args:
        slides: By controller, the one under test first.
        options: What all jobs share.
        code: Version of the code.
        repeat: By controller, slide number -> command that runs the slide again.
    """
    controllers = {name: _controller_tree(scored, repeat[name]) for name, scored in slides.items()}
    comparisons = {f"{first} minus {second}": asdict(pair) for (first, second), pair in _comparisons(slides).items()}
    tree = {"schema": SCHEMA, "code": code, "seed": options.seed, "elements": options.elements,
            "duration_s": options.duration, "foreign": options.foreign, "rig": str(options.rig),
            "quantiles": list(QUANTILES),
            "controllers": controllers, "paired": comparisons}  # fmt: skip
    finite: dict[str, Any] = _finite(tree)
    return finite


def _controller_tree(slides: Sequence[ScoredSlide], repeat: Repeat) -> dict[str, Any]:
    rows = [{"number": slide.number, "well": slide.well, "effects": slide.about, "stops": list(slide.stops),
             **asdict(slide.score)}
            for slide in slides]  # fmt: skip
    largest = [{"number": slide.number, "error_deg": slide.error, "command": repeat(slide.number)}
               for slide in worst(slides)]  # fmt: skip
    return {"summary": asdict(summarise(slides)), "worst": largest, "slides": rows}


def _finite(tree: Any) -> Any:
    if isinstance(tree, dict):
        return {key: _finite(value) for key, value in tree.items()}
    if isinstance(tree, (list, tuple)):
        return [_finite(value) for value in tree]
    return None if isinstance(tree, float) and not math.isfinite(tree) else tree


def _comparisons(slides: Mapping[str, Sequence[ScoredSlide]]) -> dict[tuple[str, str], PairedComparison]:
    """The controller under test compared with each of the others."""
    first, *others = slides
    pairs = {(first, other): compare_paired(slides[first], slides[other]) for other in others}
    return {names: pair for names, pair in pairs.items() if pair is not None}


def terminal_row(name: str, summary: ScoreSummary) -> tuple[str, ...]:
    """One line of the terminal's table, which fits 80 columns: a cell for each of `TERMINAL_HEADER`."""
    errors = dict(zip(QUANTILES, summary.error, strict=True))
    return (name.rpartition(":")[2], str(summary.slides), *(_number(errors[share], 1) for share in (0.5, 0.9, 0.95)),
            str(summary.held), str(summary.set_in_time), str(summary.stopped),
            str(summary.nothing_drilled))  # fmt: skip


def comparison_sentences(slides: Mapping[str, Sequence[ScoredSlide]]) -> list[str]:
    """Return each comparison in a sentence."""
    return [
        f"{first} has a smaller error than {second} in {pair.better} of {pair.slides} slides (probability "
        f"{pair.probability[0]:.0%} to {pair.probability[1]:.0%}), by {-pair.difference:.1f} deg on average "
        f"[{-pair.interval[1]:.1f}, {-pair.interval[0]:.1f}]."
        for (first, second), pair in _comparisons(slides).items()
    ]  # fmt: skip


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "never"


def campaign_page(
    slides: Mapping[str, Sequence[ScoredSlide]], options: CampaignOptions, code: str, repeat: Mapping[str, Repeat]
) -> Page:
    """Return the page of a campaign.

    Args:
        slides: By controller, the one under test first.
        options: What all jobs share.
        code: Version of the code.
        repeat: By controller, slide number -> command that runs the slide again.
    """
    name = next(iter(slides))
    summaries = {controller: summarise(scored) for controller, scored in slides.items()}
    own = summaries[name]
    headline = (f"On half of {own.slides} random rigs the mean toolface error is below {_number(own.error[0], 1)} deg, "
                f"on 95 % below {_number(own.error[-1], 1)} deg; the toolface was set within {ALLOWED_TIME:.0f} s in "
                f"{own.set_in_time}.")  # fmt: skip
    return Page(
        kind="Closed-loop campaign", title=f"{name} on {own.slides} random rigs",
        facts=(("seed", str(options.seed)), ("elements", str(options.elements)), ("code", code)),
        headline=Headline(headline),
        sections=(
            Section("Toolface error", (
                f"Share of slides whose mean true toolface error, scored from {ALLOWED_TIME:.0f} s after the start, is "
                "below each value.",
                Table(_ERROR_HEADER, tuple(_error_row(*item) for item in summaries.items())),
                *comparison_sentences(slides), _error_curves(slides))),
            Section("Time to set and torque", (
                f"The toolface is set once it stays within {TOLERANCE_DEG:.0f} deg for {SET_TIME:.0f} s.",
                Table(_TIME_HEADER, tuple(_time_row(*item) for item in summaries.items())))),
            *(Section(f"Worst slides of {controller}", (Table(_WORST_HEADER, _worst_rows(scored, repeat[controller])),))
              for controller, scored in slides.items()),
        ),
    )  # fmt: skip


def _error_row(name: str, summary: ScoreSummary) -> tuple[str, ...]:
    return (name, str(summary.slides), *(_number(value, 1) for value in summary.error), str(summary.held),
            str(summary.stopped), str(summary.nothing_drilled))  # fmt: skip


def _time_row(name: str, summary: ScoreSummary) -> tuple[str, ...]:
    torque = [value / 1e3 for value in summary.peak_torque]
    return (name, str(summary.set_in_time), _number(summary.time_to_set[0], 0), _number(summary.time_to_set[-1], 0),
            f"{torque[0]:.1f}", f"{torque[-1]:.1f}")  # fmt: skip


def _worst_rows(slides: Sequence[ScoredSlide], repeat: Repeat) -> tuple[tuple[str, ...], ...]:
    return tuple(
        (str(slide.number), slide.well, slide.about, _number(slide.error, 1),
         f"{100.0 * slide.score.within_15_deg:.0f}", set_after(slide.score), repeat(slide.number))
        for slide in worst(slides)
    )  # fmt: skip


def _error_curves(slides: Mapping[str, Sequence[ScoredSlide]]) -> Chart:
    """Cumulative distribution of the mean error for each controller."""
    lines = []
    for name, scored in slides.items():
        errors = np.sort([slide.error for slide in scored if math.isfinite(slide.error)])
        lines.append(Line(name, errors, np.arange(1, len(errors) + 1) / len(scored), "steps"))
    panel = Panel("share of slides below", tuple(lines), limits=(0.0, 1.0))
    return Chart("Errors of all slides", "mean toolface error, deg", (panel,), x_log=True)
