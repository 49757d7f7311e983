"""What a log holds, as a table to look at before trusting it."""

from __future__ import annotations

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from slider_drilling.log.series import Array, JointSeries, RigLog
from slider_drilling.messages.topics import TOPICS

# Units of position, velocity and effort, or of the value.
UNITS = {
    "top_drive": ("rad", "rad/s", "N m"),
    "top_drive_command": ("rad", "rad/s", "N m"),
    "draw_works": ("m", "m/s", "N"),
    "draw_works_command": ("m", "m/s", "N"),
    "standpipe_pressure": ("Pa",),
    "mud_pump": ("rad", "rad/s", "N m"),
    "mwd_tool_face": ("rad", "rad/s", "N m"),
    "tool_face_target": ("rad", "rad/s", "N m"),
    "bit_depth": ("m", "m/s", "N"),
    "truth_bit": ("rad", "rad/s", "N m"),
    "truth_weight_on_bit": ("N",),
    "truth_depth": ("m", "m/s", "N"),
}


def summary_table(log: RigLog) -> Table:
    """One line an array that the log holds: samples, time span, range, longest gap between samples."""
    table = Table(box=SIMPLE_HEAD)
    for heading in ("topic", "quantity", "samples", "time, s", "range", "unit", "longest gap, s"):
        table.add_column(heading, no_wrap=True)
    for key, topic in TOPICS.items():
        series = getattr(log, key)
        if series is None:
            continue
        if isinstance(series, JointSeries):
            arrays = {"position": series.position, "velocity": series.velocity, "effort": series.effort}
        else:
            arrays = {"value": series.value}
        for (quantity, values), unit in zip(arrays.items(), UNITS[key], strict=True):
            if not np.isnan(values).all():
                table.add_row(topic.name, quantity, *_figures(series.time, values, unit))
    return table


def _figures(time: Array, values: Array, unit: str) -> tuple[str, ...]:
    there = ~np.isnan(values)
    gap = f"{np.diff(time[there]).max():.2f}" if there.sum() > 1 else "-"
    low, high = values[there].min(), values[there].max()
    span = f"{time[there][0]:.1f} to {time[there][-1]:.1f}"
    return (f"{there.sum()}", span, f"{low:.5g} to {high:.5g}", unit, gap)
