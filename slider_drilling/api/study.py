"""`study`: a study of the paper's vibration tools, with figures, numbers and a verdict on each claim."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from slider_drilling.columns import Columns, TableExport
from slider_drilling.pages import Chart
from slider_drilling.paper_studies.catalogue import run_study
from slider_drilling.paper_studies.study import Claim, Study, chart_lines
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    import plotly


@dataclass(frozen=True, repr=False)
class StudyResult(TableExport):
    """The figures, tables and claims of a study."""

    study: Study

    @property
    def claims(self) -> tuple[Claim, ...]:
        """What the paper says, what was measured, and whether it holds."""
        return self.study.claims

    def __repr__(self) -> str:
        holding = sum(claim.holds for claim in self.claims)
        return f"StudyResult({self.study.name}: {self.study.title}; {holding} of {len(self.claims)} claims hold)"

    def columns(self) -> Columns:
        """Every point of every curve: figure, series, x and y; the labels carry the units."""
        rows = [(chart.title, line.name, chart.x_label, y_label, line)
                for chart in self.study.figures if isinstance(chart, Chart) for y_label, line in chart_lines(chart)]
        lengths = [len(row[-1].x) for row in rows]
        names = ("figure", "series", "x_label", "y_label")
        text = {name: np.repeat(np.array([row[k] for row in rows], dtype=object), lengths)
                for k, name in enumerate(names)}
        none = np.empty(0)
        return Columns({**text, "x": np.concatenate([none, *(row[-1].x for row in rows)]),
                        "y": np.concatenate([none, *(row[-1].y for row in rows)])})

    def save(self, folder: str | os.PathLike[str], units: Units = SI) -> list[Path]:
        """Write NAME.html, NAME.png, NAME.csv and NAME.json; returns their paths.

        Args:
            folder: Created if it does not exist.
            units: Of page and picture, `slider_drilling.units.SI` or `FIELD`.

        Raises:
            InputError: A file cannot be written.
            OSError: The folder cannot be created.
        """
        from slider_drilling.paper_studies.render import write_study

        return write_study(self.study, Path(folder), units=units)

    def plot(self, index: int = 0, units: Units = SI) -> plotly.graph_objects.Figure:
        """The figure with this index, from 0.

        Raises:
            IndexError: There are fewer figures.
        """
        from slider_drilling.pages.notebook import plotly_figure

        return plotly_figure(self.study.figures[index], units)


def study(name: str) -> StudyResult:
    """Run a study.

    Args:
        name: One of those that ``slider-drilling study --list`` prints.

    Raises:
        InputError: There is no study of this name.
    """
    return StudyResult(run_study(name))
