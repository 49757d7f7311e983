"""What something unknown looks like, in words: a disturbance without a law, by the curve that was solved for it."""

from __future__ import annotations

import numpy as np

from slider_drilling.diagnosis.effect_phrases import display_unit, format_quantity
from slider_drilling.gap.model import Array
from slider_drilling.units import format_number

# Share of a curve's variance that a straight line, or one step, must explain to be named as such.
_LIKE = 0.85


def describe_curve(words: str, x: Array, x_unit: str, y: Array, y_unit: str) -> str:
    """`words` with what the curve y (m,) over x (m,) does: rises or falls steadily, steps once, or has its extreme."""
    spread = float(np.ptp(y))
    if x.size < 2 or spread == 0.0:
        mean = float(np.mean(y))
        if y_unit == "-" and mean > 1.0:
            return f"{words}, by a factor of {format_number(1.0 + mean, 2)}"
        return f"{words}, by {_amount(mean, y_unit)}"
    slope, offset = np.polyfit(x, y, 1)
    total = float(np.sum((y - np.mean(y)) ** 2))
    if 1.0 - float(np.sum((y - slope * x - offset) ** 2)) / total > _LIKE:
        return f"{words}: {'rises' if slope > 0.0 else 'falls'} by {_rate(abs(float(slope)), x_unit, y_unit)}"
    at, left = _step(y)
    if 1.0 - left / total > _LIKE:
        before, after = float(np.mean(y[:at])), float(np.mean(y[at:]))
        size = f"{'up' if after > before else 'down'} by {_amount(abs(after - before), y_unit)}"
        return f"{words}: steps {size} between {_place(float(x[at - 1]), x_unit)} and {_place(float(x[at]), x_unit)}"
    extreme = int(np.argmax(np.abs(y - np.median(y))))
    way = "most" if y[extreme] > np.median(y) else "least"
    return f"{words}: {way}, {_amount(float(y[extreme]), y_unit)}, at {_place(float(x[extreme]), x_unit)}"


def _step(y: Array) -> tuple[int, float]:
    """Where one step explains most of y, and the sum of squares that it leaves."""
    left = {
        at: float(np.sum((y[:at] - np.mean(y[:at])) ** 2) + np.sum((y[at:] - np.mean(y[at:])) ** 2))
        for at in range(1, y.size)
    }
    best = min(left, key=lambda at: left[at])
    return best, left[best]


def _rate(slope: float, x_unit: str, y_unit: str) -> str:
    """A slope as a driller reads it: a minute, not a second; of its own unit, a share."""
    if x_unit == y_unit and x_unit != "-":
        return f"{format_number(100.0 * slope, 2)} % of itself"
    if x_unit == "s":
        return f"{_amount(60.0 * slope, y_unit)} a minute"
    read, factor = display_unit(x_unit)
    return f"{_amount(slope / factor, y_unit)} per {'unit' if read == '-' else read}"


def _amount(value: float, unit: str) -> str:
    return f"{format_number(100.0 * value, 2)} %" if unit == "-" else format_quantity(value, unit, 2)


def _place(value: float, unit: str) -> str:
    return format_number(value, 3) if unit == "-" else format_quantity(value, unit, 3)
