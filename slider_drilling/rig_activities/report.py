"""The activities of a log as tables, page, JSON and columns."""

from __future__ import annotations

import datetime
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.clock_time import has_date
from slider_drilling.columns import Columns
from slider_drilling.pages import Bars, Chart, Headline, Line, Page, Panel, Quantity, Section, Table
from slider_drilling.pages.colours import AMBER, BLUE, GREEN, GREY, INK, PURPLE, RED, SKY
from slider_drilling.pages.page import Cell
from slider_drilling.rig_activities.classify import (
    CIRCULATING,
    CONNECTION,
    KINDS,
    NOT_RECORDED,
    OFF_BOTTOM,
    ROCKING,
    ROTATING,
    SLIDING,
    TRIPPING,
)
from slider_drilling.rig_activities.split import Activity, DaySplit
from slider_drilling.units import Sentence, sentence

SCHEMA = "slider_drilling/activities/1"
COLOURS = {ROTATING: BLUE, SLIDING: GREEN, ROCKING: PURPLE, CONNECTION: GREY, TRIPPING: AMBER, CIRCULATING: SKY,
           OFF_BOTTOM: RED, NOT_RECORDED: INK}  # fmt: skip
ACTIVITY_HEADER = ("start", "time, min", "activity", "bit from, m", "bit to, m", "drilled, m", "rate, m/h")
TOTAL_HEADER = ("activity", "stretches", "time, h", "share, %", "drilled, m", "rate, m/h")


