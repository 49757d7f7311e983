"""Figures as specifications for plotly.js. Colours are names ("@blue"); the page replaces them by its theme."""

from __future__ import annotations

from typing import Any

import numpy as np

from slider_drilling.pages.colours import AMBER, BLUE, GREEN, GREY, ORDER, SKY
from slider_drilling.pages.figures import (
    Array,
    Bars,
    Chart,
    Figure,
    HeatMap,
    Line,
    Panel,
    bar_limits,
    decimate,
    without_rounding_noise,
)
from slider_drilling.units import Units, split_label

KINDS = (SKY, AMBER, GREEN, GREY, BLUE)  # colours of a map of categories
_DASH = {"dashed": "dash", "dotted": "dot"}
_PANEL, _SINGLE, _BETWEEN = 165.0, 300.0, 38.0  # px: height of a panel among others, of a single one, the gap


def plotly_spec(figure: Figure, units: Units) -> dict[str, Any]:
    """Keys ``data`` and ``layout`` for Plotly.react, ``legend`` (name, colour, style, hidden) and ``height`` in px."""
    return _map(figure, units) if isinstance(figure, HeatMap) else _chart(figure, units)


def _chart(chart: Chart, units: Units) -> dict[str, Any]:
    data: list[dict[str, Any]] = []
    legend: dict[str, dict[str, Any]] = {}
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    alone = _SINGLE if len(chart.panels) == 1 else _PANEL
    heights = [alone * panel.height for panel in chart.panels]
    total = sum(heights) + _BETWEEN * (len(heights) - 1)
    layout: dict[str, Any] = {"shapes": shapes, "annotations": notes, "barmode": "overlay", "bargap": 0.35,
                              "hoversubplots": "axis", "hovermode": _hover(chart)}  # fmt: skip
    top, x_unit = total, split_label(chart.x_label)[1]
    for place, (panel, height) in enumerate(zip(chart.panels, heights, strict=True), start=1):
        axis, domain = f"y{place if place > 1 else ''}", [max((top - height) / total, 0.0), top / total]
        for index, mark in enumerate(panel.marks):
            colour = _colour(mark, index)
            traces = _traces(mark, chart, panel, units, colour)
            name = units.convert_text(mark.name)
            data += [{**trace, "yaxis": axis, "name": name} for trace in traces]
            if name:
                legend.setdefault(name, {"name": name, **_entry(mark, colour)})
        layout[f"yaxis{axis[1:]}"] = _axis(
            panel.marks, bar_limits(panel), panel.y_label, units, panel.y_log, panel.inverted, flat=True
        )
        layout[f"yaxis{axis[1:]}"] |= {"domain": domain}
        reference = panel.reference_line
        beside = f" · dotted: {reference[1]}" if reference is not None and reference[1] else ""
        notes.append(_heading(_capitalised(panel.y_label, units) + beside, domain[1]))
        if panel.reference_line is not None:
            shapes.append(_level(units.convert(panel.reference_line[0], split_label(panel.y_label)[1]), axis))
        shapes += [_upright(units.convert(at, x_unit), axis) for at, _ in chart.vertical_lines]
        top -= height + _BETWEEN
    notes += [_upright_name(units.convert(at, x_unit), name, chart.x_log) for at, name in chart.vertical_lines if name]
    marks = tuple(mark for panel in chart.panels for mark in panel.marks)
    layout["xaxis"] = _axis(marks, chart.x_limits, chart.x_label, units, chart.x_log, False, flat=False)
    layout["xaxis"] |= {"anchor": axis, "title": {"text": _capitalised(chart.x_label, units), "standoff": 6}}
    listed = list(legend.values())
    return {"data": data, "layout": layout, "legend": listed if len(listed) > 1 else [], "height": total + 70.0}


def _hover(chart: Chart) -> str:
    """One hover box for all lines; that of the nearest point if curves turn back or there are bars."""
    for mark in (mark for panel in chart.panels for mark in panel.marks):
        if isinstance(mark, Bars) or bool(np.any(np.diff(mark.x) < 0.0)):
            return "closest"
    return "x unified"


def _entry(mark: Line | Bars, colour: str) -> dict[str, Any]:
    style = "bars" if isinstance(mark, Bars) else mark.style
    return {"colour": colour, "style": style, "hidden": isinstance(mark, Line) and mark.hidden}


def _colour(mark: Line | Bars, index: int) -> str:
    named = mark.colours[0] if isinstance(mark, Bars) and mark.colours else getattr(mark, "colour", "")
    return f"@{named or ORDER[index % len(ORDER)]}"


def _capitalised(label: str, units: Units) -> str:
    text = units.convert_label(label)
    return text[:1].upper() + text[1:]


