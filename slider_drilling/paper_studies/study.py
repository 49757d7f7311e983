"""What a study consists of: figures made of plain arrays, and claims of the paper with a verdict."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slider_drilling.pages import HeatMap

Series = NDArray[np.float64]


@dataclass(frozen=True)
class StudyLine:
    """One curve: x and y are (n,); dashed for a companion of another curve, whose colour it may share."""

    name: str
    x: Series
    y: Series
    dashed: bool = False
    colour: int | None = None


@dataclass(frozen=True)
class StudyChart:
    """Curves over one pair of axes; labels carry the unit. level: a horizontal line to compare with, and its name."""

    title: str
    x_label: str
    y_label: str
    lines: tuple[StudyLine, ...]
    log_x: bool = False
    log_y: bool = False
    level: tuple[float, str] | None = None
    depth_down: bool = False


@dataclass(frozen=True)
class Claim:
    """One thing that the paper says, what was measured, and whether it holds; reason says why where it does not."""

    claim: str
    paper: str
    measured: dict[str, Any]
    holds: bool
    reason: str = ""


@dataclass(frozen=True)
class StudyTable:
    """Rows of text under a header, for a page."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Study:
    """A study that has run: what was moved (`settings`), its figures and its claims.

    The pages of other commands are made of the same: figures, tables and notes, without claims; about says what kind
    of page it is.
    """

    name: str
    title: str
    settings: dict[str, Any]
    figures: tuple[StudyChart | HeatMap, ...]
    claims: tuple[Claim, ...]
    notes: tuple[str, ...] = field(default=())
    tables: tuple[StudyTable, ...] = field(default=())
    about: str = "Study"


def study_line(name: str, x: ArrayLike, y: ArrayLike, dashed: bool = False, colour: int | None = None) -> StudyLine:
    """A Line from anything that numpy takes."""
    return StudyLine(name, np.asarray(x, dtype=float), np.asarray(y, dtype=float), dashed, colour)


def display_name(name: str) -> str:
    """A name of the program's as a reader writes it."""
    return name.replace("three_d", "3-D").replace("coulomb", "Coulomb").replace("_", " ")


UNCHANGED = 0.05
"""Of Coulomb friction: what is said not to depend on something may change by this much, in every study."""


def between(values: Iterable[float]) -> list[float]:
    """Smallest and largest, rounded for a report."""
    listed = list(values)
    return [round(min(listed), 4), round(max(listed), 4)]


def rounded(values: Iterable[float], digits: int = 4) -> list[float]:
    """Rounded for a report."""
    return [round(float(value), digits) for value in values]


def falling(values: Iterable[float]) -> bool:
    """Whether each value is below the one before."""
    return bool(np.all(np.diff(list(values)) < 0.0))
