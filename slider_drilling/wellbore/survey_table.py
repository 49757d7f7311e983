"""A survey from a table: measured depth, inclination and azimuth, each column head with its unit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.cells import read_cells
from slider_drilling.schema.typed_table import Column, read_typed_table

MAX_TIE_IN = 5.0
"""deg; a survey that begins below the surface with no more inclination is vertical above its first station."""
_COLUMNS = (
    Column(
        "depth",
        ("md", "measured depth", "meas depth", "mdepth", "measured", "depth", "hole depth"),
        "m",
        own_marks=True,
    ),
    Column("inclination", ("inc", "incl", "inclination", "dev", "deviation"), "deg", "deg"),
    Column("azimuth", ("azi", "azimuth", "azm", "az", "azim", "hole direction"), "deg", "deg"),
)


@dataclass(frozen=True)
class Survey:
    """Stations of a survey.

    Attributes:
        stations: Rows of (measured depth m, inclination deg, azimuth deg), as a rig file's `well.survey` holds them.
        notes: What was added to the table.
    """

    stations: tuple[tuple[float, float, float], ...]
    notes: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        """Measured depth of the last station, m."""
        return self.stations[-1][0]


def read_survey(path: Path) -> Survey:
    """Read a survey.

    The heads name the columns: `md`, `inclination` and `azimuth` (or longer words that begin so), in any order, among
    others, below any lines about the well. The depth needs its unit, in its head (`md_ft`, `MD [m]`) or in a row below
    the heads; angles are deg unless a unit is named. A depth such as 1,000 needs another in its column that shows
    whether its comma is decimal: angles with decimal commas do not.

    Raises:
        InputError: Naming file and line of what cannot be read.
    """
    table = read_typed_table(read_cells(path, "survey", "survey"), _COLUMNS, path)
    rows: list[tuple[float, float, float]] = []
    for row in table.rows:
        for column in _COLUMNS:
            if column.name not in row.numbers:
                raise InputError(f"{path}: line {row.line}: {table.heads[column.name]} = '': not a number")
        depth, inclination, azimuth = (row.numbers[column.name] for column in _COLUMNS)
        if rows and depth <= rows[-1][0]:
            raise InputError(f"{path}: line {row.line}: {table.heads['depth']}: must increase from line to line")
        rows.append((depth, inclination, azimuth))
    if len(rows) < 2:
        raise InputError(f"{path}: {len(rows)} station(s); give at least two")
    return _from_surface(rows, path)


def _from_surface(rows: list[tuple[float, float, float]], path: Path) -> Survey:
    """The survey with a first station at the surface. Raises InputError where the hole above is not known."""
    depth, inclination, azimuth = rows[0]
    if depth < 0.0:
        raise InputError(f"{path}: begins at {depth:g} m: measured depth must not be negative")
    if depth == 0.0:
        return Survey(tuple(rows))
    if inclination > MAX_TIE_IN:
        raise InputError(
            f"{path}: begins at {depth:.5g} m with {inclination:.3g} deg: the hole above it is not known; add the "
            f"stations above (0 m, and where the hole leaves the vertical)"
        )
    note = f"begins at {depth:.5g} m with {inclination:.3g} deg: taken as vertical from the surface to there"
    return Survey(((0.0, 0.0, azimuth), *rows), (note,))
