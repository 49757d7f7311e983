"""A log in memory with its ways out: data frame, CSV, Parquet and figure."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.columns import TableExport
from slider_drilling.log.series import LogContents
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    import plotly


@dataclass(frozen=True, repr=False)
class RigLog(LogContents, TableExport):
    """What one log holds; see `LogContents` for its fields.

    `to_frame`, `to_csv` and `to_parquet` give every quantity against time, NaN where it has no sample.
    """

    def plot(self, units: Units = SI) -> plotly.graph_objects.Figure:
        """Toolface, top drive, torque, pressure, hook load and weight on bit against time."""
        from slider_drilling.log.run_page import log_chart
        from slider_drilling.pages.notebook import plotly_figure

        return plotly_figure(log_chart(self), units)

    def save_page(self, path: str | os.PathLike[str], units: Units = SI) -> Path:
        """Write summary and figures as one HTML file of less than a megabyte; returns its path.

        Args:
            path: The file.
            units: `slider_drilling.units.SI` or `FIELD`.

        Raises:
            InputError: The file cannot be written, or the log holds nothing to plot.
        """
        from slider_drilling.log.run_page import write_run_page
        from slider_drilling.log.run_summary import summarise_run

        write_run_page(Path(path), self, summarise_run(self), units=units)
        return Path(path)
