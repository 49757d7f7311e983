"""`activities`: what the rig did in a log."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slider_drilling.api.replay import as_log
from slider_drilling.columns import Columns, TableExport
from slider_drilling.log import RigLog
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.pages import write_page
from slider_drilling.rig_activities.extract import windows
from slider_drilling.rig_activities.report import activities_page, activity_columns, day_chart, slide_columns, to_json
from slider_drilling.rig_activities.slides import DrilledSlide
from slider_drilling.rig_activities.split import Activity, DaySplit, split_day
from slider_drilling.schema.quantity_text import read_quantity
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    import plotly

    from slider_drilling.api.simulate import Run


@dataclass(frozen=True, repr=False)
class ActivitiesResult(TableExport):
    """The activities and slides of a log. `to_frame`, `to_csv` and `to_parquet` give one row an activity.

    Attributes:
        log: The log.
        day: How it was split.
    """

    log: RigLog
    day: DaySplit

    @property
    def activities(self) -> tuple[Activity, ...]:
        """In the order of their times."""
        return self.day.activities

    @property
    def slides(self) -> tuple[DrilledSlide, ...]:
        """Stretches drilled without rotation at one toolface."""
        return self.day.slides

    @property
    def tree(self) -> dict[str, Any]:
        """The content of activities.json."""
        return to_json(self.day)

    def __repr__(self) -> str:
        return f"ActivitiesResult({len(self.activities)} activities, {len(self.slides)} slides)"

    def columns(self) -> Columns:
        """One row an activity: start, kind, end, depths, new hole and rate."""
        return activity_columns(self.day)

    def slide_columns(self) -> Columns:
        """One row a slide: times, depths, rate, toolface, wraps, torques and differential pressure."""
        return slide_columns(self.day)

    def extract(self, what: str = "slide") -> list[RigLog]:
        """The log of each slide, or of each stretch of an activity such as ``"rotating"``."""
        return [cut_time_window(self.log, start, end) for start, end in windows(self.day, what)]

    def plot(self, units: Units = SI) -> plotly.graph_objects.Figure:
        """The day as a strip over what was measured. Raises InputError if plotly is not installed."""
        from slider_drilling.pages.notebook import plotly_figure

        return plotly_figure(day_chart(self.day), units)

    def save_page(self, path: str | os.PathLike[str], units: Units = SI) -> Path:
        """Write the page; returns its path.

        Args:
            path: The HTML file.
            units: `slider_drilling.units.SI` or `FIELD`.

        Raises:
            InputError: The file cannot be written.
        """
        write_page(Path(path), activities_page(self.day), units)
        return Path(path)


def activities(log: str | os.PathLike[str] | RigLog | Run, *, depth: float | str | None = None) -> ActivitiesResult:
    """Split a log into rotating, sliding, rocking, connections, tripping, circulating and off bottom.

    Args:
        log: Path of a log, a log in memory, or a run; a minute or more, such as a day.
        depth: Depth of the bit at the start, m, or a text with its unit such as ``"13500 ft"``; the log's own, or 0,
            if None.

    Raises:
        InputError: The log cannot be read, or lacks block, top drive, or pumps.
    """
    record = as_log(log)
    if isinstance(depth, str):
        depth = read_quantity(depth, "m", "activities: depth")
    return ActivitiesResult(record, split_day(record, depth))
