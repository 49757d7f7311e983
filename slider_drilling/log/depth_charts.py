"""A log against the bit's depth: what the rig did at each metre of new hole."""

from __future__ import annotations

import numpy as np

from slider_drilling.log.series import Array, LogContents
from slider_drilling.pages import Chart, Line, Panel
from slider_drilling.pages.colours import BLUE, RED

BINS = 60
LEAST = 0.05  # m; thinner bins than this hold less than one turn of a bit at drilling rates


def depth_charts(log: LogContents) -> tuple[Chart, ...]:
    """Charts with the hole's depth downwards: each channel's mean over slices of new hole, with its lowest and
    highest. Empty where the log does not know the bit's depth or no new hole was made."""
    series = log.truth_depth if log.truth_depth is not None else log.bit_depth
    if series is None:
        return ()
    there = ~np.isnan(series.position)
    time, hole = series.time[there], np.maximum.accumulate(series.position[there])
    if not len(hole) or hole[-1] - hole[0] < 2.0 * LEAST:
        return ()
    count = int(min(BINS, max((hole[-1] - hole[0]) / LEAST, 2.0)))
    edges = np.linspace(hole[0], hole[-1], count + 1)
    # When each slice was drilled: the first time that the hole was that deep.
    passed = np.interp(edges, *_rising(hole, time))
    middle = 0.5 * (edges[1:] + edges[:-1])
    rate = np.diff(edges) / np.maximum(np.diff(passed), 1e-9) * 3600.0
    charts = [_chart("Rate of penetration", "rate of penetration, m/h", middle, rate)]
    for title, label, values in _channels(log):
        found = _binned(values[0], values[1], passed)
        if np.isfinite(found).any():
            charts.append(_chart(title, label, middle, found[1], found[0], found[2]))
    tool_face = _tool_faces(log, edges, passed)
    return (*charts, tool_face) if tool_face is not None else tuple(charts)


def _rising(hole: Array, time: Array) -> tuple[Array, Array]:
    """Strictly rising depths and the time at which each was first reached."""
    first = np.append(True, np.diff(hole) > 0.0)
    return hole[first], time[first]


def _channels(log: LogContents) -> list[tuple[str, str, tuple[Array, Array]]]:
    found = []
    if log.truth_weight_on_bit is not None:
        weight = log.truth_weight_on_bit
        found.append(("Weight on bit", "weight on bit, kN", (weight.time, weight.value / 1e3)))
    if log.draw_works is not None:
        found.append(("Hook load", "hook load, kN", (log.draw_works.time, log.draw_works.effort / 1e3)))
    if log.top_drive is not None:
        found.append(("Surface torque", "surface torque, kN m", (log.top_drive.time, log.top_drive.effort / 1e3)))
    if log.standpipe_pressure is not None:
        pressure = log.standpipe_pressure
        found.append(("Standpipe pressure", "standpipe pressure, bar", (pressure.time, pressure.value / 1e5)))
    return found


def _tool_faces(log: LogContents, depth: Array, passed: Array) -> Chart | None:
    """Each MWD toolface where the bit was when it was measured."""
    if log.mwd_tool_face is None:
        return None
    mwd = log.mwd_tool_face
    inside = (mwd.time >= passed[0]) & (mwd.time <= passed[-1])
    if not inside.any():
        return None
    turned = 180.0 - (180.0 - np.degrees(mwd.position[inside])) % 360.0
    dots = Line("MWD", turned, np.interp(mwd.time[inside], passed, depth), "dots", RED)
    return Chart("Toolface", "MWD toolface, deg", (Panel("bit depth, m", (dots,), inverted=True),))


def _binned(time: Array, value: Array, edges: Array) -> Array:
    """(3, n): lowest, mean and highest of the finite values between consecutive times; NaN where there is none."""
    found = np.full((3, len(edges) - 1), np.nan)
    for k in range(len(edges) - 1):
        inside = value[(time >= edges[k]) & (time < edges[k + 1])]
        inside = inside[np.isfinite(inside)]
        if inside.size:
            found[:, k] = inside.min(), inside.mean(), inside.max()
    return found


def _chart(
    title: str, label: str, depth: Array, value: Array, low: Array | None = None, high: Array | None = None
) -> Chart:
    lines = [Line("mean", value, depth, colour=BLUE)]
    if low is not None and high is not None:
        lines += [Line("lowest and highest", low, depth, "dotted", RED), Line("", high, depth, "dotted", RED)]
    return Chart(title, label, (Panel("bit depth, m", tuple(lines), inverted=True),))
