"""Figures for a notebook, by plotly."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

from slider_drilling.errors import InputError
from slider_drilling.pages.colours import LIGHT
from slider_drilling.pages.figures import Figure as Described
from slider_drilling.pages.plotly_js import plotly_spec
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


def plotly_figure(figure: Described, units: Units = SI) -> Figure:
    """A plotly Figure with its legend below. Raises InputError if plotly is not installed."""
    try:
        from plotly.graph_objects import Figure
    except ImportError:
        raise InputError("plotly is not installed; install it with `pip install 'slider_drilling[analysis]'`") from None
    drawn = plotly_spec(figure, units)
    text = json.dumps({"data": drawn["data"], "layout": drawn["layout"]})
    coloured = json.loads(re.sub(r'"@([a-z]+)([0-9a-f]{2})?"', lambda m: f'"{LIGHT[m[1]]}{m[2] or ""}"', text))
    shown = Figure(coloured["data"], coloured["layout"])
    return shown.update_layout(
        title=figure.title, height=drawn["height"] + 60.0, template="plotly_white", showlegend=bool(drawn["legend"]),
        legend={"orientation": "h", "y": -0.12, "yanchor": "top"}, margin={"l": 60, "r": 20, "t": 60, "b": 50},
    )  # fmt: skip
