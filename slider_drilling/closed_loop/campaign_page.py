"""A campaign's figures: as JSON, as the lines of a table, as a page that stands alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from slider_drilling.closed_loop import campaign
from slider_drilling.closed_loop.campaign import (
    QUANTILES,
    CampaignOptions,
    PairedComparison,
    ScoredSlide,
    ScoreSummary,
    summarise,
    worst,
)
from slider_drilling.closed_loop.score import ALLOWED, HELD, WITHIN_DEG
from slider_drilling.pages import Chart, Headline, Line, Page, Panel, Section, Table

HEADS = ("controller", "slides", *(f"error deg, {q:.0%}" for q in QUANTILES), "within 15 deg for 95 %", "set in 240 s",
         "set after s, 50 %", "set after s, 95 %", "peak torque kN m, 50 %", "peak torque kN m, 95 %",
         "nothing drilled")  # fmt: skip
BRIEF = ("controller", "slides", "50 %", "90 %", "95 %", "held", "set", "idle")
WORST_HEADS = ("slide", "well", "effects", "mean error, deg", "within 15 deg, %", "set after, s", "again")

Repeat = Callable[[int], str]


def as_json(
    slides: Mapping[str, Sequence[ScoredSlide]], setting: CampaignOptions, code: str, repeat: Mapping[str, Repeat]
) -> dict[str, Any]:
    """The tree of closed_loop_campaign.json. slides, repeat: by controller, the one under test first."""
    found = {}
    for name, of in slides.items():
        rows = [{"number": one.number, "well": one.well, "effects": one.about, **asdict(one.score)} for one in of]
        again = [{"number": one.number, "error_deg": one.error, "command": repeat[name](one.number)}
                 for one in worst(of)]  # fmt: skip
        found[name] = {"spread": asdict(summarise(of)), "worst": again, "slides": rows}
    compared = {f"{first} minus {second}": asdict(one) for (first, second), one in _pairs(slides).items()}
    tree = {"schema": campaign.SCHEMA, "code": code, "seed": setting.seed, "elements": setting.elements,
            "duration_s": setting.duration, "rig": str(setting.rig), "quantiles": list(QUANTILES),
            "controllers": found, "paired": compared}  # fmt: skip
    plain: dict[str, Any] = _finite(tree)
    return plain


def _finite(tree: Any) -> Any:
    if isinstance(tree, dict):
        return {key: _finite(value) for key, value in tree.items()}
    if isinstance(tree, (list, tuple)):
        return [_finite(value) for value in tree]
    return None if isinstance(tree, float) and not math.isfinite(tree) else tree


def _pairs(slides: Mapping[str, Sequence[ScoredSlide]]) -> dict[tuple[str, str], PairedComparison]:
    """The controller under test beside each of the others."""
    names = list(slides)
    found = {(names[0], other): campaign.compare_paired(slides[names[0]], slides[other]) for other in names[1:]}
    return {pair: one for pair, one in found.items() if one is not None}


def spread_cells(name: str, found: ScoreSummary) -> tuple[str, ...]:
    """One controller's line: a cell for each of `HEADS`."""
    torque = [value / 1e3 for value in found.peak_torque]
    return (name, str(found.slides), *(_number(value, 1) for value in found.error), str(found.held),
            str(found.set_in_time), _number(found.time_to_set[0], 0), _number(found.time_to_set[-1], 0),
            f"{torque[0]:.1f}", f"{torque[-1]:.1f}", str(found.idle))  # fmt: skip


def brief_cells(name: str, found: ScoreSummary) -> tuple[str, ...]:
    """One line of the terminal's table, which fits 80 columns: a cell for each of `BRIEF`."""
    errors = dict(zip(QUANTILES, found.error, strict=True))
    return (name.rpartition(":")[2], str(found.slides), *(_number(errors[share], 1) for share in (0.5, 0.9, 0.95)),
            str(found.held), str(found.set_in_time), str(found.idle))  # fmt: skip


def pair_sentences(slides: Mapping[str, Sequence[ScoredSlide]]) -> list[str]:
    """Each comparison in a sentence."""
    return [
        f"{first} has the smaller error than {second} in {one.better} of {one.of} slides (chance {one.low:.0%} to "
        f"{one.high:.0%}), by {-one.difference:.1f} deg on average [{-one.interval[1]:.1f}, {-one.interval[0]:.1f}]."
        for (first, second), one in _pairs(slides).items()
    ]


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "never"


def campaign_page(
    slides: Mapping[str, Sequence[ScoredSlide]], setting: CampaignOptions, code: str, repeat: Mapping[str, Repeat]
) -> Page:
    """The page. slides, repeat: by controller, the one under test first."""
    name, own = next(iter(slides.items()))
    found = summarise(own)
    lead = (f"Half of {found.slides} random rigs: mean toolface error below {_number(found.error[0], 1)} deg, 95 % "
            f"below {_number(found.error[-1], 1)} deg; set within {ALLOWED:.0f} s in {found.set_in_time}.")  # fmt: skip
    rows = tuple(spread_cells(one, summarise(of)) for one, of in slides.items())
    return Page(
        kind="Closed-loop campaign", title=f"{name} on {found.slides} random rigs",
        facts=(("seed", str(setting.seed)), ("elements", str(setting.elements)), ("code", code)),
        headline=Headline(lead),
        sections=(
            Section("All slides", (
                f"Error on truth, from {ALLOWED:.0f} s after the start. Set: within {WITHIN_DEG:.0f} deg for "
                f"{HELD:.0f} s without a break.",
                Table(HEADS, rows), *pair_sentences(slides), _curves(slides))),
            *(Section(f"Worst slides of {one}", (Table(WORST_HEADS, _worst_rows(of, repeat[one])),))
              for one, of in slides.items()),
        ),
    )  # fmt: skip


def _worst_rows(slides: Sequence[ScoredSlide], repeat: Repeat) -> tuple[tuple[str, ...], ...]:
    return tuple(
        (str(one.number), one.well, one.about, _number(one.error, 1), f"{100.0 * one.score.within_15_deg:.0f}",
         "never" if one.score.time_to_set_s is None else f"{one.score.time_to_set_s:.0f}", repeat(one.number))
        for one in worst(slides)
    )  # fmt: skip


def _curves(slides: Mapping[str, Sequence[ScoredSlide]]) -> Chart:
    """How many slides stay below an error."""
    lines = []
    for name, of in slides.items():
        errors = np.sort([one.error for one in of if math.isfinite(one.error)])
        lines.append(Line(name, errors, np.arange(1, len(errors) + 1) / len(of), "steps"))
    panel = Panel("share of slides below", tuple(lines), limits=(0.0, 1.0))
    return Chart("Errors of all slides", "mean toolface error, deg", (panel,), x_log=True)
