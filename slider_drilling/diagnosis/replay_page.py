"""A replay as a table and as a page: measured and simulated channels."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from slider_drilling.angles import wrap_degrees
from slider_drilling.diagnosis.replay import ChannelComparison, Replay
from slider_drilling.log import RigLog
from slider_drilling.log.run_page import log_title
from slider_drilling.pages import Chart, Line, Page, Panel, Section, Table
from slider_drilling.pages.colours import BLUE, INK, RED
from slider_drilling.pages.figures import Style, wrapped_curve
from slider_drilling.plain_names import plain_name
from slider_drilling.units import Text, Units, display_unit, displayed, format_number, sentence

HEADER = ("channel", "samples", "RMS difference", "relative to noise")


def table_rows(run: Replay, units: Units) -> list[tuple[str, str, str, str]]:
    """One row per channel, below `HEADER`."""
    rows = []
    for name, comparison in run.channels.items():
        rms = units.convert_text(sentence(displayed(comparison.rms, comparison.channel.unit)))
        ratio = comparison.rms_over_noise
        relative = "-" if ratio is None else format_number(ratio)
        rows.append((plain_name(name), str(len(comparison.residual)), rms, relative))
    return rows


def replay_page(log: RigLog, run: Replay, units: Units, notes: Iterable[Text] = ()) -> Page:
    """The page of a replay: RMS differences, then measured and simulated over time."""
    about = "RMS of measured minus simulated, in the channel's unit and relative to the rig file's noise."
    panels = tuple(panel for name, comparison in run.channels.items() for panel in _panels(name, comparison))
    sections = (
        Section("How large the difference is", (about, Table(HEADER, tuple(table_rows(run, units))))),
        Section("", (Chart("Measured and simulated", "time, s", panels, wide=True),)),
    )
    facts = (("log", Path(log.source).name),)
    return Page("Replay", log_title(log), sections, facts, notes=tuple(notes))


def _panels(name: str, comparison: ChannelComparison) -> tuple[Panel, Panel]:
    """Measured and simulated, and below their difference."""
    channel = comparison.channel
    unit, factor = display_unit(channel.unit)
    wrapped = channel.period is not None
    measured, simulated = factor * channel.measured, factor * comparison.simulated
    if wrapped:
        # Into (-180, 180] deg, with a gap in the line where it wraps.
        measured, simulated = wrap_degrees(measured), wrapped_curve(simulated)
    style: Style = "dots" if wrapped else "line"
    both = (
        Line("measured", channel.time, measured, style, INK),
        Line("simulated", channel.time, simulated, "line", BLUE),
    )
    difference = Line("measured minus simulated", channel.time, factor * comparison.residual, style, RED)
    label = plain_name(name)
    return (
        Panel(f"{label}, {unit}", both),
        Panel(f"{label}: measured minus simulated, {unit}", (difference,), reference_line=(0.0, ""), height=0.7),
    )
