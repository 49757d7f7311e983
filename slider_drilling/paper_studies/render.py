"""A study on disk: page, picture, numbers and claims."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling import __version__
from slider_drilling.files.output_files import make_folder, write_atomically
from slider_drilling.pages import Chart, HeatMap, page_html, write_page
from slider_drilling.pages.png import render_png
from slider_drilling.paper_studies.page import index_page, study_page
from slider_drilling.paper_studies.study import Study, chart_lines
from slider_drilling.units import SI, Units

SCHEMA = "slider_drilling/study/1"


def study_files(name: str, directory: Path) -> list[Path]:
    """The files that `write_study` writes for a study of this name; creates the directory. Raises InputError."""
    make_folder(directory)
    return [directory / f"{name}.{suffix}" for suffix in ("json", "csv", "png", "html")]


def write_study(
    study: Study, directory: Path, findings: dict[str, Any] | None = None, units: Units = SI
) -> list[Path]:
    """Write NAME.json, NAME.csv, NAME.png and NAME.html.

    Args:
        directory: Created if it does not exist. Each file is written under a temporary name and renamed.
        findings: Content of NAME.json instead of the claims.
        units: Of the page and the picture.

    Returns:
        The four paths.

    Raises:
        InputError: Where the directory cannot be made or a file cannot be written.
    """
    make_folder(directory)
    tree = as_json(study) if findings is None else findings
    contents = {
        "json": f"{json.dumps(tree, indent=1, allow_nan=False)}\n".encode(),
        "csv": study_csv(study).encode(),
        "png": render_png(study.figures, units, study.title),
        "html": page_html(study_page(study, units), units).encode(),
    }
    paths = {suffix: directory / f"{study.name}.{suffix}" for suffix in contents}
    for suffix, content in contents.items():
        write_atomically(paths[suffix], content)
    return list(paths.values())


def as_json(study: Study) -> dict[str, Any]:
    """The claims with their verdicts, as NAME.json holds them."""
    claims = []
    for claim in study.claims:
        row = {"claim": claim.claim, "paper": claim.paper, "measured": claim.measured, "holds": bool(claim.holds)}
        claims.append({**row, "reason": claim.reason} if claim.reason else row)
    return {
        "schema": SCHEMA,
        "version": __version__,
        "study": study.name,
        "title": study.title,
        "settings": study.settings,
        "claims": claims,
        "notes": [str(note) for note in study.notes],
    }


def study_csv(study: Study) -> str:
    """Long form: figure, series, x and y with their labels, and the value of a map."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["figure", "series", "x_label", "x", "y_label", "y", "value"])
    for figure in study.figures:
        rows.writerows(_chart_rows(figure) if isinstance(figure, Chart) else _map_rows(figure))
    return text.getvalue()


def _chart_rows(chart: Chart) -> Iterator[list[str]]:
    for y_label, line in chart_lines(chart):
        for x, y in zip(line.x, line.y, strict=True):
            yield [str(chart.title), str(line.name), chart.x_label, f"{x:.9g}", y_label, f"{y:.9g}", ""]


def _map_rows(heat_map: HeatMap) -> Iterator[list[str]]:
    labels = str(heat_map.title), heat_map.value_label, heat_map.x_label
    for y, row in zip(heat_map.y, heat_map.value, strict=True):
        for x, value in zip(heat_map.x, row, strict=True):
            yield [*labels, f"{x:.9g}", heat_map.y_label, f"{y:.9g}", "" if np.isnan(value) else f"{value:.9g}"]


def write_index(studies: Sequence[Study], directory: Path, units: Units = SI) -> Path:
    """Write index.html, which links to the pages of the studies beside it. Raises InputError."""
    write_page(directory / "index.html", index_page(studies), units)
    return directory / "index.html"
