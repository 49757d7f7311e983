"""A log in memory with its ways out: data frame, CSV, Parquet and figure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from slider_drilling.columns import TableExport
from slider_drilling.log.series import LogContents

if TYPE_CHECKING:
    import plotly


@dataclass(frozen=True, repr=False)
class RigLog(LogContents, TableExport):
    """What one log holds; see `LogContents` for its fields.

    `to_frame`, `to_csv` and `to_parquet` give every quantity against time, NaN where it has no sample.
    """

    def plot(self) -> plotly.graph_objects.Figure:
        """Toolface, top drive, torque, pressure, hook load and weight on bit against time, in field units."""
        from slider_drilling.log.run_page import log_chart
        from slider_drilling.pages.notebook import plotly_figure

        return plotly_figure(log_chart(self))
