"""The page and the picture of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import write_atomically
from slider_drilling.log.contents import displayed
from slider_drilling.log.depth_charts import depth_charts
from slider_drilling.log.run_summary import NOT_SET, RunSummary, hold_sentence, summary_rows, target_at
from slider_drilling.log.series import LogContents
from slider_drilling.pages import Chart, Headline, Line, Page, Panel, Section, Table
from slider_drilling.pages import write_page as write
from slider_drilling.pages.colours import AMBER, BLUE, GREEN, GREY, RED
from slider_drilling.pages.figures import wrapped_curve
from slider_drilling.pages.png import render_png
from slider_drilling.pages.titles import target_text, utc_time, well_name
from slider_drilling.plain_names import plain_name
from slider_drilling.rig import Rig
from slider_drilling.units import SI, Text, Units, sentence


def log_panels(log: LogContents) -> tuple[Panel, ...]:
    """Panels over time of what the log holds. Raises InputError where it holds none of them."""
    panels = (
        _tool_face(log),
        _top_drive(log),
        _torque(log),
        _single(log, "standpipe_pressure", "value", "measured", BLUE),
        _single(log, "draw_works", "effort", "measured", BLUE),
        _single(log, "truth_weight_on_bit", "value", "truth", GREY),
        _depth(log),
    )
    filled = tuple(panel for panel in panels if panel.marks)
    if not filled:
        raise InputError(f"{log.source}: nothing to plot: no surface topic and no toolface")
    return filled


def _tool_face(log: LogContents) -> Panel:
    lines = []
    if log.truth_bit is not None:
        lines.append(Line("truth", log.truth_bit.time, wrapped_curve(np.degrees(log.truth_bit.position)), colour=GREY))
    if log.mwd_tool_face is not None:
        mwd = log.mwd_tool_face
        degrees = 180.0 - (180.0 - np.degrees(mwd.position)) % 360.0
        lines.append(Line("MWD, when measured", mwd.time, degrees, "dots", RED))
    if lines:
        time = np.array([min(line.x[0] for line in lines), max(line.x[-1] for line in lines)])
        if log.tool_face_target is not None:
            time = np.union1d(time, log.tool_face_target.time)
        lines.append(Line("target", time, wrapped_curve(np.degrees(target_at(log, time))), "steps", GREEN))
    return Panel("toolface, deg", tuple(lines))


def _top_drive(log: LogContents) -> Panel:
    lines = []
    if log.top_drive is not None:
        lines.append(Line("measured", log.top_drive.time, log.top_drive.position, colour=BLUE))
    if log.top_drive_command is not None:
        command = log.top_drive_command
        lines.append(Line("setpoint", command.time, command.position, "dashed", AMBER))
    return Panel("top drive, rad", tuple(lines))


def _torque(log: LogContents) -> Panel:
    lines = []
    if log.top_drive is not None and not np.isnan(log.top_drive.effort).all():
        lines.append(Line("measured", log.top_drive.time, log.top_drive.effort / 1e3, colour=BLUE))
    if log.truth_bit is not None:
        lines.append(Line("truth", log.truth_bit.time, log.truth_bit.effort / 1e3, colour=GREY))
    return Panel("torque at surface and bit, kN m" if len(lines) > 1 else "surface torque, kN m", tuple(lines))


def _single(log: LogContents, key: str, array: str, name: str, colour: str) -> Panel:
    """A panel of one quantity; empty where the log does not hold it."""
    plotted = displayed(log, key, array)
    if plotted is None:
        return Panel("", ())
    label, unit, time, values = plotted
    return Panel(f"{label}, {unit}", (Line(name, time, values, colour=colour),))


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


def log_title(log: LogContents, rig: Rig | None = None) -> Text:
    """Well, time and target of a log.

    Args:
        log: The log.
        rig: The rig file that names the well; the log's own if not given.
    """
    if rig is None and log.rig_text is not None:
        rig = log.rig()
    targets = () if log.tool_face_target is None else log.tool_face_target.position
    steps = [angle for k, angle in enumerate(targets) if k == 0 or abs(angle - targets[k - 1]) > 1e-6]
    parts = (utc_time(log.start, log.metadata.get("start_time", "")), target_text(steps))
    return sentence(well_name(rig), *(f", {part}" for part in parts if part))


def run_page(log: LogContents, summary: RunSummary, more: tuple[tuple[str, str], ...] = (), units: Units = SI) -> Page:
    """The page of a run.

    Args:
        log: The log.
        summary: Its figures.
        more: Rows after those of the summary.
        units: That the page is written in.

    Raises:
        InputError: The log holds nothing to plot.
    """
    sections = [
        Section("What happened", (Table(("", ""), (*summary_rows(summary, units), *more)),)),
        Section("", (log_chart(log),)),
    ]
    has_depth = summary.drilled is not None and not summary.drilled_nothing and summary.drilled.source != "block"
    if has_depth and (by_depth := depth_charts(log)):
        sections.append(Section("By depth", by_depth))
    facts = [("log", Path(log.source).name)]
    facts += [(plain_name(key), log.metadata[key]) for key in ("recorded_by", "version") if log.metadata.get(key)]
    notes = (*((log.metadata["notes"],) if log.metadata.get("notes") else ()), *log.notes)
    return Page("Run", log_title(log), tuple(sections), tuple(facts), _headline(summary, units), notes)


def _headline(summary: RunSummary, units: Units) -> Headline | None:
    drilled, hold = summary.drilled, summary.tool_face
    if summary.drilled_nothing:
        return Headline("Nothing was drilled: the bit made no new hole.", "bad")
    sentences = []
    if drilled is not None and drilled.source != "block":
        rate = units.format(drilled.rate * 3600.0, "m/h")
        sentences.append(f"Drilled {units.format(drilled.length, 'm')} at {rate}.")
    if hold is not None:
        last = hold.targets[-1]
        held = f"never set: {NOT_SET}" if last.set_after is None else f"set {hold_sentence(last)}"
        sentences.append(f"Toolface {held} ({hold.source}).")
    good = hold is None or all(part.set_after is not None and part.lost_after is None for part in hold.targets)
    return Headline(" ".join(sentences), "good" if good else "bad") if sentences else None


def write_run_page(
    path: Path, log: LogContents, summary: RunSummary, more: tuple[tuple[str, str], ...] = (), units: Units = SI
) -> None:
    """Write the page, which needs no network; for the arguments see `run_page`. Raises InputError."""
    write(path, run_page(log, summary, more, units), units)


def write_run_picture(path: Path, log: LogContents, units: Units = SI) -> None:
    """Write the panels over time as PNG. Raises InputError."""
    write_atomically(path, render_png((log_chart(log),), units, log_title(log)))
