"""Figures as plain data, independent of plotting library and display units.

A label that ends in ", UNIT" gives the unit of its numbers; see `slider_drilling.units`.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slider_drilling.angles import wrap_degrees
from slider_drilling.units import Text

Array = NDArray[np.float64]
ROUNDING_NOISE = 1e-9
"""In the unit of a figure: no quantity that pages show is that small, so a curve of such values is zero."""
Style = Literal["line", "dashed", "dotted", "dots", "steps"]


@dataclass(frozen=True)
class Line:
    """A curve or dots.

    Attributes:
        name: Legend entry.
        x: (n,), in the unit of the chart's x label.
        y: (n,), in the unit of the panel's label; NaN breaks the line.
        style: How it is drawn.
        colour: A name of `colours`; "" takes the next one.
        low: (n,), lower end of an interval around y: whiskers at dots, a band around a line.
        high: (n,), upper end.
        hidden: Listed in the legend, drawn on a click.
    """

    name: Text
    x: Array
    y: Array
    style: Style = "line"
    colour: str = ""
    low: Array | None = None
    high: Array | None = None
    hidden: bool = False


@dataclass(frozen=True)
class Bars:
    """Bars.

    Attributes:
        name: Legend entry.
        x: Names (categories) or positions (n,).
        y: Lengths (n,).
        colours: One for all, or one each.
        text: Text at each bar.
        width: (n,), with positions.
        base: (n,), where each bar starts; 0 if None.
        low: (n,), lower end of an interval around the end of each bar.
        high: (n,), upper end.
        horizontal: Bars lie: names or positions along y, lengths along x.
    """

    name: str
    x: tuple[str, ...] | Array
    y: Array
    colours: tuple[str, ...] = ()
    text: tuple[str, ...] = ()
    width: Array | None = None
    base: Array | None = None
    low: Array | None = None
    high: Array | None = None
    horizontal: bool = False


@dataclass(frozen=True)
class Panel:
    """One pair of axes.

    Attributes:
        y_label: Label of the y axis.
        marks: Lines and bars.
        reference_line: y and name (may be empty) of a horizontal line.
        y_log: Logarithmic axis.
        inverted: The axis points down, as depth does.
        limits: Limits of the axis in the label's unit; those of the data if None.
        height: Relative to the other panels.
    """

    y_label: str
    marks: tuple[Line | Bars, ...]
    reference_line: tuple[float, str] | None = None
    y_log: bool = False
    inverted: bool = False
    limits: tuple[float, float] | None = None
    height: float = 1.0


@dataclass(frozen=True)
class Chart:
    """Panels below each other with a common x axis.

    Attributes:
        title: Heading.
        x_label: Label of the x axis.
        panels: From the top.
        caption: Text below.
        vertical_lines: x and name (may be empty) of vertical lines through all panels.
        x_limits: Limits in the label's unit; those of the data if None.
        x_log: Logarithmic axis.
        wide: Takes the whole width of a page.
        max_points: Lines are decimated to about as many points.
    """

    title: Text
    x_label: str
    panels: tuple[Panel, ...]
    caption: Text = ""
    vertical_lines: tuple[tuple[float, str], ...] = ()
    x_limits: tuple[float, float] | None = None
    x_log: bool = False
    wide: bool = False
    max_points: int = 2000


@dataclass(frozen=True)
class HeatMap:
    """A value over a grid.

    Attributes:
        title: Heading.
        x_label: Label of the x axis.
        y_label: Label of the y axis.
        value_label: Label of the colour bar.
        x: (n,).
        y: (m,).
        value: (m, n); NaN where there is none.
        categories: Names of the values 0, 1, 2 ..., if values are categories.
        log_colours: Logarithmic colour scale.
        caption: Text below.
    """

    title: Text
    x_label: str
    y_label: str
    value_label: str
    x: Array
    y: Array
    value: Array
    categories: tuple[str, ...] = ()
    log_colours: bool = False
    caption: Text = ""


Figure = Chart | HeatMap


def line(name: str, x: ArrayLike, y: ArrayLike, style: Style = "line", colour: str = "", hidden: bool = False) -> Line:
    """A `Line` from sequences or arrays."""
    return Line(name, np.asarray(x, dtype=float), np.asarray(y, dtype=float), style, colour, hidden=hidden)


def wrapped_curve(degrees: Array) -> Array:
    """Degrees wrapped to -180..180, with NaN where the curve wraps, so that no line crosses the panel."""
    value = wrap_degrees(degrees)
    with np.errstate(invalid="ignore"):
        value[1:][np.abs(np.diff(value)) > 180.0] = np.nan
    return value


def without_rounding_noise(values: Array) -> Array:
    """The values; zeros if all are smaller than any quantity that pages show in its unit."""
    there = np.abs(values[np.isfinite(values)])
    if there.size and there.max() < ROUNDING_NOISE:
        return np.where(np.isfinite(values), 0.0, values)
    return values


def bar_limits(panel: Panel) -> tuple[float, float] | None:
    """Limits of the value axis: those of the panel; on a logarithmic axis room below the smallest bar."""
    upright = [mark for mark in panel.marks if isinstance(mark, Bars) and not mark.horizontal]
    if panel.limits is not None or not panel.y_log or not upright:
        return panel.limits
    ends = np.concatenate([mark.y for mark in upright])
    if panel.reference_line is not None:
        ends = np.append(ends, panel.reference_line[0])
    ends = ends[np.isfinite(ends) & (ends > 0.0)]
    return (0.5 * float(ends.min()), 1.3 * float(ends.max())) if ends.size else None


def decimate(x: Array, y: Array, points: int = 2000) -> tuple[Array, Array]:
    """Reduce a curve to about ``points`` samples, keeping the minimum and maximum of each stretch.

    If x is not monotonic, the extremes of x are kept too. A stretch with a NaN keeps one: a broken line stays broken.

    Args:
        x: (n,).
        y: (n,).
        points: Samples to keep, approximately.

    Returns:
        Decimated x and y.
    """
    if len(x) <= points:
        return x, y
    loops = bool(np.any(np.diff(x) < 0.0))
    edges = np.linspace(0, len(x), points // (4 if loops else 2) + 1).astype(int)
    kept = {0, len(x) - 1}
    for first, last in itertools.pairwise(edges):
        for values in (y, x) if loops else (y,):
            stretch = values[first:last]
            gap = np.isnan(stretch)
            if not gap.any():  # the usual case: nanargmin and nanargmax take ten times as long
                kept.update((first + int(stretch.argmin()), first + int(stretch.argmax())))
                continue
            kept.add(first + int(gap.argmax()))
            if not gap.all():
                kept.update((first + int(np.nanargmin(stretch)), first + int(np.nanargmax(stretch))))
    index = np.array(sorted(kept))
    return x[index], y[index]
