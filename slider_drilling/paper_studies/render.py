"""A study on disk: a page, a picture, the numbers and the claims."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling import __version__
from slider_drilling.files.output_files import make_folder, write_atomically
from slider_drilling.pages import page_html, write_page
from slider_drilling.pages.png import render_png
from slider_drilling.paper_studies.page import drawn, index_page, study_page
from slider_drilling.paper_studies.study import Study, StudyChart
from slider_drilling.units import SI, Units

SCHEMA = "slider_drilling/study/1"


def study_files(name: str, directory: Path) -> list[Path]:
    """What `write_study` writes for a study of this name; the directory is made. Raises InputError."""
    make_folder(directory)
    return [directory / f"{name}.{suffix}" for suffix in ("json", "csv", "png", "html")]


def write_study(
    study: Study, directory: Path, findings: dict[str, Any] | None = None, units: Units = SI
) -> list[Path]:
    """Write NAME.json, NAME.csv, NAME.png and NAME.html into a directory, which is made; the four paths.

    findings: what NAME.json holds instead of the claims; units: of the page and the picture. Each file is written under
    a temporary name and renamed.
    Raises InputError where the directory cannot be made or a file cannot be written.
    """
    make_folder(directory)
    contents = {
        "json": (
            json.dumps(as_json(study) if findings is None else findings, indent=1, allow_nan=False) + "\n"
        ).encode(),
        "csv": _csv(study).encode(),
        "png": render_png(tuple(drawn(figure) for figure in study.figures), units, study.title),
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
        "notes": list(study.notes),
    }


def _csv(study: Study) -> str:
    """Long form: figure, series, x and y with their labels, and the value of a map."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["figure", "series", "x_label", "x", "y_label", "y", "value"])
    for figure in study.figures:
        if isinstance(figure, StudyChart):
            for one in figure.lines:
                rows.writerows(
                    [figure.title, one.name, figure.x_label, f"{x:.9g}", figure.y_label, f"{y:.9g}", ""]
                    for x, y in zip(one.x, one.y, strict=True)
                )
            continue
        for y, across in zip(figure.y, figure.value, strict=True):
            rows.writerows(
                [
                    figure.title,
                    figure.value_label,
                    figure.x_label,
                    f"{x:.9g}",
                    figure.y_label,
                    f"{y:.9g}",
                    "" if np.isnan(value) else f"{value:.9g}",
                ]
                for x, value in zip(figure.x, across, strict=True)
            )
    return text.getvalue()


def write_index(studies: Sequence[Study], directory: Path, units: Units = SI) -> Path:
    """index.html, which leads to the pages of the studies beside it. Raises InputError."""
    write_page(directory / "index.html", index_page(studies), units)
    return directory / "index.html"
