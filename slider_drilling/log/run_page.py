"""The picture of a run: one HTML page that stands alone, and the same as PNG."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.files import write_whole
from slider_drilling.log.run_summary import RunSummary, rows, target_at
from slider_drilling.log.series import Array, RigLog

POINTS = 6000  # a line of more is thinned to its extremes
PAGE = """\
<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{{ title }}</title>
<style>
 body { font: 15px/1.45 system-ui, sans-serif; max-width: 1180px; margin: 1.5rem auto; padding: 0 1rem; color: #1c2733 }
 h1 { font-size: 1.3rem } table { border-collapse: collapse; margin: .5rem 0 1rem }
 td { padding: .15rem 1.2rem .15rem 0; border-bottom: 1px solid #e3e8ee } td:first-child { color: #53606e }
 footer { color: #53606e; font-size: .85rem }
</style></head><body>
<h1>{{ title }}</h1>
<table>{% for name, value in rows %}<tr><td>{{ name }}</td><td>{{ value }}</td></tr>{% endfor %}</table>
{{ plot | safe }}
<footer>{{ origin }}{% for note in notes %}<br>{{ note }}{% endfor %}</footer>
</body></html>
"""


@dataclass(frozen=True)
class Line:
    """One line of a panel. style: `line`, `dots` or `dashed`."""

    name: str
    time: Array
    value: Array
    colour: str
    style: str = "line"


@dataclass(frozen=True)
class Panel:
    """One set of axes over time."""

    title: str
    unit: str
    lines: tuple[Line, ...]


def panels(log: RigLog) -> list[Panel]:
    """What the log holds, in field units. Raises InputError where that is nothing."""
    found = [_tool_face(log), _top_drive(log), _torque(log), _pressure(log), _hook_load(log), _weight(log)]
    shown = [panel for panel in found if panel.lines]
    if not shown:
        raise InputError(f"{log.source}: nothing to plot: no surface channel and no tool-face")
    return shown


def _tool_face(log: RigLog) -> Panel:
    lines = []
    if log.truth_bit is not None:
        lines.append(_wrapped(Line("truth", log.truth_bit.time, np.degrees(log.truth_bit.position), "#7b8794")))
    if log.mwd_tool_face is not None:
        mwd = log.mwd_tool_face
        lines.append(Line("MWD, when measured", mwd.time, np.degrees(mwd.position), "#d1495b", "dots"))
    if lines:
        time = np.array([min(line.time[0] for line in lines), max(line.time[-1] for line in lines)])
        if log.tool_face_target is not None:
            time = np.union1d(time, log.tool_face_target.time)
        lines.append(Line("target", time, np.degrees(target_at(log, time)), "#00798c", "dashed"))
    return Panel("Tool-face", "deg", tuple(lines))


def _wrapped(line: Line) -> Line:
    """Degrees folded into -180..180, the line broken where it passes the fold."""
    value = 180.0 - (180.0 - line.value) % 360.0
    value[1:][np.abs(np.diff(value)) > 180.0] = np.nan
    return Line(line.name, line.time, value, line.colour, line.style)


def _top_drive(log: RigLog) -> Panel:
    lines = []
    if log.top_drive is not None:
        lines.append(Line("measured", log.top_drive.time, log.top_drive.position, "#00798c"))
    if log.top_drive_command is not None:
        asked = log.top_drive_command
        lines.append(Line("asked for", asked.time, asked.position, "#edae49", "dashed"))
    return Panel("Top drive", "rad", tuple(lines))


def _torque(log: RigLog) -> Panel:
    lines = []
    if log.top_drive is not None:
        lines.append(Line("surface", log.top_drive.time, log.top_drive.effort / 1e3, "#00798c"))
    if log.truth_bit is not None:
        lines.append(Line("bit (truth)", log.truth_bit.time, log.truth_bit.effort / 1e3, "#7b8794"))
    return Panel("Torque", "kN m", tuple(lines))


def _pressure(log: RigLog) -> Panel:
    series = log.standpipe_pressure
    lines = () if series is None else (Line("standpipe", series.time, series.value / 1e5, "#00798c"),)
    return Panel("Standpipe pressure", "bar", lines)


def _hook_load(log: RigLog) -> Panel:
    series = log.draw_works
    lines = () if series is None else (Line("hook load", series.time, series.effort / 1e3, "#00798c"),)
    return Panel("Hook load", "kN", lines)


def _weight(log: RigLog) -> Panel:
    series = log.truth_weight_on_bit
    lines = () if series is None else (Line("weight on bit (truth)", series.time, series.value / 1e3, "#7b8794"),)
    return Panel("Weight on bit", "kN", lines)


def thin(time: Array, value: Array, points: int = POINTS) -> tuple[Array, Array]:
    """At most about `points` samples that keep each stretch's lowest and highest value."""
    if len(time) <= points:
        return time, value
    edges = np.linspace(0, len(time), points // 2 + 1).astype(int)
    kept = set()
    for first, last in itertools.pairwise(edges):
        stretch = value[first:last]
        if np.isnan(stretch).any():
            kept.add(first + int(np.isnan(stretch).argmax()))
        if not np.isnan(stretch).all():
            kept.update((first + int(np.nanargmin(stretch)), first + int(np.nanargmax(stretch))))
    index = np.array(sorted(kept))
    return time[index], value[index]


def write_page(path: Path, log: RigLog, summary: RunSummary, more: tuple[tuple[str, str], ...] = ()) -> None:
    """The page at `path`; it needs no network. `more`: rows after the summary's own. Raises InputError."""
    import jinja2
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    shown = panels(log)
    figure = make_subplots(rows=len(shown), cols=1, shared_xaxes=True, vertical_spacing=0.025)
    modes: dict[str, dict[str, Any]] = {"line": {"mode": "lines"}, "dots": {"mode": "markers"},
                                        "dashed": {"mode": "lines", "line": {"dash": "dash"}}}
    for row, panel in enumerate(shown, start=1):
        for line in panel.lines:
            time, value = thin(line.time, line.value)
            trace = go.Scatter(x=np.round(time, 4), y=value, name=f"{panel.title}: {line.name}", **modes[line.style])
            trace.update(line_color=line.colour, marker_color=line.colour, line_width=1.3, marker_size=6)
            figure.add_trace(trace, row=row, col=1)
        figure.update_yaxes(title_text=f"{panel.title}<br>{panel.unit}", row=row, col=1)
    figure.update_xaxes(title_text="time, s", row=len(shown), col=1)
    figure.update_layout(height=210 * len(shown) + 60, margin={"l": 80, "r": 20, "t": 20, "b": 50},
                         template="plotly_white", hovermode="x unified", legend={"orientation": "h", "y": -0.06})
    plot = figure.to_html(full_html=False, include_plotlyjs=True)
    template = jinja2.Environment(autoescape=True).from_string(PAGE)
    page = template.render(title=_title(log), rows=[*rows(summary), *more], plot=plot, origin=_origin(log),
                           notes=log.notes)
    write_whole(path, page.encode("utf-8"))


def write_picture(path: Path, log: RigLog) -> None:
    """The same panels as PNG. Raises InputError."""
    import io

    from matplotlib.figure import Figure

    shown = panels(log)
    figure = Figure(figsize=(11.0, 1.75 * len(shown) + 0.5), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(shown), 1, sharex=True))
    styles: dict[str, dict[str, Any]] = {
        "line": {"linewidth": 1.0},
        "dots": {"linestyle": "none", "marker": "o", "markersize": 3.5},
        "dashed": {"linewidth": 1.0, "linestyle": "--"},
    }
    for axis, panel in zip(axes, shown, strict=True):
        for line in panel.lines:
            axis.plot(*thin(line.time, line.value), color=line.colour, label=line.name, **styles[line.style])
        axis.set_ylabel(f"{panel.title}\n{panel.unit}")
        axis.grid(True, color="#e3e8ee", linewidth=0.6)
        axis.legend(loc="upper left", fontsize=8, ncols=3, framealpha=0.8)
    axes[-1].set_xlabel("time, s")
    axes[0].set_title(_title(log), loc="left", fontsize=11)
    held = io.BytesIO()
    figure.savefig(held, format="png", dpi=120)
    write_whole(path, held.getvalue())


def _title(log: RigLog) -> str:
    return f"Slide: {Path(log.source).name}"


def _origin(log: RigLog) -> str:
    made = [f"{key.replace('_', ' ')}: {value}" for key, value in log.metadata.items() if value]
    return "; ".join(made)
