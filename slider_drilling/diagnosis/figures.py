"""The figures of the report, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from slider_drilling.diagnosis.change import Change
from slider_drilling.diagnosis.describe_curve import axis_labels
from slider_drilling.diagnosis.ranking_table import format_share
from slider_drilling.diagnosis.result import STAGE_NAMES, ChannelTrace, Gap, RankedEffect, ResidualShape
from slider_drilling.diagnosis.sentences import describe_shape
from slider_drilling.gap.model import Array
from slider_drilling.gap.results.breakdown import GapBreakdown
from slider_drilling.pages import Bars, Chart, Line, Panel
from slider_drilling.pages.colours import BLUE, GREEN, GREY, INK, RED
from slider_drilling.pages.figures import Style
from slider_drilling.plain_names import plain_name
from slider_drilling.units import Sentence, display_unit, sentence, split_label

_COLOURS = {"nominal": GREY, "tuned": BLUE, "with_effect": GREEN}
# The axis of closed shares reaches at least from here to there; intervals of effects outside the answer are cut at it.
_LOW_SHARE, _HIGH_SHARE = -0.5, 1.2
_LOG_AXIS_ABOVE = 8.0  # E
_DOTS_BELOW = 200  # samples
_LEFT_OUT = 5.0  # times the usual interval, between samples that no line joins


_TITLE = "From the rig file as given to the final model"
_CAPTION_OF_CHANGE = "Dotted: E up to which a log counts as like the baseline."


def waterfall(gap: Gap, named: bool = False, names: Mapping[str, str] = STAGE_NAMES) -> Chart:
    """E by stage, against the null threshold.

    Args:
        gap: How large the gap is.
        named: Whether the verdict names an effect.
        names: What the stages are called.
    """
    changed = names is not STAGE_NAMES
    stages = [(stage, name, getattr(gap, stage)) for stage, name in names.items()]
    known = [(stage, name, value) for stage, name, value in stages if value is not None]
    values = np.array([value for *_, value in known])
    bars = Bars("", tuple(f"{name}: {value:.2f}" for _, name, value in known), values,
                tuple(_COLOURS[stage] for stage, *_ in known), horizontal=True)  # fmt: skip
    highest = float(max([*values, gap.threshold or 0.0], default=1.0))
    log = bool(np.any(values > _LOG_AXIS_ABOVE))
    lowest = 0.5 * float(min([*values, gap.threshold or 1.0])) if log else 0.0
    level = () if gap.threshold is None else ((gap.threshold, ""),)
    title = "From the baseline's model to that with the change" if changed else _TITLE
    unit = "E, multiples of what the baseline left" if changed else "E, multiples of the noise"
    caption = _CAPTION_OF_CHANGE if changed else _waterfall_caption(gap, named)
    return Chart(title, unit, (Panel("", (bars,), height=0.25 + 0.15 * len(known)),), caption, level,
                 (lowest, 1.1 * highest), log, wide=True)  # fmt: skip


def _waterfall_caption(gap: Gap, named: bool) -> str:
    if gap.threshold is None:
        return ""
    caption = "Dotted: E up to which nothing counts as a gap; noise that is white leaves about 1."
    if named and gap.tuned is not None and gap.tuned < gap.threshold:
        caption += (
            " Calibration alone also stays below it: E does not decide here. The effect is named because it predicts "
            "parts of the log that were not fitted better than any calibration; see its row in the ranking."
        )
    return caption


def where_charts(where: GapBreakdown) -> list[Chart]:
    """Shares of E^2 by channel, phase, frequency, time and depth."""
    charts = []
    for title, shares in (
        ("By channel", where.channel),
        ("By phase of the motion", where.phase),
        ("By frequency", where.band),
    ):
        if shares:
            names, values = tuple(plain_name(name) for name in shares), np.array(list(shares.values()))
            bars = Bars("", names, values, (BLUE,), horizontal=True)
            charts.append(Chart(title, "share", (Panel("", (bars,), height=0.25 + 0.13 * len(names)),)))
    for title, label, rows in (
        ("By time", "time, s", where.time),
        ("Along the hole", "measured depth, m", where.depth),
    ):
        if rows:
            charts.append(_along(title, label, rows))
    return charts


def _along(title: str, label: str, rows: Sequence[Mapping[str, float]]) -> Chart:
    middle = np.array([0.5 * (row["from"] + row["to"]) for row in rows])
    width = np.array([0.9 * (row["to"] - row["from"]) for row in rows])
    colours = tuple(RED if row.get("change", 0.0) > 0.0 else BLUE for row in rows)
    text = tuple(f"{100.0 * row['change']:+.0f} %" if "change" in row else "" for row in rows)
    bars = Bars("", middle, np.array([row["share"] for row in rows]), colours, text if any(text) else (), width)
    return Chart(title, label, (Panel("share", (bars,)),))


def intervals(ranking: Sequence[RankedEffect], blocks: str = "stretches that no fit has seen") -> Chart | None:
    """The share of the gap that each fitted effect closes, with its interval; an arrow if it leaves the axis.

    Args:
        ranking: The effects.
        blocks: What the intervals are counted on.
    """
    known = [(ranked, ranked.interval) for ranked in ranking if ranked.closed is not None and ranked.interval]
    if not known:
        return None
    in_answer = [interval for ranked, interval in known if ranked.in_answer]
    low = min([_LOW_SHARE, *(interval[0] for interval in in_answer)])
    high = max([_HIGH_SHARE, *(interval[1] for interval in in_answer)])
    # An interval that lies beyond the axis as a whole stays visible by this length.
    shortest = 0.01 * (high - low)
    base, length, text = [], [], []
    for ranked, interval in known:
        start, end = (float(np.clip(value, low, high)) for value in interval)
        base.append(min(start, high - shortest))
        length.append(max(end - start, shortest))
        text.append(f"{'← ' if interval[0] < low else ''}{format_share(ranked)}{' →' if interval[1] > high else ''}")
    colours = tuple(GREEN if ranked.in_answer else GREY for ranked, _ in known)
    bars = Bars("", tuple(_name_with_known(ranked) for ranked, _ in known), np.array(length), colours, tuple(text),
                base=np.array(base), horizontal=True)  # fmt: skip
    caption = f"95 % intervals on {blocks}. Green: in the answer. An arrow continues beyond the axis."
    if any(ranked.known_before for ranked, _ in known):
        caption += ' "After" an effect: share of the gap that this effect leaves.'
    panel = Panel("", (bars,), height=max(0.3 * len(known), 1.0))
    return Chart("Share of the gap that each effect closes", "share", (panel,), caption, ((0.0, ""), (1.0, "")),
                 (low - 0.02 * (high - low), high + 0.25 * (high - low)), wide=True)  # fmt: skip


def _name_with_known(ranked: RankedEffect) -> str:
    """An effect, and the effects found before it."""
    known = ", ".join(plain_name(name) for name in ranked.known_before)
    return f"{plain_name(ranked.effect)}{f' after {known}' if known else ''}"


_SHAPE_TITLES = {
    "unknown": "What the unknown looks like",
    "alternative": "What else would explain as much",
    "rest": "What the remaining residual looks like",
}


def shape(residual: ResidualShape) -> Chart | Sentence:
    """A residual's shape as a curve; as a sentence if it is one number."""
    title, words = _SHAPE_TITLES[residual.of], describe_shape(residual)
    if residual.x.size == 1:
        return sentence(f"{title}: ", words, ".")
    x_label, y_label = axis_labels(residual.disturbance, residual.x_unit, residual.y_unit)
    x, x_label = _converted(residual.x, x_label)
    y, y_label = _converted(residual.y, y_label)
    return Chart(title, x_label, (Panel(y_label, (Line("", x, y),)),), words, wide=True)


