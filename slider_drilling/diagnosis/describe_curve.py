"""A residual's shape in words: what a free-form curve does over its axis, and the labels of that axis."""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.model import Array
from slider_drilling.units import Quantity, Sentence, Text, display_unit, displayed, format_number, sentence

# Share of a curve's variance that a straight line, or one step, must explain to be named.
_MIN_EXPLAINED = 0.85
# Words between what is disturbed and what it is a function of, as in "friction over depth".
_JOINTS = (" over ", " by an amount that follows ", " by an amount that drifts with ")


def describe_curve(disturbance: str, x: Array, x_unit: str, y: Array, y_unit: str) -> Sentence:
    """Say what a curve does: it rises or falls steadily, steps once, or has an extreme.

    Args:
        disturbance: What it is a curve of: "friction over depth".
        x: (m,) in `x_unit`.
        x_unit: SI unit, "-" for none.
        y: (m,) in `y_unit`.
        y_unit: SI unit; "-" is a share.
    """
    if x.size < 2 or float(np.ptp(y)) == 0.0:
        mean = float(np.mean(y))
        if y_unit == "-" and mean > 1.0:
            return sentence(f"{disturbance}, by a factor of {format_number(1.0 + mean, 2)}")
        return sentence(f"{disturbance}, by ", _amount(mean, y_unit))
    slope, offset = np.polyfit(x, y, 1)
    total = float(np.sum((y - np.mean(y)) ** 2))
    if 1.0 - float(np.sum((y - slope * x - offset) ** 2)) / total > _MIN_EXPLAINED:
        rises = "rises" if slope > 0.0 else "falls"
        return sentence(f"{disturbance}: {rises} by ", _rate(abs(float(slope)), x_unit, y_unit))
    at, left = _best_step(y)
    if 1.0 - left / total > _MIN_EXPLAINED:
        before, after = float(np.mean(y[:at])), float(np.mean(y[at:]))
        return sentence(
            f"{disturbance}: steps {'up' if after > before else 'down'} by ", _amount(abs(after - before), y_unit),
            " between ", _position(float(x[at - 1]), x_unit), " and ", _position(float(x[at]), x_unit),
        )  # fmt: skip
    extreme = int(np.argmax(np.abs(y - np.median(y))))
    most = "largest" if y[extreme] > np.median(y) else "smallest"
    return sentence(
        f"{disturbance}: {most}, ", _amount(float(y[extreme]), y_unit), ", at ", _position(float(x[extreme]), x_unit)
    )


def axis_labels(disturbance: str, x_unit: str, y_unit: str) -> tuple[str, str]:
    """Labels of the axes of such a curve. A share is of what the model has there."""
    name, x = disturbance, "whole log"
    for joint in _JOINTS:
        before, found, after = disturbance.partition(joint)
        if found:
            name, x = before, after
            break
    if y_unit == "-":
        y = f"{name}, share" if name.endswith(" off") else f"change of {name}, share"
    else:
        y = f"{name}, {y_unit}"
    return f"{x}, {x_unit}", y


def _best_step(y: Array) -> tuple[int, float]:
    """Index at which one step explains most of y, and the sum of squares that it leaves."""
    left = {
        at: float(np.sum((y[:at] - np.mean(y[:at])) ** 2) + np.sum((y[at:] - np.mean(y[at:])) ** 2))
        for at in range(1, y.size)
    }
    best = min(left, key=lambda at: left[at])
    return best, left[best]


def _rate(slope: float, x_unit: str, y_unit: str) -> Text:
    """A slope as a driller reads it: per minute, not per second; of a channel over itself, in per cent."""
    if x_unit == y_unit and x_unit != "-":
        return f"{format_number(100.0 * slope, 2)} % of its value"
    if x_unit == "s":
        return sentence(_amount(60.0 * slope, y_unit), " per minute")
    shown, factor = display_unit(x_unit)
    return sentence(_amount(slope / factor, y_unit), f" per {'unit' if shown == '-' else shown}")


def _amount(value: float, unit: str) -> str | Quantity:
    return f"{format_number(100.0 * value, 2)} %" if unit == "-" else displayed(value, unit, 2)


def _position(value: float, unit: str) -> str | Quantity:
    return format_number(value) if unit == "-" else displayed(value, unit)
