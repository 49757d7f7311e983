"""What a log holds, as a table to look at before trusting it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from slider_drilling.log.series import Array, LogContents
from slider_drilling.messages.topics import TOPICS
from slider_drilling.units import SI, Units, format_number

# Of an SI unit: its value in the unit that tables start from, and that unit.
_SHOWN = {"N m": (1e-3, "kN m"), "N": (1e-3, "kN"), "Pa": (1e-5, "bar")}


@dataclass(frozen=True)
class LoggedQuantity:
    """One array of a log. first, last: s; lowest, highest: in the unit; longest_gap: s between samples."""

    topic: str
    quantity: str
    unit: str
    samples: int
    first: float
    last: float
    lowest: float
    highest: float
    longest_gap: float | None


def contents_table(log: LogContents, units: Units = SI) -> Table:
    """One line an array that the log holds: samples, time span, range, longest gap between samples."""
    table = Table("topic", "quantity", "samples", "time, s", "range", "unit", "longest gap, s", box=SIMPLE_HEAD)
    for one in logged_quantities(log):
        gap = "-" if one.longest_gap is None else f"{one.longest_gap:.2f}"
        factor, unit = _SHOWN.get(one.unit, (1.0, one.unit))
        low, high = (format_number(units.convert(factor * value, unit), 5) for value in (one.lowest, one.highest))
        table.add_row(one.topic, one.quantity, str(one.samples), f"{one.first:.1f} to {one.last:.1f}",
                      f"{low} to {high}", units.display_unit(unit), gap)
    return table


def logged_quantities(log: LogContents) -> list[LoggedQuantity]:
    """The arrays that the log holds; those without a value are left out."""
    return [
        _content(TOPICS[key].name, quantity.array, quantity.unit, series.time, values)
        for key, series in log.series().items()
        for quantity in TOPICS[key].quantities
        if not np.isnan(values := getattr(series, quantity.array)).all()
    ]


def _content(topic: str, quantity: str, unit: str, time: Array, values: Array) -> LoggedQuantity:
    there = ~np.isnan(values)
    gap = float(np.diff(time[there]).max()) if there.sum() > 1 else None
    return LoggedQuantity(topic, quantity, unit, int(there.sum()), float(time[there][0]), float(time[there][-1]),
                   float(values[there].min()), float(values[there].max()), gap)
