"""Plotly figures of what is not a log over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from slider_drilling.errors import InputError

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")


def figure(x_label: str, y_label: str) -> Figure:
    """Empty axes. Raises InputError where plotly is not installed."""
    try:
        from plotly.graph_objects import Figure
    except ImportError:
        raise InputError("plotly is not installed; install it with `pip install 'slider_drilling[analysis]'`") from None
    empty = Figure()
    empty.update_layout(template="plotly_white", xaxis_title=x_label, yaxis_title=y_label, hovermode="closest",
                        colorway=COLOURS, height=420, margin={"l": 70, "r": 20, "t": 30, "b": 50})
    return empty


def lines(named: Sequence[tuple[str, np.ndarray, np.ndarray]], x_label: str, y_label: str) -> Figure:
    """One line for each (name, x, y)."""
    shown = figure(x_label, y_label)
    for name, x, y in named:
        shown.add_scatter(x=x, y=y, name=name, mode="lines", line_width=1.3)
    return shown


def bars(names: Sequence[str], values: Sequence[float], intervals: Sequence[tuple[float, float]], label: str) -> Figure:
    """A horizontal bar for each name, the first on top, with its interval."""
    shown = figure(label, "")
    less = [max(value - low, 0.0) for value, (low, _) in zip(values, intervals, strict=True)]
    more = [max(high - value, 0.0) for value, (_, high) in zip(values, intervals, strict=True)]
    shown.add_bar(x=list(values), y=list(names), orientation="h",
                  error_x={"type": "data", "symmetric": False, "array": more, "arrayminus": less})
    shown.update_yaxes(autorange="reversed")
    return shown
