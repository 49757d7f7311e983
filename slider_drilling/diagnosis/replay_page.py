"""A replay as a table and as a page: every channel of the log with the plant's own over it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from slider_drilling.diagnosis.replay import Comparison, Replay
from slider_drilling.gap.model import Array
from slider_drilling.log import RigLog
from slider_drilling.log.run_page import log_title
from slider_drilling.pages import Chart, Line, Page, Panel, Section, Table
from slider_drilling.pages.colours import BLUE, INK, RED
from slider_drilling.pages.figures import wrap_degrees
from slider_drilling.units import Units, format_number

# Of a channel's SI unit: its value in the unit that pages start from, and that unit.
SHOWN = {"N m": (1e-3, "kN m"), "N": (1e-3, "kN"), "Pa": (1e-5, "bar"), "rad": (180.0 / math.pi, "deg")}
HEADER = ("channel", "samples", "RMS difference", "over noise")


def table_rows(run: Replay, units: Units) -> list[tuple[str, str, str, str]]:
    """One row of `HEADER` a channel."""
    rows = []
    for name, one in run.channels.items():
        factor, unit = SHOWN[one.channel.unit]
        ratio = one.rms_over_noise
        rows.append((name.replace("_", " "), str(len(one.residual)), units.format(one.rms * factor, unit),
                     "-" if ratio is None else format_number(ratio)))  # fmt: skip
    return rows


def replay_page(log: RigLog, run: Replay, units: Units, notes: Iterable[str] = ()) -> Page:
    """Measured, simulated and their difference for every channel, and the numbers above."""
    panels = tuple(panel for name, one in run.channels.items() for panel in _panels(name, one))
    worst = Table(HEADER, tuple(table_rows(run, units)))
    sections = (
        Section("How far apart", ("Root mean square of measured minus simulated, in the channel's unit and in units of "
                                  "the noise that the rig file declares for its sensor.", worst)),
        Section("", (Chart("Measured and simulated", "time, s", panels, wide=True),)),
    )  # fmt: skip
    facts = (("log", Path(log.source).name),)
    return Page("Replay", log_title(log, units), sections, facts, notes=tuple(notes))


def _panels(name: str, one: Comparison) -> tuple[Panel, Panel]:
    factor, unit = SHOWN[one.channel.unit]
    said, time = name.replace("_", " "), one.channel.time
    sparse = one.channel.period is not None
    measured, simulated = factor * one.channel.measured, factor * one.simulated
    if sparse:
        measured, simulated = 180.0 - (180.0 - measured) % 360.0, 180.0 - (180.0 - simulated) % 360.0
    over = (
        Line("measured", time, measured, "dots" if sparse else "line", INK),
        Line("simulated", time, _unbroken(simulated, sparse), "line", BLUE),
    )
    difference = Line("measured less simulated", time, factor * one.residual, "dots" if sparse else "line", RED)
    return (
        Panel(f"{said}, {unit}", over),
        Panel(f"{said}: measured less simulated, {unit}", (difference,), reference_line=(0.0, ""), height=0.7),
    )


def _unbroken(degrees: Array, wrapped: bool) -> Array:
    return wrap_degrees(np.asarray(degrees)) if wrapped else degrees
