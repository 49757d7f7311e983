"""Tables that people type: columns found by their heads, units from heads, a row of units, or beside a number."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.cells import Rows
from slider_drilling.schema.quantity_text import convert_quantity, split_quantity
from slider_drilling.schema.yaml_tree import shorten
from slider_drilling.units import KINDS, unit_factor

_MAX_PREAMBLE = 40  # rows above the heads: names of well, rig and company
_UNIT = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]\s*$|_(m|ft|in|mm|deg|rad)$|,\s*(\S.*)$")
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")
_THOUSANDS = re.compile(r"[-+]?\d{1,3}(,\d{3})+\.\d+")
_DECIMAL_COMMA = re.compile(r"[-+]?(\d+,(\d{1,2}|\d{4,})|0\d*,\d+|\d{4,},\d+)")
_GROUPS = re.compile(r"[-+]?\d{1,3}(,\d{3})+(\.\d*)?")


@dataclass(frozen=True)
class Column:
    """One column to look for.

    Attributes:
        name: What it holds.
        heads: How its head may begin, in lower case.
        unit: Unit of its numbers after reading; None for text.
        default_unit: Unit where the table names none; None where it has to.
        required: Whether a table without it is refused.
        own_marks: Whether only its own cells tell what their commas are; one such as 1,000 could be 1 or 1000.
    """

    name: str
    heads: tuple[str, ...]
    unit: str | None = None
    default_unit: str | None = None
    required: bool = True
    own_marks: bool = False


@dataclass(frozen=True)
class TableRow:
    """One row.

    Attributes:
        line: In the file, from 1.
        numbers: Column -> number in its unit; cells without one are missing.
        texts: Column -> text.
    """

    line: int
    numbers: dict[str, float]
    texts: dict[str, str]


@dataclass(frozen=True)
class TypedTable:
    """The rows of a table, and the head of each column that was found."""

    rows: tuple[TableRow, ...]
    heads: dict[str, str]


def read_typed_table(cells: Rows, columns: Sequence[Column], path: Path) -> TypedTable:
    """Find the columns of a table and read its rows.

    Args:
        cells: As `read_cells` gives them.
        columns: That are looked for; others are ignored.
        path: Names the table in errors.

    Raises:
        InputError: Naming file, line and head of what is missing, ambiguous or no number.
    """
    filled = [index for index, row in enumerate(cells) if any(row)]
    if not filled:
        raise InputError(f"{path}: empty; give a table of {', '.join(c.name for c in columns if c.required)} with a "
                         "header line")  # fmt: skip
    header = next((i for i in filled[:_MAX_PREAMBLE] if _fits(cells[i], columns)), filled[0])
    heads = cells[header]
    places = {column.name: place for column in columns if (place := _place(heads, column, path)) is not None}
    units, first = _unit_row(cells, header, columns, places)
    body = [(index + 1, cells[index]) for index in filled if index >= first]
    cells_of = {column.name: [row[place] for _, row in body if place < len(row)] for column in columns
                if column.unit is not None and (place := places.get(column.name)) is not None}  # fmt: skip
    commas = _decimal_commas(columns, cells_of)
    rows = []
    for line, row in body:
        numbers, texts = {}, {}
        for column in columns:
            place = places.get(column.name)
            text = row[place] if place is not None and place < len(row) else ""
            if place is None or not text:
                continue
            where = f"{path}: line {line}: {heads[place]} = {shorten(text)}"
            if column.unit is None:
                texts[column.name] = text
            else:
                unit = units.get(column.name) or _unit_of_head(heads[place], column, path)
                numbers[column.name] = _number(text, column.unit, unit, commas[column.name], where)
        rows.append(TableRow(line, numbers, texts))
    for column in columns:
        # A table without rows shall not hide that a column has no unit.
        if column.unit is not None and column.name in places and column.name not in units:
            _unit_of_head(heads[places[column.name]], column, path)
    return TypedTable(tuple(rows), {name: heads[place] for name, place in places.items()})


def _fits(row: Sequence[str], columns: Sequence[Column]) -> bool:
    return all(_matches(row, column) for column in columns if column.required)


def _matches(heads: Sequence[str], column: Column) -> list[int]:
    plain = [" ".join(head.lower().replace("_", " ").replace(".", " ").split()) for head in heads]
    for begin in column.heads:
        found = [place for place, head in enumerate(plain) if re.match(rf"{begin}(?![a-z])", head)]
        found = found or [place for place, head in enumerate(plain) if head.startswith(begin) and len(begin) > 2]
        if found:
            return found
    return []


def _place(heads: Sequence[str], column: Column, path: Path) -> int | None:
    matches = _matches(heads, column)
    if len(matches) == 1:
        return matches[0]
    if matches or column.required:
        many = "more than one" if matches else "none"
        shown = ", ".join(heads)[:300]
        raise InputError(f"{path}: {many} of {shown} is the {column.name}; name one column {column.heads[0]}")
    return None


def _unit_row(
    cells: Rows, header: int, columns: Sequence[Column], places: dict[str, int]
) -> tuple[dict[str, str], int]:
    """Units of the row below the heads, if that holds units, and the first row of data."""
    below = next((index for index in range(header + 1, len(cells)) if any(cells[index])), None)
    if below is None:
        return {}, header + 1
    row = cells[below]
    texts = {column.name: row[places[column.name]].strip("[]() ") for column in columns
             if column.unit is not None and column.name in places and places[column.name] < len(row)}  # fmt: skip
    if any(_NUMBER.match(text) for text in texts.values()):
        return {}, header + 1
    units = {name: text for name, text in texts.items() if any(unit_factor(text, kind) for kind in KINDS)}
    return (units, below + 1) if units else ({}, header + 1)


def _unit_of_head(head: str, column: Column, path: Path) -> str:
    match = _UNIT.search(head)
    unit = (match[1] or match[2] or match[3]) if match else None
    if unit is None and column.default_unit is None:
        hint = f"{head}_m or {head}_ft" if column.unit == "m" else f"{head} [{column.unit}]"
        raise InputError(f"{path}: column {head!r}: has no unit; write {hint}")
    unit = unit or column.default_unit or ""
    if column.unit is not None:
        convert_quantity(1.0, unit, column.unit, f"{path}: column {head!r}")
    return unit


def _number(text: str, target: str, unit: str, comma: bool | None, where: str) -> float:
    found = split_quantity(text.replace(",", ".") if comma else text)
    if found is not None:
        return convert_quantity(*found, target, where)
    plain = text.replace(",", ".") if comma else text
    if comma is False and _GROUPS.fullmatch(text):
        plain = text.replace(",", "")
    if not _NUMBER.fullmatch(plain):
        hint = "; is its comma a decimal one or between thousands? " if "," in text else ""
        hint += "write a decimal point, and nothing between thousands" if hint else ""
        raise InputError(f"{where}: not a number{hint}")
    number = float(plain)
    if not math.isfinite(number):
        raise InputError(f"{where}: not a number")
    return convert_quantity(number, unit, target, where)


def _decimal_commas(columns: Sequence[Column], cells_of: Mapping[str, list[str]]) -> dict[str, bool | None]:
    """What the commas of each column of numbers are, see `_decimal_comma`: the table's cells tell, or its own alone."""
    of_table = _decimal_comma([cell for texts in cells_of.values() for cell in texts])
    alone = {column.name for column in columns if column.own_marks and of_table}
    return {name: None if name in alone and _decimal_comma(texts) is None else of_table
            for name, texts in cells_of.items()}  # fmt: skip


def _decimal_comma(texts: Sequence[str]) -> bool | None:
    """Whether commas in these numbers are decimal (True) or part thousands (False); None where they do not tell."""
    if any(_THOUSANDS.fullmatch(text) for text in texts):
        return False
    return True if any(_DECIMAL_COMMA.fullmatch(text) for text in texts) else None
