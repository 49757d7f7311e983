"""The page and the picture of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import write_atomically
from slider_drilling.log.depth_charts import depth_charts
from slider_drilling.log.run_summary import NOT_SET, RunSummary, hold_sentence, summary_rows, target_at
from slider_drilling.log.series import Array, LogContents
from slider_drilling.pages import Chart, Headline, Line, Page, Panel, Section, Table
from slider_drilling.pages import write_page as write
from slider_drilling.pages.colours import AMBER, BLUE, GREEN, GREY, RED
from slider_drilling.pages.figures import wrap_degrees
from slider_drilling.pages.png import render_png
from slider_drilling.pages.titles import target_text, utc_time, well_name
from slider_drilling.rig import Rig
from slider_drilling.units import SI, Units


def log_panels(log: LogContents) -> tuple[Panel, ...]:
    """What the log holds over time. Raises InputError where that is nothing."""
    found = (_tool_face(log), _top_drive(log), _torque(log), _pressure(log), _hook_load(log), _weight(log), _depth(log))
    shown = tuple(panel for panel in found if panel.marks)
    if not shown:
        raise InputError(f"{log.source}: nothing to plot: no surface channel and no toolface")
    return shown


def _tool_face(log: LogContents) -> Panel:
    lines = []
    if log.truth_bit is not None:
        lines.append(Line("truth", log.truth_bit.time, wrap_degrees(np.degrees(log.truth_bit.position)), colour=GREY))
    if log.mwd_tool_face is not None:
        mwd = log.mwd_tool_face
        degrees = 180.0 - (180.0 - np.degrees(mwd.position)) % 360.0
        lines.append(Line("MWD, when measured", mwd.time, degrees, "dots", RED))
    if lines:
        time = np.array([min(line.x[0] for line in lines), max(line.x[-1] for line in lines)])
        if log.tool_face_target is not None:
            time = np.union1d(time, log.tool_face_target.time)
        lines.append(Line("target", time, wrap_degrees(np.degrees(target_at(log, time))), "steps", GREEN))
    return Panel("toolface, deg", tuple(lines))


def _top_drive(log: LogContents) -> Panel:
    lines = []
    if log.top_drive is not None:
        lines.append(Line("measured", log.top_drive.time, log.top_drive.position, colour=BLUE))
    if log.top_drive_command is not None:
        asked = log.top_drive_command
        lines.append(Line("asked for", asked.time, asked.position, "dashed", AMBER))
    return Panel("top drive, rad", tuple(lines))


def _torque(log: LogContents) -> Panel:
    lines = []
    if log.top_drive is not None and not np.isnan(log.top_drive.effort).all():
        lines.append(Line("measured", log.top_drive.time, log.top_drive.effort / 1e3, colour=BLUE))
    if log.truth_bit is not None:
        lines.append(Line("truth", log.truth_bit.time, log.truth_bit.effort / 1e3, colour=GREY))
    return Panel("torque at surface and bit, kN m" if len(lines) > 1 else "surface torque, kN m", tuple(lines))


def _one(title: str, name: str, time: Array | None, value: Array | None, colour: str) -> Panel:
    there = time is not None and value is not None and not np.isnan(value).all()
    return Panel(title, (Line(name, time, value, colour=colour),) if there else ())  # type: ignore[arg-type]


def _pressure(log: LogContents) -> Panel:
    series = log.standpipe_pressure
    time, value = (None, None) if series is None else (series.time, series.value / 1e5)
    return _one("standpipe pressure, bar", "measured", time, value, BLUE)


def _hook_load(log: LogContents) -> Panel:
    series = log.draw_works
    time, value = (None, None) if series is None else (series.time, series.effort / 1e3)
    return _one("hook load, kN", "measured", time, value, BLUE)


def _weight(log: LogContents) -> Panel:
    series = log.truth_weight_on_bit
    time, value = (None, None) if series is None else (series.time, series.value / 1e3)
    return _one("weight on bit, kN", "truth", time, value, GREY)


def _depth(log: LogContents) -> Panel:
    lines = []
    if log.truth_depth is not None:
        lines.append(Line("truth", log.truth_depth.time, log.truth_depth.position, colour=GREY))
    if log.bit_depth is not None:
        lines.append(Line("measured", log.bit_depth.time, log.bit_depth.position, colour=BLUE))
    return Panel("bit depth, m", tuple(lines), inverted=True)


def log_chart(log: LogContents) -> Chart:
    """The panels of a log as one figure. Raises InputError where it holds nothing to plot."""
    return Chart("Over time", "time, s", log_panels(log), wide=True)


def log_title(log: LogContents, units: Units = SI, rig: Rig | None = None) -> str:
    """Well, time and target; rig: the file that names the well, the log's own if None."""
    if rig is None and log.rig_text is not None:
        rig = log.rig()
    asked = () if log.tool_face_target is None else log.tool_face_target.position
    steps = [angle for k, angle in enumerate(asked) if k == 0 or abs(angle - asked[k - 1]) > 1e-6]
    parts = (well_name(rig, units), utc_time(log.start, log.metadata.get("start_time", "")), target_text(steps))
    return ", ".join(part for part in parts if part)


def run_page(log: LogContents, summary: RunSummary, more: tuple[tuple[str, str], ...] = (), units: Units = SI) -> Page:
    """The page of a run; `more`: rows after the summary's own. Raises InputError where there is nothing to plot."""
    figures: tuple[Chart, ...] = (log_chart(log),)
    sections = [
        Section("What happened", (Table(("", ""), (*summary_rows(summary, units), *more)),)),
        Section("", figures),
    ]
    known = summary.drilled is not None and not summary.drilled_nothing and summary.drilled.source != "block"
    if known and (by_depth := depth_charts(log)):
        sections.append(Section("By depth", by_depth))
    facts = [("log", Path(log.source).name)]
    facts += [(key.replace("_", " "), log.metadata[key]) for key in ("recorded_by", "version") if log.metadata.get(key)]
    notes = (*((log.metadata["notes"],) if log.metadata.get("notes") else ()), *log.notes)
    return Page("Run", log_title(log, units), tuple(sections), tuple(facts), _lead(summary, units), notes)


def _lead(summary: RunSummary, units: Units) -> Headline | None:
    found, hold = summary.drilled, summary.tool_face
    if summary.drilled_nothing:
        return Headline("Nothing was drilled: the bit made no new hole.", "bad")
    said = []
    if found is not None and found.source != "block":
        said.append(f"Drilled {units.format(found.length, 'm')} at {units.format(found.rate * 3600.0, 'm/h')}.")
    if hold is not None:
        last = hold.targets[-1]
        held = f"never set: {NOT_SET}" if last.set_after is None else f"set {hold_sentence(last)}"
        said.append(f"Toolface {held} ({hold.source}).")
    good = hold is None or all(one.set_after is not None and one.lost_after is None for one in hold.targets)
    return Headline(" ".join(said), "good" if good else "bad") if said else None


def write_run_page(
    path: Path, log: LogContents, summary: RunSummary, more: tuple[tuple[str, str], ...] = (), units: Units = SI
) -> None:
    """The page at `path`; it needs no network. `more`: rows after the summary's own. Raises InputError."""
    write(path, run_page(log, summary, more, units), units)


def write_run_picture(path: Path, log: LogContents, units: Units = SI) -> None:
    """The same panels as PNG. Raises InputError."""
    write_atomically(path, render_png((log_chart(log),), units, log_title(log, units)))
