"""What a figure shows, as plain data: no plotting library and no units chosen yet.

A label that ends in ", UNIT" says what unit its numbers are in; see `slider_drilling.units`.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slider_drilling.units import Text

Array = NDArray[np.float64]
Style = Literal["line", "dashed", "dotted", "dots", "steps"]


@dataclass(frozen=True)
class Line:
    """One curve, or dots: x and y are (n,), NaN breaks the line.

    colour: a name of `colours`; "" takes the next one. low, high: (n,) of an interval around y, drawn as whiskers at
    dots and as a band around a line. hidden: listed in the legend, shown when asked for.
    """

    name: str
    x: Array
    y: Array
    style: Style = "line"
    colour: str = ""
    low: Array | None = None
    high: Array | None = None
    hidden: bool = False


@dataclass(frozen=True)
class Bars:
    """Bars at names or at numbers (with their widths) along x; flat: along y, the lengths along x.

    colours: one for all or one each; text: what is written at each; base: where each begins, 0 if not given; low, high:
    of an interval around each end.
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
    """One pair of axes. level: a horizontal line to compare with, and its name or none; down: the axis points down, as
    depth does; limits: of the axis, in the label's unit, where the data's own will not do; height: beside other
    panels'.
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
    """Panels one below the other over one x axis. at: upright lines at these x, each with its name; x_limits as a
    panel's limits; x_log for a logarithmic axis; wide: takes a page's whole width; points: how many a
    line is thinned to."""

    title: str
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
    """A value over a grid: x is (n,), y is (m,), value is (m, n), NaN where there is none.

    categories: names of the values 0, 1, 2 ... where value is a kind, not a number; log: of its colours.
    """

    title: str
    x_label: str
    y_label: str
    value_label: str
    x: Array
    y: Array
    value: Array
    categories: tuple[str, ...] = ()
    log: bool = False
    caption: Text = ""


Figure = Chart | HeatMap


def line(name: str, x: ArrayLike, y: ArrayLike, style: Style = "line", colour: str = "", hidden: bool = False) -> Line:
    """A Line from anything that numpy takes."""
    return Line(name, np.asarray(x, dtype=float), np.asarray(y, dtype=float), style, colour, hidden=hidden)


def wrap_degrees(degrees: Array) -> Array:
    """Degrees within -180..180, a copy with NaN where the curve passes the fold, so that no line crosses the panel."""
    value: Array = 180.0 - (180.0 - degrees) % 360.0
    with np.errstate(invalid="ignore"):
        value[1:][np.abs(np.diff(value)) > 180.0] = np.nan
    return value


def decimate(x: Array, y: Array, points: int = 2000) -> tuple[Array, Array]:
    """At most about `points` samples of (n,) x and y: each stretch's lowest and highest y, and x where it turns back.

    A stretch with a NaN keeps one, so that a broken line stays broken.
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
            if not gap.any():  # as nearly all are: the functions that pass over NaN take ten times as long
                kept.update((first + int(stretch.argmin()), first + int(stretch.argmax())))
                continue
            kept.add(first + int(gap.argmax()))
            if not gap.all():
                kept.update((first + int(np.nanargmin(stretch)), first + int(np.nanargmax(stretch))))
    index = np.array(sorted(kept))
    return x[index], y[index]
