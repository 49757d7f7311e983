"""Plotly figures of results other than logs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from slider_drilling.pages.figures import Bars, Chart, Line, Panel
from slider_drilling.pages.notebook import plotly_figure

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


def lines(curves: Sequence[tuple[str, np.ndarray, np.ndarray]], x_label: str, y_label: str) -> Figure:
    """One line for each curve (name, x, y). Raises InputError if plotly is not installed."""
    marks = tuple(Line(name, x, y) for name, x, y in curves)
    return plotly_figure(Chart("", x_label, (Panel(y_label, marks),)))


def bars(names: Sequence[str], values: Sequence[float], intervals: Sequence[tuple[float, float]], label: str) -> Figure:
    """A horizontal bar with an interval (low, high) for each name, the first on top."""
    low, high = np.array(intervals, dtype=float).reshape(-1, 2).T
    marks = Bars("", tuple(names), np.asarray(values, dtype=float), low=low, high=high, horizontal=True)
    return plotly_figure(Chart("", label, (Panel("effect", (marks,)),)))
