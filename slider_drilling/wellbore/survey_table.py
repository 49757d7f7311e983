"""A survey from a CSV table: measured depth, inclination and azimuth, each column head with its unit."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.units import si_factor

# Quantity of a column, by how its head begins; the unit follows in brackets or after the last underscore.
_COLUMNS = {"depth": ("md", "measured depth", "measured_depth", "depth"), "inclination": ("inc",), "azimuth": ("azi",)}
_UNIT = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]\s*$|_(m|ft|deg|rad)$")
_DEFAULT = {"inclination": "deg", "azimuth": "deg"}


def read_survey(path: Path) -> tuple[tuple[float, float, float], ...]:
    """Rows of (measured depth m, inclination deg, azimuth deg), as a rig file's `well.survey` holds them.

    The first line names the columns: `md`, `inclination` and `azimuth` (or longer words that begin so), in any order,
    among others. The depth needs its unit, as in `md_ft` or `MD [m]`; angles are deg unless the head names a unit. A
    path that begins below 0 m gets a first station there.

    Raises:
        InputError: Naming file and line of what cannot be read.
    """
    lines = read_text(path, "survey").splitlines()
    if not lines:
        raise InputError(f"{path}: empty; give a table of md, inclination and azimuth with a header line")
    delimiter = max(",;\t", key=lines[0].count)
    heads = [head.strip() for head in next(csv.reader([lines[0]], delimiter=delimiter))]
    places = {what: _column(heads, what, path) for what in _COLUMNS}
    factors = {what: _factor(heads[place], what, path) for what, place in places.items()}
    rows: list[tuple[float, float, float]] = []
    for number, cells in enumerate(csv.reader(lines[1:], delimiter=delimiter), start=2):
        if any(cell.strip() for cell in cells):
            depth, inclination, azimuth = (
                _number(cells, places[what], heads, f"{path}: line {number}") * factors[what] for what in _COLUMNS
            )
            if rows and depth <= rows[-1][0]:
                raise InputError(f"{path}: line {number}: {heads[places['depth']]}: must increase from line to line")
            rows.append((depth, inclination, azimuth))
    if len(rows) < 2:
        raise InputError(f"{path}: {len(rows)} station(s); give at least two")
    if rows[0][0] > 0.0:
        rows.insert(0, (0.0, rows[0][1], rows[0][2]))
    return tuple(rows)


def _column(heads: list[str], what: str, path: Path) -> int:
    matches = [place for place, head in enumerate(heads) if head.lower().startswith(_COLUMNS[what])]
    if len(matches) != 1:
        many = "none" if not matches else "more than one"
        raise InputError(f"{path}: {many} of {', '.join(heads)} is the {what}; name one column {_COLUMNS[what][0]}")
    return matches[0]


def _factor(head: str, what: str, path: Path) -> float:
    """Value of one unit of the column, in m or deg."""
    match = _UNIT.search(head)
    unit = (match[1] or match[2]) if match else _DEFAULT.get(what)
    if unit is None:
        raise InputError(f"{path}: column {head!r}: has no unit; write {head}_m or {head}_ft")
    if what == "depth":
        return si_factor(unit, "length", f"{path}: column {head!r}")
    return si_factor(unit, "angle", f"{path}: column {head!r}") / si_factor("deg", "angle", "")


def _number(cells: list[str], place: int, heads: list[str], where: str) -> float:
    text = cells[place].strip() if place < len(cells) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {heads[place]} = {text!r}: not a number")
    return value
