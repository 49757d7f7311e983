"""A page as plain data, and as one HTML file that stands alone."""

from __future__ import annotations

import base64
import gzip
import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Any, Literal

from slider_drilling import __version__
from slider_drilling.files.output_files import write_atomically
from slider_drilling.pages.colours import DARK, LIGHT
from slider_drilling.pages.figures import Chart, HeatMap
from slider_drilling.pages.plotly_js import plotly_spec
from slider_drilling.units import Quantity, Sentence, Text, Units, format_number, shared_decimals, split_label

Tone = Literal["good", "plain", "bad"]
SCRIPT = "plotly-cartesian.min.js.gz"
"""plotly.js 4.1.1 with its cartesian traces: `npm pack plotly.js-cartesian-dist-min`, then `gzip -9n`."""
_PROSE = 40  # characters: a table with longer cells is shown as a list on a narrow screen
_NARROW = 4  # columns: more are shown as a card for each row on a narrow screen
_NUMERIC = re.compile(r"^(never|-|[-+]?[\d.]+(e-?\d+)?( (to|of) [-+]?[\d.]+)?( [%\w/]{1,7}( lbf| m)?)?)$")


@dataclass(frozen=True)
class Tag:
    """A word with a tone, in a cell: a verdict."""

    text: Text
    tone: Tone = "plain"


@dataclass(frozen=True)
class Link:
    """Another page, in a cell; href is relative to this one."""

    text: Text
    href: str


Cell = Text | float | int | None | Quantity | Tag | Link | tuple["Text | Quantity | Tag | Link", ...]


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        header: Column labels; a label that ends in ", UNIT" gives the unit of the column. May be empty.
        rows: Cells of each row; `slider_drilling.pages` says what a cell may be.
        caption: Text above the table.
        digits: Significant digits of numbers.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    caption: Text = ""
    digits: int = 3


@dataclass(frozen=True)
class BulletList:
    """A bulleted list."""

    lines: tuple[Text, ...]


@dataclass(frozen=True)
class Headline:
    """The main result.

    Attributes:
        text: One sentence.
        tone: Colour: good, plain or bad.
        label: A word above it, such as a verdict.
    """

    text: Text
    tone: Tone = "plain"
    label: str = ""


@dataclass(frozen=True)
class Section:
    """A heading with text, lists, tables and figures, in order; a collapsed section opens on a click."""

    title: str
    items: tuple[Text | BulletList | Table | Chart | HeatMap, ...]
    collapsed: bool = False


@dataclass(frozen=True)
class Page:
    """A page.

    Attributes:
        kind: What kind of page, such as "Run".
        title: Well, time, target.
        sections: Its content.
        facts: Name and value, shown below the title.
        headline: The main result.
        notes: Remarks at the foot.
    """

    kind: str
    title: Text
    sections: tuple[Section, ...]
    facts: tuple[tuple[str, str], ...] = ()
    headline: Headline | None = None
    notes: tuple[Text, ...] = ()


def write_page(path: Path, page: Page, units: Units) -> None:
    """Write a page as one HTML file that needs no network.

    Args:
        path: The file; replaced as a whole or not at all.
        page: The page.
        units: Units that numbers and labels are converted to.

    Raises:
        InputError: The file cannot be written.
    """
    write_atomically(path, page_html(page, units).encode("utf-8"))


def page_html(page: Page, units: Units) -> str:
    """The page as HTML with style, script and data inside."""
    import jinja2

    drawings: list[dict[str, Any]] = []
    sections = [
        {"title": section.title, "collapsed": section.collapsed,
         "groups": _grouped([_item(item, units, drawings) for item in section.items])}
        for section in page.sections
    ]  # fmt: skip
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    headline = None if page.headline is None else replace(page.headline, text=units.convert_text(page.headline.text))
    converted = replace(page, title=units.convert_text(page.title), headline=headline,
                        notes=tuple(units.convert_text(note) for note in page.notes))  # fmt: skip
    return environment.from_string(_file("page.html").decode()).render(
        page=converted, sections=sections, style=_file("page.css").decode(), behaviour=_file("page.js").decode(),
        light=LIGHT, dark=DARK, themes=json.dumps({"light": LIGHT, "dark": DARK}), version=__version__,
        drawings=_packed(json.dumps(drawings, separators=(",", ":")).encode()) if drawings else "",
        plotly=base64.b64encode(_file(SCRIPT)).decode() if drawings else "",
    )  # fmt: skip