def rounded_numbers(values: Array) -> list[float | None]:
    """Values for JSON, rounded to save space; None for NaN.

    They are rounded to the resolution of a screen over their span. Much smaller values keep four digits, since a
    logarithmic axis shows them.
    """
    there = values[np.isfinite(values)]
    span = (float(np.ptp(there)) or float(np.abs(there[0]))) if there.size else 0.0
    decimals = 5 - int(np.floor(np.log10(span))) if span > 0.0 else 0

    def short(value: float) -> float:
        return round(value, decimals) if abs(value) > 1e-4 * span else float(f"{value:.4g}")

    return [short(value) if np.isfinite(value) else None for value in values.tolist()]


def _traces(mark: Line | Bars, chart: Chart, panel: Panel, units: Units, colour: str) -> list[dict[str, Any]]:
    if isinstance(mark, Bars):
        return _bars(mark, chart, panel, units, colour)
    return _line(mark, chart, panel, units, colour)


def _line(mark: Line, chart: Chart, panel: Panel, units: Units, colour: str) -> list[dict[str, Any]]:
    x_unit, y_unit = split_label(chart.x_label)[1], split_label(panel.y_label)[1]
    x, y = (mark.x, mark.y) if mark.low is not None else decimate(mark.x, mark.y, chart.max_points)
    y = without_rounding_noise(y)
    trace: dict[str, Any] = {
        "type": "scatter",
        "x": rounded_numbers(units.convert(x, x_unit)), "y": rounded_numbers(units.convert(y, y_unit)),
        "mode": "markers" if mark.style == "dots" else "lines",
        "line": {"color": colour, "width": 1.5, "dash": _DASH.get(mark.style, "solid"),
                 "shape": "hv" if mark.style == "steps" else "linear"},
        "marker": {"color": colour, "size": 6},
        **({"visible": "legendonly"} if mark.hidden else {}),
    }  # fmt: skip
    if mark.low is None or mark.high is None:
        return [trace]
    low, high = units.convert(mark.low, y_unit), units.convert(mark.high, y_unit)
    if mark.style == "dots":
        trace["error_y"] = _whiskers(low, units.convert(mark.y, y_unit), high, colour)
        return [trace]
    edge = {**trace, "line": {"width": 0, "color": colour}, "hoverinfo": "skip"}
    return [{**edge, "y": rounded_numbers(low)},
            {**edge, "y": rounded_numbers(high), "fill": "tonexty", "fillcolor": f"{colour}33"}, trace]  # fmt: skip


def _bars(mark: Bars, chart: Chart, panel: Panel, units: Units, colour: str) -> list[dict[str, Any]]:
    labels = (panel.y_label, chart.x_label) if mark.horizontal else (chart.x_label, panel.y_label)
    at_unit, long_unit = (split_label(label)[1] for label in labels)
    at = list(mark.x) if isinstance(mark.x, tuple) else rounded_numbers(units.convert(mark.x, at_unit))
    along = rounded_numbers(units.convert(mark.y, long_unit))
    colours = [f"@{name}" for name in mark.colours] if len(mark.colours) > 1 else colour
    trace: dict[str, Any] = {
        "type": "bar", "x": along if mark.horizontal else at, "y": at if mark.horizontal else along,
        "orientation": "h" if mark.horizontal else "v", "marker": {"color": colours}, "cliponaxis": False,
    }  # fmt: skip
    if mark.text:
        trace |= {"text": list(mark.text), "textposition": "outside"}
    if mark.width is not None:
        trace["width"] = rounded_numbers(units.convert(mark.width, at_unit))
    if mark.base is not None:
        trace["base"] = rounded_numbers(units.convert(mark.base, long_unit))
    if mark.low is not None and mark.high is not None:
        low, high, end = (units.convert(values, long_unit) for values in (mark.low, mark.high, mark.y))
        trace["error_x" if mark.horizontal else "error_y"] = _whiskers(low, end, high, "@ink")
    return [trace]


def _whiskers(low: Array, middle: Array, high: Array, colour: str) -> dict[str, Any]:
    return {"type": "data", "symmetric": False, "array": rounded_numbers(high - middle),
            "arrayminus": rounded_numbers(middle - low), "color": colour, "thickness": 1.4}  # fmt: skip


