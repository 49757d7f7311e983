"""The parts of a study: charts, and claims of the paper with a verdict each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slider_drilling.pages import Chart, HeatMap, Line, Panel, Table
from slider_drilling.pages.colours import ORDER
from slider_drilling.units import Quantity, Sentence, Text, sentence

UNCHANGED = 0.05
"""Fraction of Coulomb friction by which something "independent" may change, in every study."""


@dataclass(frozen=True)
class Claim:
    """One claim of the paper and its verdict.

    Attributes:
        claim: The claim, as a sentence.
        paper: Where the paper makes it.
        measured: What the model gives, by name; a name's last words are its unit.
        holds: The verdict.
        reason: Why it does not hold, or a remark.
    """

    claim: str
    paper: str
    measured: dict[str, Any]
    holds: bool
    reason: str = ""


@dataclass(frozen=True)
class Study:
    """A study that has run.

    Pages of other commands use the same form without claims.

    Attributes:
        name: Of the study, its files and its command.
        title: Heading.
        settings: What was varied, and over which range.
        figures: Charts and maps.
        claims: Of the paper.
        notes: Sentences for the foot of the page.
        tables: Tables above the figures.
        about: What kind of page it is.
    """

    name: str
    title: Text
    settings: dict[str, Any]
    figures: tuple[Chart | HeatMap, ...]
    claims: tuple[Claim, ...]
    notes: tuple[Text, ...] = ()
    tables: tuple[Table, ...] = ()
    about: str = "Study"


def setting_name(value: float, unit: str, suffix: str = "") -> Sentence:
    """Name of a curve by the setting that it was made with: "7 m/h"."""
    digits = len(f"{value:g}".lstrip("0.").replace(".", ""))
    return sentence(Quantity(value, unit, max(digits, 1)), suffix)


def curve(name: Text, x: ArrayLike, y: ArrayLike, dashed: bool = False, colour: int | None = None) -> Line:
    """A line from any arrays (n,).

    Args:
        dashed: For a companion of another curve, whose colour it may share.
        colour: Index into the colour order; None for the curve's place in its chart.
    """
    shade = "" if colour is None else ORDER[colour % len(ORDER)]
    return Line(name, np.asarray(x, dtype=float), np.asarray(y, dtype=float), "dashed" if dashed else "line", shade)


def curve_chart(
    title: Text, x_label: str, y_label: str, curves: Sequence[Line], *, log_x: bool = False, log_y: bool = False,
    level: tuple[float, str] | None = None, depth_down: bool = False,
) -> Chart:  # fmt: skip
    """A chart with one pair of axes; labels carry the unit.

    Args:
        level: Height and name of a horizontal line to compare with.
        depth_down: The y axis points down.
    """
    coloured = tuple(
        line if line.colour else replace(line, colour=ORDER[place % len(ORDER)]) for place, line in enumerate(curves)
    )
    return Chart(title, x_label, (Panel(y_label, coloured, level, log_y, depth_down),), x_log=log_x)


def chart_lines(chart: Chart) -> list[tuple[str, Line]]:
    """The curves of a chart, each with the label of its y axis."""
    return [(panel.y_label, mark) for panel in chart.panels for mark in panel.marks if isinstance(mark, Line)]


def display_name(name: str) -> str:
    """A name in code as a reader writes it."""
    return name.replace("three_d", "3-D").replace("coulomb", "Coulomb").replace("_", " ")


def between(values: Iterable[float]) -> list[float]:
    """Smallest and largest value, rounded for a report."""
    listed = list(values)
    return [round(min(listed), 4), round(max(listed), 4)]


def rounded(values: Iterable[float], digits: int = 4) -> list[float]:
    """The values, rounded for a report."""
    return [round(float(value), digits) for value in values]


def falling(values: Iterable[float]) -> bool:
    """Whether each value is below the one before."""
    return bool(np.all(np.diff(list(values)) < 0.0))
