"""Empty tables to fill in: survey, tally, sheet and motor, as CSV files and as one XLSX book."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import write_atomically
from slider_drilling.rig_papers.sheet import SHEET_KEYS

Rows = Sequence[Sequence[str]]
_LENGTH = {"field": "ft", "si": "m"}
_SIZE = {"field": "in", "si": "mm"}
_WEIGHT = {"field": "lb/ft", "si": "N/m"}
_TORQUE = {"field": "ft-lbf", "si": "kN.m"}
BOOK = "rig_papers.xlsx"
_SI_EXAMPLES = {
    "mud": "1150 kg/m3 OBM", "motor": "13.5 L/rev, 8.9 kN.m @ 76 bar, stall 13.4 kN.m", "pump": "15.9 L/stk",
    "top_drive": "61 kN.m, 180 rpm", "circulating_pressure": "207 bar @ 1890 L/min", "bit": "216 mm PDC",
    "hole_diameter": "216 mm", "casing_shoe": "1890 m", "make_up_torque": "36 kN.m",
}  # fmt: skip


def template_tables(units: str) -> dict[str, Rows]:
    """Name -> rows of each table, with its heads; units: "field" or "si"."""
    length, size, weight, torque = (table[units] for table in (_LENGTH, _SIZE, _WEIGHT, _TORQUE))
    tally = ("Description", f"Length [{length}]", f"OD [{size}]", f"ID [{size}]", f"Weight [{weight}]",
             f"TJ OD [{size}]", f"TJ ID [{size}]", f"Make-up torque [{torque}]")  # fmt: skip
    sheet = [("key", "value", "what it is", "example")]
    for key in SHEET_KEYS:
        example = _SI_EXAMPLES.get(key.name, key.example) if units == "si" else key.example
        sheet.append((key.name, "", f"{key.question}{'' if key.required else ' (may stay empty)'}", example))
    return {"survey": [(f"MD [{length}]", "Inc [deg]", "Azi [deg]")], "tally": [tally], "sheet": sheet}


def write_templates(folder: Path, units: str) -> list[Path]:
    """Write every table as CSV, and all of them as sheets of one book if openpyxl is installed; returns the paths.

    Raises:
        InputError: A file exists already, or cannot be written.
    """
    tables = template_tables(units)
    files = {folder / f"{name}.csv": _csv(rows) for name, rows in tables.items()}
    book = _book(tables)
    if book is not None:
        files[folder / BOOK] = book
    for path in files:
        if path.exists():
            raise InputError(f"{path}: exists already, and may be filled in; give another folder")
    for path, content in files.items():
        write_atomically(path, content)
    return list(files)


def _csv(rows: Rows) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


def _book(tables: dict[str, Rows]) -> bytes | None:
    try:
        from openpyxl import Workbook
        from openpyxl.styles import Font
    except ImportError:
        return None
    book = Workbook()
    book.remove(book.active)
    for name, rows in tables.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(list(row))
        for index, head in enumerate(rows[0], start=1):
            sheet.cell(1, index).font = Font(bold=True)
            widest = max(len(row[index - 1]) for row in rows)
            sheet.column_dimensions[sheet.cell(1, index).column_letter].width = min(max(widest, len(head)) + 3, 70)
        sheet.freeze_panes = "A2"
    content = io.BytesIO()
    book.save(content)
    return content.getvalue()
