"""The figures of a diagnosis's page, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from slider_drilling.diagnosis import sentences
from slider_drilling.diagnosis.effect_phrases import display_unit
from slider_drilling.diagnosis.result import ChannelTrace, Gap, RankedEffect, ResidualShape, ShapeOf, Where
from slider_drilling.gap.model import Array
from slider_drilling.pages import Bars, Chart, Line, Panel
from slider_drilling.pages.colours import BLUE, GREEN, GREY, INK, RED
from slider_drilling.units import split_label

_COLOURS = {"nominal": GREY, "tuned": BLUE, "with_effect": GREEN}
# Shares of a gap: an axis that shows what closes it; what reaches below is cut there, with its number beside it.
_LEAST, _MOST = -0.5, 1.2
_LOG_ABOVE = 8.0  # E


def waterfall(gap: Gap) -> Chart:
    """E as given, re-tuned and with what was found, against what noise alone reaches."""
    stages = [
        ("as given", gap.nominal, GREY),
        ("re-tuned", gap.tuned, BLUE),
        ("with what was found", gap.with_effect, GREEN),
    ]
    known = [(name, value, colour) for name, value, colour in stages if value is not None]
    values = np.array([value for _, value, _ in known])
    # The value in the name: above the bar it would lie on the dotted line wherever the two are close.
    names = tuple(f"{name}: {value:.2f}" for name, value, _ in known)
    bars = Bars("", names, values, tuple(colour for _, _, colour in known))
    level = None if gap.threshold is None else (gap.threshold, "what noise alone reaches once in 100 logs")
    below = gap.threshold is not None and bool(np.any(values < gap.threshold))
    caption = (
        "A bar below the dotted line is what noise does as a rule: 99 times of 100 it stays below it, and about 1 is "
        "its middle." if below else ""
    )  # fmt: skip
    panel = Panel("E, noise floors", (bars,), level, y_log=bool(np.any(values > _LOG_ABOVE)))
    return Chart("From the rig file as given to what was found", "", (panel,), caption)


def where_charts(where: Where) -> list[Chart]:
    """Shares of E^2 by channel, phase, band, time and place."""
    charts = []
    for title, shares in (
        ("By channel", where.channel),
        ("By phase of the motion", where.phase),
        ("By frequency", where.band),
    ):
        if shares:
            bars = Bars(
                "", tuple(sentences.plain_name(name) for name in shares), np.array(list(shares.values())), (BLUE,)
            )
            charts.append(Chart(title, "", (Panel("share", (bars,)),)))
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


def intervals(ranking: Sequence[RankedEffect]) -> Chart | None:
    """The share of the gap that each fitted effect closes, with its interval; what leaves the axis gets an arrow."""
    known = [one for one in ranking if one.closed is not None and one.interval is not None]
    if not known:
        return None
    answers = [one.interval for one in known if one.in_answer and one.interval is not None]
    low = min([_LEAST, *(interval[0] for interval in answers)])
    high = max([_MOST, *(interval[1] for interval in answers)])
    base, length, text = [], [], []
    for one in known:
        assert one.interval is not None
        begin, end = (float(np.clip(value, low, high)) for value in one.interval)
        # Some length is left to see where all of an interval lies beyond the axis.
        least = 0.01 * (high - low)
        base.append(min(begin, high - least))
        length.append(max(end - begin, least))
        out = "← " if one.interval[0] < low else ""
        text.append(f"{out}{sentences.format_share(one)}{' →' if one.interval[1] > high else ''}")
    colours = tuple(GREEN if one.in_answer else GREY for one in known)
    bars = Bars("", tuple(_beside(one) for one in known), np.array(length), colours, tuple(text),
                base=np.array(base), horizontal=True)  # fmt: skip
    caption = (
        "95 % intervals on stretches that no fit has seen; green is in the answer, an arrow goes on beyond the axis."
    )
    if any(one.beside for one in known):
        caption += " Beside others: of the gap that these leave."
    panel = Panel("", (bars,), height=max(0.3 * len(known), 1.0))
    return Chart("Share of the gap that each effect closes", "share", (panel,), caption, ((0.0, ""), (1.0, "")),
                 (low - 0.02 * (high - low), high + 0.25 * (high - low)), wide=True)  # fmt: skip


def _beside(candidate: RankedEffect) -> str:
    """An effect, and what it was found beside."""
    others = ", ".join(candidate.beside)
    return f"{candidate.effect}{f' beside {others}' if others else ''}".replace("_", " ")


_SHAPES: dict[ShapeOf, str] = {
    "unknown": "What the unknown looks like",
    "alternative": "What else would explain as much",
    "rest": "What remains looks like this",
}


def shape(found: ResidualShape) -> Chart | str:
    """A disturbance without a law under what it is the shape of; a sentence where that is one number."""
    title = _SHAPES[found.of]
    if found.x.size == 1:
        return f"{title}: {found.words}."
    x, x_label = _converted(found.x, found.x_label)
    y, y_label = _converted(found.y, found.y_label)
    return Chart(title, x_label, (Panel(y_label, (Line("", x, y),)),), found.words, wide=True)


def _converted(values: Array, label: str) -> tuple[Array, str]:
    """Values under a label "name, SI unit" in the unit that is read."""
    name, unit = split_label(label)
    read, factor = display_unit(unit)
    return factor * values, label if read == unit else f"{name}, {read}"


def traces(found: Sequence[ChannelTrace], stages: Mapping[str, str]) -> list[Chart]:
    """Measured and simulated, and what is left, one figure a channel of a run."""
    several = len({trace.run for trace in found}) > 1
    charts = []
    for trace in found:
        read, factor = display_unit(trace.unit)
        label, style = sentences.plain_name(trace.channel), "dots" if trace.time.size < 200 else "line"
        known = [(stages[stage], values, _COLOURS[stage]) for stage, values in trace.simulated.items()]
        upper = [Line("measured", trace.time, factor * trace.measured, "dots" if style == "dots" else "line", INK)]
        upper += [Line(name, trace.time, factor * values, "line", colour) for name, values, colour in known]
        lower = [
            Line(name, trace.time, factor * (trace.measured - values), "dots" if style == "dots" else "line", colour)
            for name, values, colour in known
        ]
        panels = (Panel(f"{label}, {read}", tuple(upper), height=1.4), Panel(f"difference, {read}", tuple(lower)))
        title = f"Log {trace.run + 1}: {label}" if several else label.capitalize()
        end = () if trace.fitted_until is None else ((trace.fitted_until, "not fitted from here"),)
        charts.append(Chart(title, "time, s", panels, vertical_lines=end, wide=True))
    return charts