def _converted(values: Array, label: str) -> tuple[Array, str]:
    """Values under a label "name, SI unit" in the unit that is shown."""
    name, unit = split_label(label)
    shown, factor = display_unit(unit)
    return factor * values, label if shown == unit else f"{name}, {shown}"


def held_share(change: Change) -> Chart | None:
    """How much of the named change the samples hold over time; None where nothing shows it."""
    if change.held is None:
        return None
    held = change.held
    shares = Line("", held.time, held.share, "dots", GREEN, held.interval[:, 0], held.interval[:, 1])
    caption = "0 is none of it, 1 is all that is named. Each dot is half a minute; whiskers are 95 % intervals."
    ends: tuple[tuple[float, str], ...] = ()
    if change.since_interval is not None:
        ends = tuple((end, "") for end in change.since_interval)
        shown_by = "these shares date it" if change.dated else "detection dates it"
        caption += f" The change began between the two lines: {shown_by}."
    panel = Panel("share of the change", (shares,), reference_line=(1.0, ""))
    return Chart("How much of the change the samples hold", "time, s", (panel,), caption, ends, wide=True)


def traces(channels: Sequence[ChannelTrace], stages: Mapping[str, str]) -> list[Chart]:
    """Measured and simulated, and their difference: one figure per channel and run.

    Args:
        channels: What to draw.
        stages: Name of each stage in the legend.
    """
    several = len({trace.run for trace in channels}) > 1
    charts = []
    for trace in channels:
        unit, factor = display_unit(trace.unit)
        name = plain_name(trace.channel)
        style: Style = "dots" if trace.time.size < _DOTS_BELOW else "line"
        simulated = [(stages[stage], values, _COLOURS[stage]) for stage, values in trace.simulated.items()]
        measured = trace.measured if style == "dots" else _broken(trace.time, trace.measured)
        upper = [Line("measured", trace.time, factor * measured, style, INK)]
        upper += [
            Line(label, trace.time, factor * _broken(trace.time, values), "line", colour)
            for label, values, colour in simulated
        ]
        lower = [
            Line(label, trace.time, factor * (measured - values), style, colour) for label, values, colour in simulated
        ]
        panels = (Panel(f"{name}, {unit}", tuple(upper), height=1.4), Panel(f"difference, {unit}", tuple(lower)))
        title = f"Log {trace.run + 1}: {name}" if several else name.capitalize()
        end = () if trace.fitted_until is None else ((trace.fitted_until, "not fitted from here"),)
        charts.append(Chart(title, "time, s", panels, vertical_lines=end, wide=True))
    return charts


def _broken(time: Array, values: Array) -> Array:
    """Values (n,) of a line with NaN where samples before them are left out: the line is broken there."""
    interval = np.diff(time)
    far = interval > _LEFT_OUT * np.median(interval) if interval.size else np.zeros(0, dtype=bool)
    return np.where(np.concatenate([[False], far]), np.nan, values)