def _axis(
    marks: tuple[Line | Bars, ...], limits: tuple[float, float] | None, label: str, units: Units, log: bool, down: bool,
    flat: bool,
) -> dict[str, Any]:  # fmt: skip
    """An axis for these marks: categories from the top down, round ticks on a logarithmic axis."""
    unit = split_label(label)[1]
    if any(isinstance(mark, Bars) and mark.horizontal == flat and isinstance(mark.x, tuple) for mark in marks):
        return {"automargin": True, "type": "category", "autorange": "reversed" if flat else True}
    axis: dict[str, Any] = {"automargin": True, "type": "log" if log else "linear", "minexponent": 6}
    seen = limits or _extent(marks, flat)
    if log and seen is not None:
        ticks = round_ticks(*(units.convert(end, unit) for end in seen))
        axis |= {"tickvals": ticks, "ticktext": [f"{tick:g}" for tick in ticks]}
    if limits is None and (flat or log or seen is None or any(isinstance(mark, Bars) for mark in marks)):
        return {**axis, "autorange": "reversed" if down else True}
    assert seen is not None
    ends = [units.convert(end, unit) for end in seen]
    if limits is None:  # room for the dots at the ends
        room = 0.01 * (ends[1] - ends[0] or 1.0)
        ends = [ends[0] - room, ends[1] + room]
    ends = [float(np.log10(end)) for end in ends] if log else ends
    return {**axis, "range": ends[::-1] if down else ends}


def _extent(marks: tuple[Line | Bars, ...], along_y: bool) -> tuple[float, float] | None:
    """Smallest and largest number along this axis; None without any."""
    held = []
    for mark in marks:
        upright = isinstance(mark, Line) or not mark.horizontal
        values = mark.y if along_y == upright else mark.x
        if not isinstance(values, tuple):
            held.append(values[np.isfinite(values)])
    every = np.concatenate(held) if held else np.empty(0)
    return (float(every.min()), float(every.max())) if every.size else None


def round_ticks(low: float, high: float) -> list[float]:
    """Ticks of a logarithmic axis: 1, 2 and 5 times powers of ten from below ``low`` to above ``high``.

    Over more than five decades powers of ten alone; within one decade seven steps.
    """
    low = max(low, high * 1e-12, 1e-300)
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(max(high, low)))) + 1)
    steps: tuple[float, ...] = (1.0, 2.0, 5.0)
    if len(decades) > 5:
        steps = (1.0,)
    elif high < 10.0 * low:
        steps = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0)
    return [tick for decade in decades for tick in (step * 10.0**decade for step in steps) if tick <= 5.0 * high]


def _heading(text: str, top: float) -> dict[str, Any]:
    return {"text": text, "xref": "paper", "yref": "paper", "x": 0, "y": top, "xanchor": "left", "yanchor": "bottom",
            "showarrow": False, "font": {"size": 12.5}, "yshift": 3}  # fmt: skip


def _level(value: float, axis: str) -> dict[str, Any]:
    return {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "yref": axis, "y0": value, "y1": value,
            "line": {"color": "@grey", "width": 1, "dash": "dot"}}  # fmt: skip


def _upright(at: float, axis: str) -> dict[str, Any]:
    return {"type": "line", "xref": "x", "yref": f"{axis} domain", "x0": at, "x1": at, "y0": 0, "y1": 1,
            "line": {"color": "@grey", "width": 1, "dash": "dot"}}  # fmt: skip


def _upright_name(at: float, name: str, log: bool) -> dict[str, Any]:
    return {"text": name, "xref": "x", "x": float(np.log10(at)) if log else at, "yref": "paper", "y": 1,
            "yanchor": "bottom", "xanchor": "left", "showarrow": False, "font": {"size": 11, "color": "@grey"},
            "yshift": 3}  # fmt: skip


def _map(figure: HeatMap, units: Units) -> dict[str, Any]:
    converted = units.convert(figure.value, split_label(figure.value_label)[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        value = np.log10(converted) if figure.log_colours else converted
    name = units.convert_label(figure.value_label)
    bar: dict[str, Any] = {"title": {"text": f"log10 of {name}" if figure.log_colours else name, "side": "right"},
                           "thickness": 12, "outlinewidth": 0}  # fmt: skip
    trace: dict[str, Any] = {
        "type": "heatmap", "x": rounded_numbers(units.convert(figure.x, split_label(figure.x_label)[1])),
        "y": rounded_numbers(units.convert(figure.y, split_label(figure.y_label)[1])),
        "z": [rounded_numbers(row) for row in value], "colorscale": "Viridis", "colorbar": bar,
    }  # fmt: skip
    legend = []
    if figure.categories:
        count = len(figure.categories)
        steps = [[edge / count, f"@{KINDS[k]}"] for k in range(count) for edge in (k, k + 1)]
        trace |= {"colorscale": steps, "zmin": -0.5, "zmax": count - 0.5, "showscale": False}
        legend = [{"name": name, "colour": f"@{KINDS[k]}", "style": "bars", "hidden": False}
                  for k, name in enumerate(figure.categories)]  # fmt: skip
    layout = {
        "xaxis": {"title": {"text": _capitalised(figure.x_label, units), "standoff": 6}, "automargin": True},
        "yaxis": {"automargin": True},
        "annotations": [_heading(_capitalised(figure.y_label, units), 1.0)],
        "shapes": [], "hovermode": "closest",
    }
    return {"data": [trace], "layout": layout, "legend": legend, "height": _SINGLE + 70.0}
