"""Workbooks (XLSX): the first sheet, or the named one; dates keep their type."""

from __future__ import annotations

import datetime
import itertools
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
    columns: dict[str, Cells] = {
        name: _column([row[place] if place < len(row) else None for row in rows[first:]])
        for place, name in enumerate(names)
    }
    heads = Heads(names, tuple((units + [""] * width)[:width]), named=named)
    return TableInMemory(heads, Table(printable(str(path)), columns, np.array(lines[first:], dtype=np.int64)))


def _cells(path: Path, sheet: str) -> tuple[list[tuple[Any, ...]], list[int]]:
    """Values of all rows that are not empty, and their numbers."""
    openpyxl = library("openpyxl", path, "a workbook")
    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    except Exception as error:  # openpyxl raises many kinds for a file that is none
        raise InputError(f"{path}: cannot read this workbook: {' '.join(str(error).split())[:200]}") from None
    try:
        if sheet and sheet not in book.sheetnames:
            raise InputError(f"{path}: has no sheet {sheet!r}; it has {', '.join(book.sheetnames)}")
        rows, lines, count = [], [], 0
        for number, row in enumerate((book[sheet] if sheet else book.worksheets[0]).iter_rows(values_only=True), 1):
            if any(value is not None and value != "" for value in row):
                rows.append(row)
                lines.append(number)
                count += len(row)
            if count > _MAX_CELLS:
                raise InputError(f"{path}: row {number}: more than {_MAX_CELLS} cells; save it as CSV")
    finally:
        book.close()
    if not rows:
        raise InputError(f"{path}: is empty; expected a header line and rows of numbers")
    return rows, lines


def _text(value: Any) -> str:
    return "" if value is None else str(value).strip()


def _column(values: list[Any]) -> Cells:
    """A column as numbers, as times, or as text where it holds anything else."""
    known = [value for value in itertools.islice(values, 2000) if value is not None and value != ""]
    if known and all(isinstance(value, (datetime.datetime, datetime.date, datetime.time)) for value in known):
        return np.array([_stamp(value) for value in values], dtype="datetime64[ns]")
    if known and all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values
                     if value is not None):  # fmt: skip
        return np.array([np.nan if value is None else float(value) for value in values])
    return [_text(value) for value in values]


def _stamp(value: Any) -> np.datetime64:
    if isinstance(value, datetime.datetime):
        return np.datetime64(value.replace(tzinfo=None), "ns")
    if isinstance(value, datetime.date):
        return np.datetime64(value, "ns")
    if isinstance(value, datetime.time):
        return np.datetime64(datetime.datetime.combine(datetime.date(1970, 1, 1), value), "ns")
    return np.datetime64("NaT", "ns")
