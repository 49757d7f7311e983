"""Tables of text: any delimiter, encoding and number of lines before the heads; a line of units; ragged rows."""

from __future__ import annotations

import codecs
import csv
import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path

import numpy as np

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_lines
from slider_drilling.table_import.mapping import AUTO, TableLayout
from slider_drilling.table_import.numbers import NULL_WORDS
from slider_drilling.table_import.source import SAMPLE_ROWS, Heads, Table, distinct
from slider_drilling.unit_spellings import written_plainly
from slider_drilling.units import KINDS, unit_factor

_MAX_CELLS = 10_000_000  # of the columns that are kept: a gigabyte, as text and as numbers
_MAX_CELL_LINES = 50  # a cell with more comes from a quote that is never closed
_SNIFFED_BYTES = 256 * 1024
_SNIFFED_LINES = 60
_NUMBER = re.compile(r"[+-]?(?:\d[\d.,']*|[.,]\d+)(?:[eE][+-]?\d+)?")
_CLOCK = re.compile(r"\d{1,2}:\d{2}|\d{1,4}[-/.]\w{1,4}[-/.]\d{1,4}")
_BRACKETS = re.compile(r"^(?P<name>.*?\S)\s*[\[({](?P<unit>[^\])}]*)[\])}]\s*$")
_AFTER_COMMA = re.compile(r"^(?P<name>.*?\S)\s*,\s*(?P<unit>\S.*)$")


@dataclass(frozen=True)
class TextFormat:
    """How a text is a table.

    Attributes:
        encoding: Of the file.
        delimiter: Between cells; " " for any number of blanks.
        skip: Lines before the rows of numbers.
    """

    encoding: str
    delimiter: str
    skip: int


@dataclass(frozen=True)
class TextTable:
    """A table of text that was opened; see `TableSource`.

    Attributes:
        path: The file.
        format: How it is a table.
        heads: Its columns.
        width: Cells of a row.
        note: What was found out to read it, one sentence; empty for plain CSV.
    """

    path: Path
    format: TextFormat
    heads: Heads
    width: int
    note: str = ""

    def sample(self) -> Table:
        """The first rows with all columns."""
        return self._table(self.heads.names, None, SAMPLE_ROWS)

    def read(self, names: Sequence[str], rows: tuple[int, int] | None) -> Table:
        """These columns, of these data rows or of all. Raises InputError."""
        return self._table(names, rows, None)

    def _table(self, names: Sequence[str], rows: tuple[int, int] | None, at_most: int | None) -> Table:
        picked, lines, notes = self._cells([self.heads.names.index(name) for name in names], rows, at_most)
        columns = [list(column) for column in zip(*picked, strict=True)] if picked else [[] for _ in names]
        found = (self.note,) if self.note else ()
        return Table(
            printable(str(self.path)), dict(zip(names, columns, strict=True)), np.array(lines, dtype=np.int64), "line",
            (*found, *notes),
        )  # fmt: skip

    def _cells(
        self, indices: list[int], rows: tuple[int, int] | None, at_most: int | None
    ) -> tuple[list[tuple[str, ...]], list[int], list[str]]:
        """The picked cells of each row, the line that each ends on, and what was done about ragged rows."""
        first, last = rows if rows is not None else (0, at_most - 1 if at_most else 2**62)
        pick = itemgetter(*indices) if len(indices) > 1 else lambda row: (row[indices[0]],)
        limit = _MAX_CELLS // max(len(indices), 1)
        picked: list[tuple[str, ...]] = []
        lines: list[int] = []
        short: list[int] = []
        count = 0
        for line, row in self._rows():
            count += 1
            if count <= first:
                continue
            if count > last + 1 and at_most:
                break
            if count > last + 1:
                continue
            if len(row) != self.width:
                row = self._full(row, line, short)
            picked.append(pick(row))
            lines.append(line)
            if len(lines) >= limit:
                raise InputError(
                    f"{self.path}: line {line}: more than {_MAX_CELLS} cells so far, in {len(indices)} columns that "
                    f"are read; import it in parts, the first with --rows {first}:{first + len(lines) - 1}"
                )
        if rows is not None and not first <= last < count:
            raise InputError(f"{self.path}: rows {first}:{last}: the table has rows 0 to {count - 1}")
        if not lines:
            raise InputError(f"{self.path}: has no rows of numbers")
        notes = []
        if short and short[-1] == lines[-1] and len(lines) > 1 and self._breaks_off():
            notes.append(f"line {lines[-1]} breaks off: left out")
            del picked[-1], lines[-1], short[-1]
        if short:
            notes.append(f"{len(short)} rows have fewer cells than heads, the first is line {short[0]}: taken as null")
        return picked, lines, notes

    def _breaks_off(self) -> bool:
        """Whether the last line has no end, as in a file that was copied while it was written."""
        last = ""
        for line in _lines(self.path, self.format.encoding):
            last = line
        return not last.endswith("\n")

    def _full(self, row: list[str], line: int, short: list[int]) -> list[str]:
        """A row with as many cells as there are columns. Raises InputError for one with more than empty ones."""
        if len(row) > self.width:
            if any(cell.strip() for cell in row[self.width :]):
                raise InputError(
                    f"{self.path}: line {line}: {len(row)} cells where {self.width} columns are named; "
                    "is the delimiter within a cell?"
                )
            return row[: self.width]
        short.append(line)
        return row + [""] * (self.width - len(row))

    def _rows(self) -> Iterator[tuple[int, list[str]]]:
        """Yield the data rows that are not empty, each with the line that it ends on."""
        lines = _lines(self.path, self.format.encoding)
        return cells_of_lines(self.path, lines, self.format.delimiter, self.format.skip)


