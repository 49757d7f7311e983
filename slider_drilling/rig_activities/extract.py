"""Writes stretches of a log as logs of their own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from slider_drilling.log import RigLog, save_log
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.rig_activities.classify import KINDS, NOT_RECORDED
from slider_drilling.rig_activities.split import DaySplit

SLIDE = "slide"
EXTRACTED = (SLIDE, *(kind.replace(" ", "_") for kind in KINDS if kind != NOT_RECORDED))
"""What can be extracted: slides, or the stretches of one activity."""


def windows(day: DaySplit, what: str) -> list[tuple[float, float]]:
    """Start and end of each slide, or of each stretch of an activity, s.

    Args:
        day: The split log.
        what: One of `EXTRACTED`.
    """
    if what == SLIDE:
        return [(slide.start, slide.end) for slide in day.slides]
    return [(part.start, part.end) for part in day.activities if part.kind == what.replace("_", " ")]


def extracted_files(day: DaySplit, source: Path, what: Sequence[str], folder: Path) -> dict[Path, tuple[float, float]]:
    """The file of each stretch, `DAY.slide_01.mcap` and so on, with its start and end, s."""
    return {
        folder / f"{source.stem}.{name}_{index:02d}.mcap": window
        for name in dict.fromkeys(what)
        for index, window in enumerate(windows(day, name), 1)
    }


def write_extracted(log: RigLog, files: dict[Path, tuple[float, float]]) -> None:
    """Write each stretch with the log's rig file. Raises InputError where a file cannot be written."""
    for path, (start, end) in files.items():
        notes = f"{start:.0f} to {end:.0f} s of {log.source}"
        save_log(cut_time_window(log, start, end), path, "slider-drilling activities", notes)
