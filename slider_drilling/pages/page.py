"""A page as plain data, and as one HTML file that stands alone."""

from __future__ import annotations

import base64
import gzip
import json
import re
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Any, Literal

from slider_drilling import __version__
from slider_drilling.files.output_files import write_atomically
from slider_drilling.pages.colours import DARK, LIGHT
from slider_drilling.pages.figures import Chart, HeatMap
from slider_drilling.pages.plotly_js import plotly_spec
from slider_drilling.units import Quantity, Sentence, Text, Units, format_number, split_label

Tone = Literal["good", "plain", "bad"]
SCRIPT = "plotly-cartesian.min.js.gz"
"""plotly.js 4.1.1 with its cartesian traces: `npm pack plotly.js-cartesian-dist-min`, then `gzip -9n`."""
_PROSE = 40  # characters: cells longer than this are read, and stand one below the other on a telephone
_NUMERIC = re.compile(r"^(never|-|[-+]?[\d.]+(e-?\d+)?( (to|of) [-+]?[\d.]+)?( [%\w/]{1,7}( lbf| m)?)?)$")


@dataclass(frozen=True)
class Tag:
    """A word with a tone, in a cell: a verdict."""

    text: Text
    tone: Tone = "plain"


@dataclass(frozen=True)
class Link:
    """Another page, in a cell; href is relative to this one."""

    text: str
    href: str


Cell = Text | float | int | None | Quantity | Tag | Link | tuple["Text | Quantity | Tag | Link", ...]


@dataclass(frozen=True)
class Table:
    """Rows under a header, which may be empty; see the package for what a cell may be. caption: said above it."""

    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    caption: Text = ""
    digits: int = 3


@dataclass(frozen=True)
class BulletList:
    """Sentences, one a line."""

    lines: tuple[Text, ...]


@dataclass(frozen=True)
class Headline:
    """The sentence that a reader came for, with a tone; word: what stands above it, a verdict."""

    text: Text
    tone: Tone = "plain"
    label: str = ""


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it: text, bullets, tables and figures, in order. folded: closed until opened."""

    title: str
    items: tuple[Text | BulletList | Table | Chart | HeatMap, ...]
    collapsed: bool = False


@dataclass(frozen=True)
class Page:
    """about: what kind of page; title: well, time, target; facts: what else it is of, name and value; notes: remarks
    at its foot."""

    kind: str
    title: str
    sections: tuple[Section, ...]
    facts: tuple[tuple[str, str], ...] = ()
    headline: Headline | None = None
    notes: tuple[Text, ...] = ()


def write_page(path: Path, page: Page, units: Units) -> None:
    """The page at `path`, whole or not at all; it needs no network. Raises InputError."""
    write_atomically(path, page_html(page, units).encode("utf-8"))


def page_html(page: Page, units: Units) -> str:
    """The page's HTML, style, script and data inside."""
    import jinja2

    drawings: list[dict[str, Any]] = []
    sections = [
        {"title": section.title, "collapsed": section.collapsed,
         "groups": _grouped([_item(item, units, drawings) for item in section.items])}
        for section in page.sections
    ]  # fmt: skip
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    headline = None if page.headline is None else replace(page.headline, text=units.convert_text(page.headline.text))
    told = replace(page, headline=headline, notes=tuple(units.convert_text(note) for note in page.notes))
    return environment.from_string(_file("page.html").decode()).render(
        page=told, sections=sections, style=_file("page.css").decode(), behaviour=_file("page.js").decode(),
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
        return {"kind": "table", "caption": units.convert_text(item.caption), **_table(item, units)}
    drawn = plotly_spec(item, units)
    drawings.append({"data": drawn["data"], "layout": drawn["layout"], "height": drawn["height"]})
    wide = isinstance(item, Chart) and (item.wide or len(item.panels) > 1)
    return {"kind": "figure", "place": len(drawings) - 1, "title": units.convert_text(item.title),
            "caption": units.convert_text(item.caption), "legend": drawn["legend"],
            "height": drawn["height"], "wide": wide}  # fmt: skip


def _grouped(items: list[dict[str, Any]]) -> list[list[dict[str, Any]]]:
    """Figures that follow each other share a grid; everything else stands by itself."""
    groups: list[list[dict[str, Any]]] = []
    for item in items:
        if groups and item["kind"] == "figure" == groups[-1][0]["kind"]:
            groups[-1].append(item)
        else:
            groups.append([item])
    return groups


def _table(table: Table, units: Units) -> dict[str, Any]:
    column_units = [split_label(label)[1] for label in table.header]
    column_units += [""] * (max((len(row) for row in table.rows), default=0) - len(column_units))
    rows = [
        [_cell(cell, unit, units, table.digits) for cell, unit in zip(row, column_units, strict=False)]
        for row in table.rows
    ]
    right = [all(_NUMERIC.match(_plain(row[k])) for row in rows if k < len(row) and _plain(row[k]))
             and any(k < len(row) and _plain(row[k]) for row in rows) for k in range(len(column_units))]  # fmt: skip
    longest = max((len(_plain(cell)) for row in rows for cell in row), default=0)
    return {"header": [units.convert_label(label) for label in table.header], "rows": rows, "right": right,
            "prose": len(table.header) > 2 and longest > _PROSE}  # fmt: skip


def _plain(parts: list[dict[str, str]]) -> str:
    return " ".join(part["text"] for part in parts)


def _cell(cell: Cell, unit: str, units: Units, digits: int) -> list[dict[str, str]]:
    """A cell's parts, one below the other."""
    if isinstance(cell, tuple):
        return [part for one in cell for part in _cell(one, unit, units, digits)]
    if isinstance(cell, Tag):
        return [{"text": units.convert_text(cell.text), "tone": cell.tone}]
    if isinstance(cell, Link):
        return [{"text": cell.text, "href": cell.href}]
    if isinstance(cell, Quantity):
        return [{"text": units.format(cell.value, cell.unit, cell.digits)}]
    if cell is None:
        return [{"text": "-"}]
    if isinstance(cell, (str, Sentence)):
        return [{"text": units.convert_text(cell)}]
    if isinstance(cell, int) and not unit:
        return [{"text": f"{cell}"}]
    return [{"text": format_number(units.convert(float(cell), unit), digits)}]
