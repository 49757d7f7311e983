"""The quantities that a log holds, with their ranges, as a table."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from slider_drilling.log.series import Array, LogContents
from slider_drilling.messages.topics import TOPICS, TopicQuantity
from slider_drilling.units import SI, Units, format_number

_DISPLAY_UNITS = {"N m": ("kN m", 1e3), "N": ("kN", 1e3), "Pa": ("bar", 1e5)}


@dataclass(frozen=True)
class LoggedQuantity:
    """One array of a log.

    Attributes:
        topic: Its topic.
        quantity: position, velocity, effort or value.
        unit: SI.
        samples: Number of values.
        first: Time of the first value, s.
        last: Time of the last value, s.
        lowest: In the unit.
        highest: In the unit.
        longest_gap: Between values, s; None for fewer than two.
    """

    topic: str
    quantity: str
    unit: str
    samples: int
    first: float
    last: float
    lowest: float
    highest: float
    longest_gap: float | None


def shown_unit(quantity: TopicQuantity) -> tuple[str, float]:
    """The metric unit that tables and plots start from, and its SI value; a toolface is in degrees everywhere."""
    if quantity.unit == "rad" and "tool_face" in quantity.column:
        return "deg", math.pi / 180.0
    return _DISPLAY_UNITS.get(quantity.unit, (quantity.unit, 1.0))


def contents_table(log: LogContents, units: Units = SI) -> Table:
    """One row for each array that the log holds, at most 80 characters wide."""
    table = Table("channel", "samples", "time, s", "range", "unit", "gap, s", box=SIMPLE, padding=(0, 1, 0, 0))
    for key, series in log.series().items():
        for quantity in TOPICS[key].quantities:
            values = getattr(series, quantity.array)
            if np.isnan(values).all():
                continue
            row = _content(TOPICS[key].name, quantity.array, quantity.unit, series.time, values)
            gap = "-" if row.longest_gap is None else f"{row.longest_gap:.2f}"
            unit, size = shown_unit(quantity)
            low, high = (format_number(units.convert(value / size, unit), 4) for value in (row.lowest, row.highest))
            table.add_row(quantity.column, str(row.samples), f"{row.first:.0f} to {row.last:.0f}", f"{low} to {high}",
                          units.display_unit(unit), gap)  # fmt: skip
    return table


def displayed(log: LogContents, key: str, array: str) -> tuple[str, str, Array, Array] | None:
    """One quantity of a log for a plot: label, display unit, time s, values; None where the log does not hold it.

    Args:
        log: The log.
        key: Of the topic in the registry.
        array: position, velocity, effort or value.
    """
    series = log.series().get(key)
    if series is None or np.isnan(getattr(series, array)).all():
        return None
    quantity = TOPICS[key].quantity(array)
    unit, size = shown_unit(quantity)
    return quantity.label, unit, series.time, getattr(series, array) / size


def logged_quantities(log: LogContents) -> list[LoggedQuantity]:
    """The arrays that the log holds; those without a value are left out."""
    return [
        _content(TOPICS[key].name, quantity.array, quantity.unit, series.time, values)
        for key, series in log.series().items()
        for quantity in TOPICS[key].quantities
        if not np.isnan(values := getattr(series, quantity.array)).all()
    ]


def _content(topic: str, quantity: str, unit: str, time: Array, values: Array) -> LoggedQuantity:
    given = ~np.isnan(values)
    gap = float(np.diff(time[given]).max()) if given.sum() > 1 else None
    return LoggedQuantity(
        topic, quantity, unit, int(given.sum()), float(time[given][0]), float(time[given][-1]),
        float(values[given].min()), float(values[given].max()), gap,
    )  # fmt: skip