def _file(name: str) -> bytes:
    return resources.files("slider_drilling.pages").joinpath(name).read_bytes()


def _packed(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


def _item(
    item: Text | BulletList | Table | Chart | HeatMap, units: Units, drawings: list[dict[str, Any]]
) -> dict[str, Any]:
    if isinstance(item, (str, Sentence)):
        return {"kind": "text", "text": units.convert_text(item)}
    if isinstance(item, BulletList):
        return {"kind": "bullets", "lines": [units.convert_text(line) for line in item.lines]}
    if isinstance(item, Table):
        return {"kind": "table", "caption": units.convert_text(item.caption), **converted_table(item, units)}
    drawn = plotly_spec(item, units)
    drawings.append({"data": drawn["data"], "layout": drawn["layout"], "height": drawn["height"]})
    wide = isinstance(item, Chart) and (item.wide or len(item.panels) > 1)
    return {"kind": "figure", "place": len(drawings) - 1, "title": units.convert_text(item.title),
            "caption": units.convert_text(item.caption), "legend": drawn["legend"],
            "height": drawn["height"], "wide": wide}  # fmt: skip


def _grouped(items: list[dict[str, Any]]) -> list[list[dict[str, Any]]]:
    """Group adjacent figures, which share a grid; every other item is its own group."""
    groups: list[list[dict[str, Any]]] = []
    for item in items:
        if groups and item["kind"] == "figure" == groups[-1][0]["kind"]:
            groups[-1].append(item)
        else:
            groups.append([item])
    return groups


def converted_table(table: Table, units: Units) -> dict[str, Any]:
    """Header, cells (each a list of lines), which columns are numbers, and whether cells are sentences."""
    column_units = [split_label(label)[1] for label in table.header]
    column_units += [""] * (max((len(row) for row in table.rows), default=0) - len(column_units))
    decimals = [_decimals([row[k] for row in table.rows if k < len(row)], unit, units, table.digits)
                for k, unit in enumerate(column_units)]  # fmt: skip
    rows = [
        [_cell(cell, unit, units, table.digits, places)
         for cell, unit, places in zip(row, column_units, decimals, strict=False)]
        for row in table.rows
    ]  # fmt: skip
    right = [all(_NUMERIC.match(_plain(row[k])) for row in rows if k < len(row) and _plain(row[k]))
             and any(k < len(row) and _plain(row[k]) for row in rows) for k in range(len(column_units))]  # fmt: skip
    longest = max((len(_plain(cell)) for row in rows for cell in row), default=0)
    return {"header": [units.convert_label(label) for label in table.header], "rows": rows, "right": right,
            "prose": len(table.header) > 2 and longest > _PROSE,
            "cards": len(table.header) > _NARROW and any(table.header)}  # fmt: skip


def _plain(parts: list[dict[str, str]]) -> str:
    return " ".join(part["text"] for part in parts)


def _decimals(cells: Sequence[Cell], unit: str, units: Units, digits: int) -> int | None:
    """Decimals that the numbers of a column share: those of its largest.

    None if a smaller number would lose its last digit.
    """
    numbers = [units.convert(float(cell), unit) for cell in cells if isinstance(cell, (int, float))]
    return shared_decimals(numbers, digits)


def _cell(cell: Cell, unit: str, units: Units, digits: int, decimals: int | None = None) -> list[dict[str, str]]:
    """The lines of a cell; numbers get so many decimals, or significant digits if that is None."""
    if isinstance(cell, tuple):
        return [part for line in cell for part in _cell(line, unit, units, digits)]
    if isinstance(cell, Tag):
        return [{"text": units.convert_text(cell.text), "tone": cell.tone}]
    if isinstance(cell, Link):
        return [{"text": units.convert_text(cell.text), "href": cell.href}]
    if isinstance(cell, Quantity):
        return [{"text": units.format(cell.value, cell.unit, cell.digits)}]
    if cell is None:
        return [{"text": "-"}]
    if isinstance(cell, (str, Sentence)):
        return [{"text": units.convert_text(cell)}]
    if isinstance(cell, int) and not unit:
        return [{"text": f"{cell}"}]
    number = units.convert(float(cell), unit)
    if decimals is not None and math.isfinite(number):
        return [{"text": f"{number + 0.0:.{decimals}f}"}]
    return [{"text": format_number(number, digits)}]
