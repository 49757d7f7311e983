"""Workbooks (XLSX): the first sheet, or the named one; dates keep their type."""

from __future__ import annotations

import datetime
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.table_import.delimited_text import find_heads
from slider_drilling.table_import.mapping import TableLayout
from slider_drilling.table_import.optional import library
from slider_drilling.table_import.source import Cells, Heads, Table, TableInMemory

_MAX_CELLS = 20_000_000


def open_workbook(path: Path, sheet: str, layout: TableLayout | None) -> TableInMemory:
    """The table of one sheet. Raises InputError where the file is no workbook, or has no such sheet."""
    rows, lines = _cells(path, sheet)
    texts = [(line, [_text(value) for value in row]) for line, row in zip(lines[:60], rows[:60], strict=True)]
    names, units, after, named = find_heads(texts, layout)
    first = next((index for index, line in enumerate(lines) if line > after), len(rows))
    width = len(names)
    by_place = list(zip(*rows[first:], strict=True))  # all rows are as wide as the sheet
    columns: dict[str, Cells] = {
        name: _column(by_place[place] if place < len(by_place) else ()) for place, name in enumerate(names)
    }
    heads = Heads(names, tuple((units + [""] * width)[:width]), named=named)
    return TableInMemory(heads, Table(printable(str(path)), columns, np.array(lines[first:], dtype=np.int64)))


def _cells(path: Path, sheet: str) -> tuple[list[list[Any]], list[int]]:
    """Values of all rows that are not empty, and their numbers; empty cells are empty texts."""
    calamine = library("python_calamine", path, "a workbook")
    try:
        book = calamine.CalamineWorkbook.from_path(path)
        if sheet and sheet not in book.sheet_names:
            raise InputError(f"{path}: has no sheet {sheet!r}; it has {', '.join(book.sheet_names)}")
        area = book.get_sheet_by_name(sheet) if sheet else book.get_sheet_by_index(0)
        if area.total_height * area.total_width > _MAX_CELLS:
            raise InputError(f"{path}: more than {_MAX_CELLS} cells; save it as CSV")
        every = area.to_python(skip_empty_area=False)
    except (calamine.CalamineError, OSError) as error:
        raise InputError(f"{path}: cannot read this workbook: {' '.join(str(error).split())[:200]}") from None
    rows, lines = [], []
    for number, row in enumerate(every, 1):
        if any(value != "" for value in row):
            rows.append(row)
            lines.append(number)
    if not rows:
        raise InputError(f"{path}: is empty; expected a header line and rows of numbers")
    return rows, lines


def _text(value: Any) -> str:
    return str(value).strip()


def _column(values: Sequence[Any]) -> Cells:
    """A column as numbers, as times, or as text where it holds anything else."""
    if set(map(type, values)) <= {int, float}:
        return np.array(values, dtype=float)
    known = [value for value in itertools.islice(values, 2000) if value != ""]
    if known and all(isinstance(value, (datetime.datetime, datetime.date, datetime.time)) for value in known):
        return np.array([_stamp(value) for value in values], dtype="datetime64[ns]")
    if known and all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values
                     if value != ""):  # fmt: skip
        return np.array([np.nan if value == "" else float(value) for value in values])
    return [_text(value) for value in values]


def _stamp(value: Any) -> np.datetime64:
    if isinstance(value, datetime.datetime):
        return np.datetime64(value.replace(tzinfo=None), "ns")
    if isinstance(value, datetime.date):
        return np.datetime64(value, "ns")
    if isinstance(value, datetime.time):
        return np.datetime64(datetime.datetime.combine(datetime.date(1970, 1, 1), value), "ns")
    return np.datetime64("NaT", "ns")
