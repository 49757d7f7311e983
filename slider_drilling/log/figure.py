"""Panels over time as a plotly figure, for a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from slider_drilling.errors import InputError

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

    from slider_drilling.log.run_page import Panel

_STYLES: dict[str, dict[str, Any]] = {
    "line": {"mode": "lines"},
    "dots": {"mode": "markers"},
    "dashed": {"mode": "lines", "line": {"dash": "dash"}},
}


def time_figure(panels: Sequence[Panel]) -> Figure:
    """One panel below the other over a common time axis. Raises InputError where plotly is not installed."""
    try:
        from plotly.graph_objects import Scatter
        from plotly.subplots import make_subplots
    except ImportError:
        raise InputError("plotly is not installed; install it with `pip install 'slider_drilling[analysis]'`") from None

    from slider_drilling.log.run_page import thin

    figure = make_subplots(rows=len(panels), cols=1, shared_xaxes=True, vertical_spacing=0.025)
    for row, panel in enumerate(panels, start=1):
        for line in panel.lines:
            time, value = thin(line.time, line.value)
            trace = Scatter(x=time, y=value, name=f"{panel.title}: {line.name}", **_STYLES[line.style])
            trace.update(line_color=line.colour, marker_color=line.colour, line_width=1.3, marker_size=6)
            figure.add_trace(trace, row=row, col=1)
        figure.update_yaxes(title_text=f"{panel.title}<br>{panel.unit}", row=row, col=1)
    figure.update_xaxes(title_text="time, s", row=len(panels), col=1)
    figure.update_layout(height=190 * len(panels) + 60, template="plotly_white", hovermode="x unified",
                         margin={"l": 80, "r": 20, "t": 20, "b": 40}, legend={"orientation": "h", "y": -0.06})
    return figure