def clock(day: DaySplit, seconds: float) -> str:
    """Time of day in UTC, or hours since the log's start where its clock has no date: "14:05:10"."""
    if has_date(day.start):
        return f"{datetime.datetime.fromtimestamp(day.start + seconds, datetime.timezone.utc):%H:%M:%S}"
    whole = round(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"


def slide_table(day: DaySplit) -> Table:
    """One row a slide; columns that no slide has a figure for are left out."""
    slides = day.slides
    columns: list[tuple[str, list[Cell]]] = [
        ("#", list(range(1, len(slides) + 1))),
        ("start", [clock(day, slide.start) for slide in slides]),
        ("time, min", [(slide.end - slide.start) / 60.0 for slide in slides]),
        ("from, m", [slide.depth_from for slide in slides]),
        ("length, m", [slide.length for slide in slides]),
        ("rate, m/h", [slide.rate * 3600.0 for slide in slides]),
        ("toolface, deg", [round(math.degrees(slide.tool_face)) if math.isfinite(slide.tool_face) else None
                           for slide in slides]),
        ("wraps, turns", [slide.wraps / (2.0 * math.pi) if slide.is_rocking else None for slide in slides]),
        ("torque right, kN m", [slide.torque_right / 1e3 for slide in slides]),
        ("torque left, kN m", [slide.torque_left / 1e3 for slide in slides]),
        ("diff. pressure, bar", [slide.differential_pressure / 1e5 for slide in slides]),
    ]  # fmt: skip
    held = [(head, cells) for head, cells in columns if not all(cell is None or cell != cell for cell in cells)]
    return Table(tuple(head for head, _ in held), tuple(zip(*(cells for _, cells in held), strict=True)))


def total_table(day: DaySplit) -> Table:
    """Time and hole of each kind of activity."""
    whole = sum(activity.duration for activity in day.activities) or 1.0
    rows = []
    for kind, (seconds, drilled) in day.totals().items():
        drills = kind in (ROTATING, SLIDING, ROCKING)
        count = sum(activity.kind == kind for activity in day.activities)
        rows.append((kind, count, seconds / 3600.0, 100.0 * seconds / whole, drilled if drills else None,
                     drilled / seconds * 3600.0 if drills and seconds else None))  # fmt: skip
    return Table(TOTAL_HEADER, tuple(rows))


def activity_table(day: DaySplit) -> Table:
    """One row an activity."""
    return Table(ACTIVITY_HEADER, tuple(_activity_row(day, activity) for activity in day.activities))


def _activity_row(day: DaySplit, part: Activity) -> tuple[Cell, ...]:
    drills = part.kind in (ROTATING, SLIDING, ROCKING)
    return (clock(day, part.start), part.duration / 60.0, part.kind, part.depth_from, part.depth_to,
            part.drilled if drills else None, part.rate * 3600.0 if drills else None)  # fmt: skip


def summary(day: DaySplit) -> Sentence:
    """The day in one sentence."""
    totals = day.totals()
    sums = [[sum(totals.get(kind, (0.0, 0.0))[k] for kind in kinds) for k in (0, 1)]
            for kinds in ((ROTATING,), (SLIDING, ROCKING))]  # fmt: skip
    whole = _duration(sum(seconds for seconds, _ in totals.values()))
    slides = f"{len(day.slides)} slide{'' if len(day.slides) == 1 else 's'}"
    parts: list[Quantity | str] = [f"In {whole} the rig drilled ", Quantity(sums[0][1] + sums[1][1], "m")]
    for (seconds, drilled), how in zip(sums, ("rotating", "without rotation"), strict=True):
        if seconds:
            joint = ": " if len(parts) == 2 else " and "
            parts += [joint, Quantity(drilled, "m"), f" {how} in {_duration(seconds)}"]
    return sentence(*parts, f"; {slides}.")


def _duration(seconds: float) -> str:
    return f"{seconds / 3600.0:.1f} h" if seconds >= 3600.0 else f"{seconds / 60.0:.0f} min"


def day_chart(day: DaySplit) -> Chart:
    """The day as a strip, and what was measured below it."""
    hours = day.channels.time / 3600.0
    strips = tuple(_strip(day, kind) for kind in KINDS if kind in day.totals())
    measured = (
        ("bit depth, m", day.depth, True), ("hook load, kN", day.channels.hook_load / 1e3, False),
        ("top drive, rpm", day.channels.speed * 30.0 / math.pi, False),
        ("surface torque, kN m", day.channels.torque / 1e3, False),
        ("standpipe pressure, bar", day.channels.pressure / 1e5, False),
    )  # fmt: skip
    panels = tuple(Panel(label, (Line("", hours, value, colour=INK),), inverted=inverted, height=0.8)
                   for label, value, inverted in measured if np.isfinite(value).any())  # fmt: skip
    return Chart("The day", "time since the start, h", (Panel("activity", strips, height=0.35), *panels),
                 f"Bit depth is from {day.depth_source}.", x_limits=(float(hours[0]), float(hours[-1])),
                 wide=True)  # fmt: skip


def _strip(day: DaySplit, kind: str) -> Bars:
    parts = [activity for activity in day.activities if activity.kind == kind]
    start, end = (np.array([getattr(part, name) for part in parts]) / 3600.0 for name in ("start", "end"))
    return Bars(kind, ("",) * len(parts), end - start, (COLOURS[kind],), base=start, horizontal=True)


def activities_page(day: DaySplit) -> Page:
    """The page of a day."""
    slides: tuple[Any, ...] = (slide_table(day), _SLIDE_NOTE) if day.slides else ("No slide was found.",)
    moment = f"{datetime.datetime.fromtimestamp(day.start, datetime.timezone.utc):%-d %b %Y, %H:%M} UTC"
    return Page(
        "Activities", moment if has_date(day.start) else Path(day.source).name,
        (
            Section("", (day_chart(day),)),
            Section("Slides", slides),
            Section("Time", (total_table(day),)),
            Section("Every activity", (activity_table(day),), collapsed=True),
        ),
        (("log", Path(day.source).name),), Headline(summary(day)), day.notes,
    )  # fmt: skip


_SLIDE_NOTE = (
    "A slide ends where the string is picked up or rotated, and where the drive turns by more than 60 deg to set "
    "another toolface. Wraps are half a stroke of rocking. Torque is that at the ends of the strokes; the highest and "
    "lowest without rocking. Differential pressure is the mean above the pressure off bottom at the same flow."
)


def to_json(day: DaySplit) -> dict[str, Any]:
    """The split as JSON: SI units and rad, s since the log's start; figures that are unknown are null."""
    return {
        "schema": SCHEMA, "log": day.source, "start": day.start, "depth_from": day.depth_source,
        "totals": {kind: {"time_s": seconds, "drilled_m": drilled}
                   for kind, (seconds, drilled) in day.totals().items()},
        "slides": [{"number": index, **asdict(slide), "length": slide.length}
                   for index, slide in enumerate(day.slides, 1)],
        "activities": [asdict(activity) for activity in day.activities], "notes": list(day.notes),
    }  # fmt: skip


_ACTIVITY_UNITS = {"start": "s", "end": "s", "depth_from": "m", "depth_to": "m", "drilled": "m", "rate": "m/s"}
_SLIDE_UNITS = {"start": "s", "end": "s", "depth_from": "m", "depth_to": "m", "rate": "m/s", "tool_face": "rad",
                "wraps": "rad", "period": "s", "torque_right": "N m", "torque_left": "N m",
                "differential_pressure": "Pa", "hook_load": "N"}  # fmt: skip


def activity_columns(day: DaySplit) -> Columns:
    """One row an activity."""
    names = ("kind", *_ACTIVITY_UNITS)
    values = {name: np.array([getattr(part, name) for part in day.activities]) for name in names}
    return Columns({"start": values.pop("start"), **values}, _ACTIVITY_UNITS)


def slide_columns(day: DaySplit) -> Columns:
    """One row a slide."""
    names = ("is_rocking", *_SLIDE_UNITS)
    values = {name: np.array([getattr(slide, name) for slide in day.slides]) for name in names}
    return Columns({"start": values.pop("start"), **values}, _SLIDE_UNITS)
