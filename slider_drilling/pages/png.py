"""Figures as PNG, by matplotlib."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from slider_drilling.pages.colours import LIGHT, ORDER
from slider_drilling.pages.figures import (
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
from slider_drilling.pages.plotly_js import KINDS
from slider_drilling.process.shutdown import defer_signals
from slider_drilling.units import Text, Units, split_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

_RULE = "#e0e6ec"
_STYLES: dict[str, dict[str, Any]] = {
    "line": {},
    "dashed": {"linestyle": "--"},
    "dotted": {"linestyle": ":"},
    "dots": {"linestyle": "none", "marker": "o", "markersize": 3.5},
    "steps": {"drawstyle": "steps-post"},
}


def render_png(figures: tuple[Figure, ...], units: Units, title: Text = "") -> bytes:
    """One PNG of all figures: a single figure takes the full width, several stand two in a row."""
    with defer_signals():
        return _png(figures, units, units.convert_text(title))


@contextmanager
def without_windows() -> Iterator[None]:
    """Hide MPLBACKEND while matplotlib is imported: an invalid value would make the import fail."""
    given = os.environ.pop("MPLBACKEND", None)
    try:
        yield
    finally:
        if given is not None:
            os.environ["MPLBACKEND"] = given


def _png(figures: tuple[Figure, ...], units: Units, title: str) -> bytes:
    with without_windows():
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure as Paper

    columns = 1 if len(figures) == 1 else 2
    rows = [figures[first : first + columns] for first in range(0, len(figures), columns)]
    heights = [max(_height(figure) for figure in row) for row in rows]
    width = 11.0 if columns == 1 else 7.0 * columns
    paper = Paper(figsize=(width, sum(heights) + (0.4 if title else 0.0)), dpi=110, layout="constrained")
    if title:
        paper.suptitle(title, fontsize=12)
    strips = paper.subfigures(len(rows), 1, squeeze=False, height_ratios=heights)[:, 0]
    for strip, row in zip(strips, rows, strict=True):
        for place, figure in zip(strip.subfigures(1, columns, squeeze=False)[0], row, strict=False):
            _draw(place, figure, units)
    buffer = io.BytesIO()
    FigureCanvasAgg(paper).print_png(buffer)
    return buffer.getvalue()


def _height(figure: Figure) -> float:
    return 0.8 + 1.75 * len(figure.panels) if isinstance(figure, Chart) and len(figure.panels) > 1 else 4.4


def _draw(place: SubFigure, figure: Figure, units: Units) -> None:
    place.suptitle(units.convert_text(figure.title), fontsize=10.5, x=0.02, ha="left")
    if isinstance(figure, HeatMap):
        _map(place.subplots(), figure, units)
        return
    ratios = [panel.height for panel in figure.panels]
    drawn = np.atleast_1d(place.subplots(len(ratios), 1, sharex=True, height_ratios=ratios))
    x_unit = split_label(figure.x_label)[1]
    for axes, panel in zip(drawn, figure.panels, strict=True):
        _panel(axes, figure, panel, units)
        for at, _ in figure.vertical_lines:
            axes.axvline(units.convert(at, x_unit), color=LIGHT["grey"], lw=0.9, ls=":")
    drawn[-1].set_xlabel(units.convert_label(figure.x_label))
    if figure.x_log:
        drawn[-1].set_xscale("log")
    if figure.x_limits is not None:
        drawn[-1].set_xlim(*(units.convert(end, x_unit) for end in figure.x_limits))


def _panel(axes: Axes, chart: Chart, panel: Panel, units: Units) -> None:
    unit = split_label(panel.y_label)[1]
    for number, mark in enumerate(panel.marks):
        if isinstance(mark, Bars):
            _bars(axes, mark, chart, panel, number, units)
        elif not mark.hidden:
            _line(
                axes, mark, split_label(chart.x_label)[1], unit, LIGHT[mark.colour or ORDER[number % len(ORDER)]], units
            )
    if panel.reference_line is not None:
        value, name = panel.reference_line
        axes.axhline(units.convert(value, unit), color=LIGHT["grey"], lw=0.9, ls=":", label=name)
    if panel.y_log:
        axes.set_yscale("log")
    limits = bar_limits(panel)
    if limits is not None:
        axes.set_ylim(*(units.convert(end, unit) for end in limits))
    if panel.inverted or any(isinstance(mark, Bars) and mark.horizontal for mark in panel.marks):
        axes.invert_yaxis()
    axes.set_title(units.convert_label(panel.y_label), loc="left", fontsize=9)
    if not panel.y_log and not any(isinstance(mark, Bars) for mark in panel.marks):
        axes.ticklabel_format(axis="y", useOffset=False)
    axes.grid(True, color=_RULE, linewidth=0.6)
    axes.set_axisbelow(True)
    names = axes.get_legend_handles_labels()[1]
    if len(names) > 1:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=8, ncols=min(len(names), 4), frameon=False,
                    borderaxespad=0.1, borderpad=0.1)  # fmt: skip


def _line(axes: Axes, mark: Line, x_unit: str, y_unit: str, colour: str, units: Units) -> None:
    x, y = (mark.x, mark.y) if mark.low is not None else decimate(mark.x, mark.y)
    y = without_rounding_noise(y)
    x_values = units.convert(x, x_unit)
    if mark.low is not None and mark.high is not None:
        low, high, middle = (units.convert(values, y_unit) for values in (mark.low, mark.high, mark.y))
        if mark.style == "dots":
            axes.errorbar(x_values, middle, [middle - low, high - middle], fmt="none", ecolor=colour, elinewidth=1.1)
        else:
            axes.fill_between(x_values, low, high, color=colour, alpha=0.2, linewidth=0.0)
    name = units.convert_text(mark.name) or None
    axes.plot(x_values, units.convert(y, y_unit), color=colour, linewidth=1.2, label=name, **_STYLES[mark.style])


def _bars(axes: Axes, mark: Bars, chart: Chart, panel: Panel, number: int, units: Units) -> None:
    labels = (panel.y_label, chart.x_label) if mark.horizontal else (chart.x_label, panel.y_label)
    at_unit, long_unit = (split_label(label)[1] for label in labels)
    at: Any = list(mark.x) if isinstance(mark.x, tuple) else units.convert(mark.x, at_unit)
    colours = [LIGHT[name] for name in mark.colours or (ORDER[number % len(ORDER)],)]
    long = units.convert(mark.y, long_unit)
    width: Any = 0.65 if mark.width is None else units.convert(mark.width, at_unit)
    base: Any = 0.0 if mark.base is None else units.convert(mark.base, long_unit)
    draw, rest = (axes.barh, {"left": base, "height": width}) if mark.horizontal else (
        axes.bar, {"bottom": base, "width": width})  # fmt: skip
    name = units.convert_text(mark.name) or None
    drawn = draw(at, long, color=colours if len(colours) > 1 else colours[0], label=name, **rest)
    if mark.low is not None and mark.high is not None:
        ends = [units.convert(values, long_unit) for values in (mark.y - mark.low, mark.high - mark.y)]
        where = {"x": long, "y": at, "xerr": ends} if mark.horizontal else {"x": at, "y": long, "yerr": ends}
        axes.errorbar(**where, fmt="none", ecolor=LIGHT["ink"], elinewidth=1.1)
    if mark.text:
        axes.bar_label(drawn, list(mark.text), fontsize=8, padding=2)


def _map(axes: Axes, figure: HeatMap, units: Units) -> None:
    from matplotlib.colors import ListedColormap, LogNorm, Normalize
    from matplotlib.patches import Patch

    shown = ((figure.x, figure.x_label), (figure.y, figure.y_label), (figure.value, figure.value_label))
    x, y, value = (units.convert(values, split_label(label)[1]) for values, label in shown)
    axes.set_xlabel(units.convert_label(figure.x_label))
    axes.set_ylabel(units.convert_label(figure.y_label))
    if figure.categories:
        colours = [LIGHT[name] for name in KINDS[: len(figure.categories)]]
        axes.pcolormesh(x, y, value, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(colours) - 0.5)
        patches = [Patch(color=colour, label=name) for colour, name in zip(colours, figure.categories, strict=True)]
        axes.legend(handles=patches, fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, frameon=False)
        return
    norm = LogNorm() if figure.log_colours else Normalize()
    mesh = axes.pcolormesh(x, y, value, cmap="viridis", shading="nearest", norm=norm)
    axes.get_figure().colorbar(mesh, ax=axes, label=units.convert_label(figure.value_label))  # type: ignore[union-attr]