def open_text(path: Path, layout: TableLayout | None) -> TextTable:
    """Find out how a text is a table; what the layout of a mapping file says is taken as it is. Raises InputError."""
    encoding, note = _encoding(path, layout.encoding if layout else AUTO)
    delimiter = layout.delimiter if layout else AUTO
    top = list(itertools.islice(_lines(path, encoding), _SNIFFED_LINES))
    if delimiter == AUTO:
        delimiter = _sniff_delimiter(top, layout)
    rows = _top_rows(path, encoding, delimiter)
    if not rows:
        raise InputError(f"{path}: is empty; expected a header line and rows of numbers")
    names, units, after, named = find_heads(rows, layout)
    width = len(names)
    shown = tuple((units + [""] * width)[:width])
    if encoding != "utf-8-sig":
        note = note or f"read as {encoding}"
    if delimiter not in (",", AUTO) and not (layout and "delimiter" in layout.given):
        blank = {"\t": "tabs", " ": "blanks", ";": "semicolons", "|": "bars"}
        note = (
            f"{note}, cells apart by {blank[delimiter]}".lstrip(", ") if note else f"cells apart by {blank[delimiter]}"
        )
    heads = Heads(names, shown, named=named)
    return TextTable(path, TextFormat(encoding, delimiter, after), heads, width, note)


def find_heads(
    rows: list[tuple[int, list[str]]], layout: TableLayout | None
) -> tuple[tuple[str, ...], list[str], int, bool]:
    """Find heads and units in the first rows of a table.

    Args:
        rows: Line and cells of each row that is not empty.
        layout: What a mapping file says, if there is one.

    Returns:
        Names; units; the last line before the data; whether the names are the table's own or the mapping file's.
    """
    skip = layout.skip_lines if layout and "skip_lines" in layout.given else None
    row, has_heads = _heads_row(rows, layout, skip)
    if layout and layout.names:
        names, after = list(layout.names), skip or 0
    elif has_heads:
        names, after = [cell.strip() for cell in row[1]], row[0]
    else:
        names, after = [f"column {number}" for number in range(1, len(row[1]) + 1)], row[0] - 1
    while has_heads and len(names) > 1 and not names[-1]:
        names.pop()  # a delimiter at the end of the line
    following = next((other for other in rows if other[0] > after), None)
    if layout and "unit_line" in layout.given:
        has_units = layout.unit_line
    else:
        has_units = has_heads and following is not None and _is_unit_row(following[1])
    units = []
    if has_units and following is not None:
        units, after = [cell.strip() for cell in following[1]], following[0]
    return distinct(names), units, after, has_heads or bool(layout and layout.names)


def split_head(head: str) -> tuple[str, str]:
    """Name and unit of a head such as "Hook Load (klbf)" or "Torque [kN.m]"; the unit is empty where it has none."""
    match = _BRACKETS.match(head) or _AFTER_COMMA.match(head)
    if match and not written_plainly(match["unit"])[1]:
        return match["name"], ""  # "Torque (-)"
    if match and any(unit_factor(match["unit"], kind) is not None for kind in KINDS):
        return match["name"], match["unit"]
    bare, _, unit = head.rpartition("_")
    if bare and len(unit) > 1 and any(unit_factor(unit.replace("per", "/"), kind) is not None for kind in KINDS):
        return bare, unit.replace("per", "/")
    return head, ""


def split_brackets(head: str) -> tuple[str, str]:
    """What stands before and within the brackets at a head's end, whether it is a unit or not; (head, "") without."""
    match = _BRACKETS.match(head)
    return (match["name"], match["unit"]) if match else (head, "")


