"""Tables that people type or export: the cells of a CSV file in any usual encoding, or of a sheet of an XLSX book."""

from __future__ import annotations

import csv
import datetime
import zipfile
from collections import Counter
from pathlib import Path

from slider_drilling.errors import InputError

_MAX_BYTES = 20_000_000
_MAX_ROWS, _MAX_COLUMNS = 100_000, 1000
_DELIMITERS = ",;\t|"
_SAMPLE = 30  # lines that show the delimiter

Rows = list[list[str]]


def read_cells(path: Path, what: str, sheet: str | None = None) -> Rows:
    """The cells of a table, row by row, as text without blanks around it.

    Args:
        path: CSV with comma, semicolon, tab or bar between cells, in UTF-8, UTF-16 or Windows-1252; or an XLSX book.
        what: What the table should be, for error messages.
        sheet: Sheet of a book; None for its first, and for a book of one sheet.

    Raises:
        InputError: The file cannot be read.
    """
    if path.suffix.lower() in (".xlsx", ".xlsm"):
        return _book_cells(path, what, sheet)
    content = _bytes(path, what)
    if b"\0" in content[:200] and not content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError(f"{path}: cannot read this {what}: neither text nor an XLSX book")
    lines = _decoded(content).splitlines()
    delimiter = _delimiter(lines)
    try:
        rows = list(csv.reader(lines, delimiter=delimiter))
    except csv.Error as error:
        raise InputError(f"{path}: cannot read this {what}: {error}") from None
    return [[cell.strip() for cell in row] for row in rows]


def _bytes(path: Path, what: str) -> bytes:
    try:
        if not path.is_file():
            raise InputError(f"{path}: no such {what}; check the path")
        with path.open("rb") as file:
            content = file.read(_MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot read this {what}: {error}") from None
    if len(content) > _MAX_BYTES:
        raise InputError(f"{path}: longer than {_MAX_BYTES / 1e6:g} MB, which no {what} is; check the path")
    return content


def _decoded(content: bytes) -> str:
    for mark, encoding in ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"\xef\xbb\xbf", "utf-8-sig")):
        if content.startswith(mark):
            return content.decode(encoding, errors="replace")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def _delimiter(lines: list[str]) -> str:
    """The character that divides the most lines into the same number of cells, more than one."""
    sample = [line for line in lines if line.strip()][:_SAMPLE]

    def agreement(delimiter: str) -> tuple[int, int]:
        counts = Counter(line.count(delimiter) for line in sample if delimiter in line)
        return max(((lines_, cells) for cells, lines_ in counts.items()), default=(0, 0))

    # A decimal comma divides lines too, but a semicolon or a tab beside it is what was meant.
    best = max(_DELIMITERS, key=agreement)
    others = [mark for mark in ";\t|" if agreement(mark)[0] >= 0.8 * max(len(sample), 1)]
    return others[0] if best == "," and others else best


def _book_cells(path: Path, what: str, sheet: str | None) -> Rows:
    try:
        from openpyxl import load_workbook
    except ImportError:
        raise InputError(f"{path}: XLSX needs openpyxl: pip install openpyxl, or save the {what} as CSV") from None
    _bytes(path, what)
    try:
        book = load_workbook(path, read_only=True, data_only=True)
        names = book.sheetnames
        if sheet is not None and len(names) > 1 and sheet not in names:
            raise InputError(f"{path}: no sheet {sheet!r} for the {what}; it has {', '.join(names)}")
        chosen = book[sheet] if sheet in names else book[names[0]]
        rows = chosen.iter_rows(max_row=_MAX_ROWS, max_col=_MAX_COLUMNS, values_only=True)
        return [[_text(cell) for cell in row] for row in rows]
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: cannot read this {what}: {error}") from None


def _text(cell: object) -> str:
    if cell is None:
        return ""
    if isinstance(cell, float):
        return f"{cell:.12g}"
    if isinstance(cell, datetime.datetime):
        return cell.isoformat(" ")
    return str(cell).strip()
