"""The paper's systems, each with figures, numbers and a verdict on what the paper says."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from slider_drilling.columns import Columns
from slider_drilling.paper_studies.catalogue import run_study
from slider_drilling.paper_studies.study import Claim, Study, StudyChart

if TYPE_CHECKING:
    import pandas
    import plotly


@dataclass(frozen=True, repr=False)
class StudyResult:
    """A study that has run."""

    study: Study

    @property
    def claims(self) -> tuple[Claim, ...]:
        """What the paper says, what was measured, and whether it holds."""
        return self.study.claims

    def __repr__(self) -> str:
        holding = sum(claim.holds for claim in self.claims)
        return f"StudyResult({self.study.name}: {self.study.title}; {holding} of {len(self.claims)} claims hold)"

    def columns(self) -> Columns:
        """Every point of every curve: figure, series, x and y, whose labels carry their units."""
        rows = [(chart.title, line.name, chart.x_label, chart.y_label, line)
                for chart in self.study.figures if isinstance(chart, StudyChart) for line in chart.lines]
        lengths = [len(row[-1].x) for row in rows]
        names = ("figure", "series", "x_label", "y_label")
        text = {name: np.repeat(np.array([row[k] for row in rows], dtype=object), lengths)
                for k, name in enumerate(names)}
        none = np.empty(0)
        return Columns({**text, "x": np.concatenate([none, *(row[-1].x for row in rows)]),
                        "y": np.concatenate([none, *(row[-1].y for row in rows)])})

    def to_frame(self) -> pandas.DataFrame:
        """`columns` as a pandas DataFrame. Raises InputError."""
        return self.columns().to_frame()

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """`columns` as CSV. Raises InputError."""
        return self.columns().to_csv(path)

    def to_parquet(self, path: str | os.PathLike[str]) -> Path:
        """`columns` as Parquet. Raises InputError."""
        return self.columns().to_parquet(path)

    def save(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write NAME.html, NAME.png, NAME.csv and NAME.json into a folder, which is made; the paths.

        Raises InputError, or OSError where the folder cannot be made.
        """
        from slider_drilling.paper_studies.render import write_study

        return write_study(self.study, Path(folder))

    def plot(self, index: int = 0) -> plotly.graph_objects.Figure:
        """One of the study's figures; index: which, from 0. Raises IndexError where there are fewer."""
        from slider_drilling.pages.notebook import plotly_figure
        from slider_drilling.paper_studies.page import drawn

        return plotly_figure(drawn(self.study.figures[index]))


def study(name: str) -> StudyResult:
    """Run a study by its name (``slider-drilling study --list`` has them). Raises InputError for an unknown one."""
    return StudyResult(run_study(name))
