"""Cells of a table as numbers: nulls in words, declared and undeclared nulls, decimal commas."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.null_values import without_undeclared_nulls
from slider_drilling.schema.yaml_tree import shorten
from slider_drilling.table_import.source import Array, Cells, Table

# What recorders, spreadsheets and historians write where there is no value, in lower case.
NULL_WORDS = frozenset({
    "", "-", "--", "---", "----", "nan", "null", "none", "nil", "n/a", "na", "#n/a", "#na", "#n/d", "#null!", "#value!",
    "#ref!", "#div/0!", "#num!", "#name?", "bad", "bad input", "bad data", "no data", "nodata", "no value", "missing",
    "invalid", "offline", "i/o timeout", "shutdown", "not connect", "configure", "pt created", "absent", "inf", "-inf",
    "*", "?", ".",
})  # fmt: skip
_COMMA = re.compile(r"[+-]?\d{1,3}(?:[. ']?\d{3})*,\d+|[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
_GROUPING = re.compile(r"[.' \u00a0\u202f]")
# A number with points that may part thousands, as a table with decimal commas writes it.
POINT_GROUPS = re.compile(r"[+-]?[1-9]\d{0,2}(?:\.\d{3})+")
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[,' \u00a0\u202f]\d{3})+(?:\.\d*)?")
# A number with commas that part thousands, or whose comma is a decimal mark before three digits.
_COMMA_GROUPS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+")
# A line with a number whose one comma can only be a decimal mark; the same for a point.
_SURE_COMMA, _SURE_POINT = (
    re.compile(
        rf"^[ \t]*[+-]?(?:0?[{mark}]\d+|\d+[{mark}](?!\d{{3}}[ \t]*$)\d+|\d{{4,}}[{mark}]\d+"
        rf"|\d{{1,3}}(?:[{other}' ]\d{{3}})+[{mark}]\d+|\d{{1,3}}(?:[{other}]\d{{3}}){{2,}})[ \t]*$",
        re.MULTILINE,
    )
    for mark, other in ((",", "."), (".", ","))
)


@dataclass(frozen=True)
class Numbers:
    """One column as numbers.

    Attributes:
        values: NaN where there is none, (n,).
        undeclared: Numbers that were taken for nulls although nothing declares them, with how often each stands.
        written: The values with undeclared nulls as they are written, (n,).
        comma: Whether commas were read as decimal marks.
        thousands: Whether commas or blanks were left out as marks of thousands.
    """

    values: Array
    written: Array
    undeclared: tuple[tuple[float, int], ...] = ()
    comma: bool = False
    thousands: bool = False

    def without(self, nulls: Iterable[float]) -> Numbers:
        """The column with more undeclared nulls."""
        counts = tuple((null, int(np.count_nonzero(self.written == null))) for null in sorted(nulls))
        values = np.where(np.isin(self.written, [null for null, _ in counts]), math.nan, self.values)
        return replace(self, values=values, undeclared=(*self.undeclared, *counts))


def numbers(
    table: Table, name: str, nulls: tuple[float, ...], decimal: str, positive: bool = False, delimiter: str = ""
) -> Numbers:
    """One column as numbers.

    Args:
        table: The table.
        name: Of the column.
        nulls: Declared nulls.
        decimal: "." or ",", or "auto" where the cells decide.
        positive: Whether the quantity cannot be negative.
        delimiter: Between cells, which decides between decimal comma and marks of thousands.

    Raises:
        InputError: A cell is no number and no null.
    """
    cells = table.columns[name]
    if isinstance(cells, np.ndarray):
        values, comma, thousands = np.array(cells, dtype=np.float64), False, False
    else:
        values, comma, thousands = _from_text(table, name, nulls, decimal, delimiter)
    values[np.isin(values, nulls) | np.isinf(values)] = math.nan
    known, undeclared = without_undeclared_nulls(values, positive)
    return Numbers(known, values, undeclared, comma, thousands)


def _from_text(
    table: Table, name: str, nulls: tuple[float, ...], decimal: str, delimiter: str
) -> tuple[Array, bool, bool]:
    cells: list[str] = list(table.columns[name])
    if any("_" in cell for cell in cells):
        _refuse_underscores(table, name, cells)
    if decimal != ",":
        try:
            return np.array([float(cell) if cell else math.nan for cell in cells]), False, False
        except ValueError:
            pass
    comma, thousands = _marks(table, name, nulls, decimal, delimiter)
    if comma and not _GROUPING.search("".join(cells)):
        try:
            return np.array([float(cell.replace(",", ".")) if cell else math.nan for cell in cells]), True, False
        except ValueError:
            pass
    values = np.empty(len(cells))
    for index, cell in enumerate(cells):
        word = cell.strip()
        if word.lower() in NULL_WORDS:
            values[index] = math.nan
            continue
        if decimal == "," and POINT_GROUPS.fullmatch(word):
            word = word.replace(".", "")
        elif comma:
            word = re.sub(r"[.' \u202f](?=\d{3})", "", word).replace(",", ".") if "," in word else word
        elif thousands and _THOUSANDS.fullmatch(word):
            word = re.sub(r"[,' \u00a0\u202f]", "", word)
        try:
            values[index] = float(word)
        except ValueError:
            raise _not_a_number(table, name, index, cell) from None
    return values, comma, thousands


def _refuse_underscores(table: Table, name: str, cells: list[str]) -> None:
    """Raise InputError for a cell that Python reads as a number, and nobody else: 8_1."""
    for index, cell in enumerate(cells):
        if "_" in cell and re.fullmatch(r"[\d_.,eE+-]+", cell.strip()):
            raise _not_a_number(table, name, index, cell)


def _not_a_number(table: Table, name: str, index: int, cell: str) -> InputError:
    return InputError(
        f"{table.where(index)}: column {name!r} = {shorten(cell)}: not a number; a null in words goes into null_words"
    )


def _marks(table: Table, name: str, nulls: tuple[float, ...], decimal: str, delimiter: str) -> tuple[bool, bool]:
    """Whether commas are decimal marks, and whether there are marks of thousands. Raises InputError where both fit."""
    if decimal == ",":
        return True, False
    cells = [str(cell) for cell in table.columns[name]]
    odd = [cell.strip() for cell in cells if "," in cell or " " in cell.strip() or "'" in cell or "\u00a0" in cell]
    if decimal != ".":
        commas = [word for word in odd if "," in word and _COMMA.fullmatch(word)]
        if any(not _COMMA_GROUPS.fullmatch(word) for word in commas):
            return True, False
        if commas:
            comma = _commas_are_decimal(table, name, nulls, delimiter)
            return comma, not comma
    return False, any(_THOUSANDS.fullmatch(word) for word in odd)


def _commas_are_decimal(table: Table, name: str, nulls: tuple[float, ...], delimiter: str) -> bool:
    """Whether the commas of a column such as 8,125 are decimal marks: other cells of the table tell.

    Where none does, 8,125 between semicolons is 8.125, and in quotes between commas it is eight thousand.

    Raises:
        InputError: Nothing tells.
    """
    comma = any(_has_mark(cells, _SURE_COMMA, nulls) for cells in table.columns.values())
    point = any(_has_mark(cells, _SURE_POINT, nulls) for cells in table.columns.values())
    if comma != point:
        return comma
    if not comma and delimiter in (";", ",", ""):
        return delimiter == ";"
    cells = [str(cell).strip() for cell in table.columns[name]]
    index = next(index for index, cell in enumerate(cells) if _COMMA_GROUPS.fullmatch(cell))
    raise InputError(
        f"{table.where(index)}: column {name!r} = {shorten(cells[index])}: is its comma a decimal mark or a mark of "
        "thousands? set decimal in the mapping file ('.' for thousands)"
    )


def _has_mark(cells: Cells, sure: re.Pattern[str], nulls: tuple[float, ...]) -> bool:
    """Whether a column holds a number, and no declared null, in which a mark can only be the decimal one."""
    if isinstance(cells, np.ndarray):
        return False
    found = (re.sub("[' ]", "", match[0]) for match in sure.finditer("\n".join(map(str, cells))))
    return any(len(re.findall("[.,]", word)) > 1 or float(word.replace(",", ".")) not in nulls for word in found)


def runs(where: NDArray[np.bool_]) -> int:
    """Number of stretches in a row that are true."""
    return int(np.count_nonzero(np.diff(np.r_[False, where].astype(np.int8)) == 1))
