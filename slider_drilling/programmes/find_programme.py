"""A programme by its file, by the file of a slide sheet, or by the name of one that is built in."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.files.output_files import read_text
from slider_drilling.programmes.programme import Programme, dump_programme, load_programme
from slider_drilling.programmes.slide_sheet import read_slide_sheet

BUILT_IN = {"commissioning": "config/programmes/commissioning.yaml", "stand": "config/programmes/stand.yaml"}
"""Programmes of the package by name."""
_TABLES = (".csv", ".tsv", ".txt", ".xlsx", ".xlsm")


@dataclass(frozen=True)
class FoundProgramme:
    """A programme and where it comes from.

    Attributes:
        programme: The programme.
        path: Its YAML file; None for one that was made from a slide sheet.
        start: Measured depth at which a slide sheet begins, m; None for a programme.
    """

    programme: Programme
    path: Path | None
    start: float | None = None


def programme_text(source: str | os.PathLike[str]) -> str:
    """The YAML text of a programme or slide sheet, for a log. Raises InputError as `find_programme`."""
    found = find_programme(source)
    return dump_programme(found.programme) if found.path is None else read_text(found.path, "programme")


def find_programme(source: str | os.PathLike[str]) -> FoundProgramme:
    """Read a programme.

    Args:
        source: Path of a programme (YAML) or of a slide sheet (CSV, XLSX), or a key of `BUILT_IN`.

    Raises:
        InputError: The file cannot be used.
    """
    path = installed_file(BUILT_IN[source]) if isinstance(source, str) and source in BUILT_IN else Path(source)
    if not path.suffix and not path.exists():
        raise InputError(f"{path}: no such programme; give the path of a file, or one of {', '.join(BUILT_IN)}")
    if path.suffix.lower() in _TABLES:
        sheet = read_slide_sheet(path)
        return FoundProgramme(sheet.programme, None, sheet.start)
    return FoundProgramme(load_programme(path), path)
