"""LAS 2 and 3 files with logs by time.

lasio reads the header; the rows may hold dates and LAS 3 delimiters, which it does not keep apart.
"""

from __future__ import annotations

import io
import itertools
import logging
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.table_import.optional import library
from slider_drilling.table_import.source import Cells, Heads, Table, TableInMemory, distinct

_DATA = re.compile(r"^\s*~\s*(?:A(?!PI)|LOG_DATA|Log_Data)", re.IGNORECASE)
_SECTION = re.compile(r"^\s*~")
_DEFINITION = re.compile(r"^\s*~\s*Log_Definition.*$", re.IGNORECASE | re.MULTILINE)
_DELIMITERS = {"COMMA": ",", "TAB": "\t", "SPACE": None}
_DATE_ORDER = re.compile(r"(?=.*D)(?=.*M)(?=.*Y)[DMY]+[^A-Z]+[DMY]+[^A-Z]+[DMY]+", re.IGNORECASE)


def open_las(path: Path) -> TableInMemory:
    """The table of a LAS file. Raises InputError for one by depth, or without curves."""
    text = read_text(path, "LAS file")
    header = _header(text, path)
    curves = list(header.curves)
    if not curves:
        raise InputError(f"{path}: names no curves (~C section)")
    names = distinct([curve.original_mnemonic.strip() or f"column {place}" for place, curve in enumerate(curves, 1)])
    units = [str(curve.unit or "").strip() for curve in curves]
    if names[0].upper() in ("DEPT", "DEPTH", "MD", "TVD") and not any("TIME" in name.upper() for name in names):
        raise InputError(f"{path}: is a log by depth ({names[0]}); an import needs one by time")
    order = next((_order(unit) for unit in units if _DATE_ORDER.match(unit)), "")
    rows, lines = _rows(text, header, len(names), path)
    columns: dict[str, Cells] = {name: [row[place] for row in rows] for place, name in enumerate(names)}
    null = _number(header.well.NULL.value) if "NULL" in header.well else None
    heads = Heads(names, tuple("" if _DATE_ORDER.match(unit) else unit for unit in units),
                  () if null is None else (null,), order)  # fmt: skip
    return TableInMemory(heads, Table(printable(str(path)), columns, np.array(lines, dtype=np.int64), "line"))


def _header(text: str, path: Path) -> Any:
    """The header as lasio reads it. Raises InputError where it cannot."""
    lasio = library("lasio", path, "a LAS file")
    logging.getLogger("lasio").setLevel(logging.CRITICAL)
    lines = list(itertools.takewhile(lambda line: not _DATA.match(line), text.splitlines()))
    plain = _DEFINITION.sub("~Curve", "\n".join(lines)) + "\n~A\n"
    try:
        return lasio.read(io.StringIO(plain), ignore_data=True, ignore_header_errors=True, mnemonic_case="preserve")
    except Exception as error:  # lasio raises many kinds for a header that is none
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"{path}: cannot read this LAS file's header: {reason}") from None


def _rows(text: str, header: Any, width: int, path: Path) -> tuple[list[list[str]], list[int]]:
    """Cells of each row, and the line that each ends on."""
    mark = str(header.version.DLM.value).strip().upper() if "DLM" in header.version else "SPACE"
    delimiter = _DELIMITERS.get(mark)
    is_wrapped = "WRAP" in header.version and str(header.version.WRAP.value).strip().upper() == "YES"
    rows: list[list[str]] = []
    lines: list[int] = []
    pending: list[str] = []
    for line, cells in _data_lines(text, delimiter):
        pending = [*pending, *cells] if is_wrapped else cells
        if is_wrapped and len(pending) < width:
            continue
        if len(pending) == width + 1 and re.search(r"\d[-/]\w+[-/]\d", pending[0]) and ":" in pending[1]:
            pending = [f"{pending[0]} {pending[1]}", *pending[2:]]  # a date and time in one curve
        if len(pending) != width:
            raise InputError(f"{path}: line {line}: {len(pending)} values where {width} curves are named")
        rows.append(pending)
        lines.append(line)
        pending = []
    if not rows:
        raise InputError(f"{path}: has no rows of numbers")
    return rows, lines


def _data_lines(text: str, delimiter: str | None) -> Iterator[tuple[int, list[str]]]:
    """The cells of each line of the first section of data."""
    inside = False
    for number, line in enumerate(text.splitlines(), 1):
        if _SECTION.match(line):
            if inside:
                return
            inside = _DATA.match(line) is not None
        elif inside and line.strip() and not line.lstrip().startswith("#"):
            yield number, [cell.strip().strip('"') for cell in line.split(delimiter)]


def _order(unit: str) -> str:
    letters = re.sub(r"[^DMY]", "", unit.upper().split("H")[0])
    order = "".join(dict.fromkeys(letters))
    return order if order in ("DMY", "MDY", "YMD") else ""


def _number(value: Any) -> float | None:
    try:
        return float(value)
    except (TypeError, ValueError):
        return None
