"""Charts of a log against the depth of the hole."""

from __future__ import annotations

import numpy as np

from slider_drilling.log.contents import displayed
from slider_drilling.log.series import Array, LogContents
from slider_drilling.pages import Chart, Line, Panel
from slider_drilling.pages.colours import BLUE, RED

MAX_BINS = 60
MIN_BIN = 0.05  # m; in thinner bins the bit turns less than once at drilling rates
PLOTTED = (
    ("truth_weight_on_bit", "value"),
    ("draw_works", "effort"),
    ("top_drive", "effort"),
    ("standpipe_pressure", "value"),
)


def depth_charts(log: LogContents) -> tuple[Chart, ...]:
    """Charts against the depth of the hole, downwards: mean, lowest and highest value in each bin of new hole.

    None where the log does not hold the bit's depth or no new hole was made.
    """
    series = log.truth_depth if log.truth_depth is not None else log.bit_depth
    if series is None:
        return ()
    given = ~np.isnan(series.position)
    time, hole = series.time[given], np.maximum.accumulate(series.position[given])
    if not len(hole) or hole[-1] - hole[0] < 2.0 * MIN_BIN:
        return ()
    count = int(min(MAX_BINS, max((hole[-1] - hole[0]) / MIN_BIN, 2.0)))
    edges = np.linspace(hole[0], hole[-1], count + 1)
    # A bin was drilled between the first times that the hole was as deep as its edges.
    reached = np.interp(edges, *_strictly_rising(hole, time))
    middle = 0.5 * (edges[1:] + edges[:-1])
    rate = np.diff(edges) / np.maximum(np.diff(reached), 1e-9) * 3600.0
    charts = [_chart("Rate of penetration", "rate of penetration, m/h", middle, rate)]
    for key, array in PLOTTED:
        plotted = displayed(log, key, array)
        if plotted is None:
            continue
        label, unit, at, values = plotted
        low, mean, high = _binned(at, values, reached)
        if np.isfinite(mean).any():
            charts.append(_chart(label.capitalize(), f"{label}, {unit}", middle, mean, low, high))
    tool_face = _tool_face_chart(log, edges, reached)
    return (*charts, tool_face) if tool_face is not None else tuple(charts)


def _strictly_rising(hole: Array, time: Array) -> tuple[Array, Array]:
    """Strictly rising depths, and the time at which each was first reached."""
    first = np.append(True, np.diff(hole) > 0.0)
    return hole[first], time[first]


def _tool_face_chart(log: LogContents, depth: Array, reached: Array) -> Chart | None:
    """MWD toolfaces at the depth of the hole when they were measured."""
    if log.mwd_tool_face is None:
        return None
    mwd = log.mwd_tool_face
    inside = (mwd.time >= reached[0]) & (mwd.time <= reached[-1])
    if not inside.any():
        return None
    degrees = 180.0 - (180.0 - np.degrees(mwd.position[inside])) % 360.0
    dots = Line("MWD", degrees, np.interp(mwd.time[inside], reached, depth), "dots", RED)
    return Chart("Toolface", "MWD toolface, deg", (Panel("bit depth, m", (dots,), inverted=True),))


def _binned(time: Array, value: Array, edges: Array) -> Array:
    """Lowest, mean and highest of the finite values between consecutive times, (3, n); NaN where there is none."""
    binned = np.full((3, len(edges) - 1), np.nan)
    for k in range(len(edges) - 1):
        inside = value[(time >= edges[k]) & (time < edges[k + 1])]
        inside = inside[np.isfinite(inside)]
        if inside.size:
            binned[:, k] = inside.min(), inside.mean(), inside.max()
    return binned


def _chart(
    title: str, label: str, depth: Array, value: Array, low: Array | None = None, high: Array | None = None
) -> Chart:
    lines = [Line("mean", value, depth, colour=BLUE)]
    if low is not None and high is not None:
        lines += [Line("lowest and highest", low, depth, "dotted", RED), Line("", high, depth, "dotted", RED)]
    return Chart(title, label, (Panel("bit depth, m", tuple(lines), inverted=True),))