def _encoding(path: Path, wanted: str) -> tuple[str, str]:
    """The encoding of a file, and a note where it was guessed."""
    if wanted != AUTO:
        try:
            return codecs.lookup(wanted).name.replace("utf-8", "utf-8-sig").replace("-sig-sig", "-sig"), ""
        except LookupError:
            raise InputError(f"encoding = {wanted!r}: not known; use utf-8, utf-16 or cp1252") from None
    if not path.is_file():
        return "utf-8-sig", ""  # reading the lines reports why it cannot be read
    try:
        with open(path, "rb") as file:
            head = file.read(_SNIFFED_BYTES)
            if head[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
                return "utf-16", ""
            nulls = head.count(b"\x00")
            if nulls > len(head) // 4:
                return ("utf-16-le" if head[1:2] == b"\x00" else "utf-16-be"), ""
            decoder = codecs.getincrementaldecoder("utf-8")()
            while head:
                decoder.decode(head)
                head = file.read(1 << 20)
            decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        return "cp1252", "is not UTF-8: read as Windows-1252"
    except OSError:
        return "utf-8-sig", ""  # likewise
    return "utf-8-sig", ""


def _lines(path: Path, encoding: str) -> Iterator[str]:
    return read_lines(path, "table", encoding)


def cells_of_lines(path: Path, lines: Iterator[str], delimiter: str, skip: int) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows that are not empty, each with the line that it ends on, after the lines that are skipped."""
    for _ in range(skip):
        next(lines, None)
    if delimiter == " ":
        for number, line in enumerate(lines, skip + 1):
            words = line.split()
            if words:
                yield number, words
        return
    reader = csv.reader(lines, delimiter=delimiter)
    row_start = skip + 1
    try:
        for row in reader:
            long = skip + reader.line_num - row_start > _MAX_CELL_LINES
            if long and any(word.count("\n") > _MAX_CELL_LINES for word in row):
                raise csv.Error(f"a cell of more than {_MAX_CELL_LINES} lines")
            if (row and row[0].strip()) or any(word.strip() for word in row):
                yield skip + reader.line_num, row
                row_start = skip + reader.line_num + 1
    except csv.Error as error:
        raise InputError(f"{path}: line {row_start}: {error}; is a quote opened there and never closed?") from None


def _sniff_delimiter(lines: list[str], layout: TableLayout | None) -> str:
    """The delimiter that cuts most lines into the same number of cells, the heads among them."""
    lines = [line for line in lines if line.strip()]
    if layout and layout.skip_lines and len(lines) > layout.skip_lines:
        lines = lines[layout.skip_lines :]
    if not lines:
        return ","
    body = lines[len(lines) // 3 :]
    best, score = ",", 0.0
    for candidate in (";", "\t", "|", ",", " "):
        counts = [len(line.split()) if candidate == " " else len(next(csv.reader([line], delimiter=candidate), []))
                  for line in body]  # fmt: skip
        usual = max(set(counts), key=counts.count)
        if usual < 2:
            continue
        share = counts.count(usual) / len(counts)
        first = len(lines[0].split()) if candidate == " " else lines[0].count(candidate) + 1
        fits = share + (0.5 if first == usual else 0.0) - (0.4 if candidate == " " else 0.0)
        if fits > score + 1e-9:
            best, score = candidate, fits
    return best


def _top_rows(path: Path, encoding: str, delimiter: str) -> list[tuple[int, list[str]]]:
    body = cells_of_lines(path, _lines(path, encoding), delimiter, 0)
    try:
        return list(itertools.islice(body, _SNIFFED_LINES))
    except InputError:
        # A quote that is never closed within the first rows: take what can be read; reading on reports it.
        body = cells_of_lines(path, _lines(path, encoding), delimiter, 0)
        rows = []
        for row in body:
            rows.append(row)
            if len(rows) == 1:
                break
        return rows


def _heads_row(
    rows: list[tuple[int, list[str]]], layout: TableLayout | None, skip: int | None
) -> tuple[tuple[int, list[str]], bool]:
    """The row of the heads, with its line; and whether it is one, not the first row of a table without heads."""
    if layout and layout.names:
        after = [row for row in rows if row[0] > (skip or 0)]
        return (after or rows)[0], False
    if skip is not None:
        return next((row for row in rows if row[0] > skip), rows[-1]), True
    if layout:
        wanted = layout.time.column
        for row in rows:
            if wanted in [cell.strip() for cell in row[1]]:
                return row, True
        return rows[0], True
    usual = max((sum(bool(cell.strip()) for cell in cells) for _, cells in rows), default=1)
    for row in rows:
        words = [word for cell in row[1] if (word := cell.strip())]
        named = [word for word in words if not _NUMBER.fullmatch(word) and not _CLOCK.search(word)]
        if 2 * len(words) > usual and len(words) >= min(usual, 2) and len(named) >= max(len(words) - 1, 1):
            return row, True
        if sum(bool(_NUMBER.fullmatch(word)) for word in words) > len(words) / 2:
            return row, False  # numbers before any heads
    return rows[0], True


def _is_unit_row(row: list[str]) -> bool:
    words = [cell.strip() for cell in row if cell.strip()]
    numeric = any(_NUMBER.fullmatch(word) or _CLOCK.search(word) for word in words)
    if numeric or not words or all(word.lower() in NULL_WORDS for word in words):
        return False
    known = sum(any(unit_factor(word, kind) is not None for kind in KINDS) for word in words)
    return known >= max(1, len(words) // 3)
