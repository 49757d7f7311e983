"""Opens a table by its content: text, LAS, workbook, Parquet, WITSML, WITS."""

from __future__ import annotations

import re
import stat
from collections.abc import Callable
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.table_import.delimited_text import open_text
from slider_drilling.table_import.mapping import TableLayout
from slider_drilling.table_import.source import TableSource

_TOP_BYTES = 8192


def open_table(path: Path, layout: TableLayout | None, wits_units: str = "") -> TableSource:
    """A table of any format that is known.

    Args:
        path: The file.
        layout: What a mapping file says of its format.
        wits_units: Units of WITS, which the format itself does not tell: "field" or "metric".

    Raises:
        InputError: The file cannot be read as a table.
    """
    top = _top(path)
    reader = _reader(top, path, layout, wits_units)
    return reader() if reader is not None else open_text(path, layout)


def _reader(top: bytes, path: Path, layout: TableLayout | None, wits_units: str) -> Callable[[], TableSource] | None:
    """The reader of a binary or marked-up format by its first bytes; None for plain text."""
    sheet = layout.sheet if layout else ""
    if top[:4] == b"PK\x03\x04":
        return lambda: _workbook(path, sheet, layout)
    if top[:8] == b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1":
        raise InputError(f"{path}: is an old Excel workbook (.xls); save it as .xlsx or .csv")
    if top[:4] == b"PAR1":
        return lambda: _parquet(path)
    if top[:1] in (b"{", b"\x89") and not path.suffix.lower().endswith("csv"):
        raise InputError(f"{path}: is no table; give CSV, LAS, XLSX, Parquet, WITSML or WITS")
    text = top.decode("utf-8-sig", errors="replace").lstrip("\x00\ufeff \t\r\n")
    if text.startswith("<") and "<" in text[1:400]:
        return lambda: _witsml(path)
    if text.startswith("&&") and re.match(r"&&\s*[\r\n]+\s*\d{4}", text):
        return lambda: _wits(path, wits_units)
    plain = layout is not None and bool(layout.given & {"names", "skip_lines"})
    if re.match(r"(?:#[^\n]*\n\s*)*~\s*V", text, re.IGNORECASE) and not plain:
        return lambda: _las(path)
    return None


def _top(path: Path) -> bytes:
    """The first bytes of a file; none where it is not a plain file, which reading it reports."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            return b""
        with open(path, "rb") as file:
            return file.read(_TOP_BYTES)
    except (OSError, ValueError):
        return b""


def _workbook(path: Path, sheet: str, layout: TableLayout | None) -> TableSource:
    from slider_drilling.table_import.workbook import open_workbook

    return open_workbook(path, sheet, layout)


def _parquet(path: Path) -> TableSource:
    from slider_drilling.table_import.parquet import open_parquet

    return open_parquet(path)


def _witsml(path: Path) -> TableSource:
    from slider_drilling.table_import.witsml import open_witsml

    return open_witsml(path)


def _wits(path: Path, units: str) -> TableSource:
    from slider_drilling.table_import.wits import open_wits

    return open_wits(path, units)


def _las(path: Path) -> TableSource:
    from slider_drilling.table_import.las import open_las

    return open_las(path)
