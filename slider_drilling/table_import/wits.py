"""WITS level 0: records between && and !! of lines with record number, item number and value.

Source of the items and their units: WITS specification, record 1 (general, time-based) and record 7 (survey and
directional). The format does not tell which of its two sets of units is used.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_lines
from slider_drilling.table_import.source import Cells, Heads, Table, TableInMemory

TIME = "TIME"
# Item -> mnemonic, metric unit, field unit.
ITEMS = {
    "0108": ("DBTM", "m", "ft"), "0110": ("DMEA", "m", "ft"), "0112": ("BPOS", "m", "ft"),
    "0113": ("ROPA", "m/h", "ft/h"), "0114": ("HKLA", "kdaN", "klbf"), "0115": ("HKLX", "kdaN", "klbf"),
    "0116": ("WOBA", "kdaN", "klbf"), "0117": ("WOBX", "kdaN", "klbf"), "0118": ("TQA", "kN m", "kft lbf"),
    "0119": ("TQX", "kN m", "kft lbf"), "0120": ("RPMA", "rpm", "rpm"), "0121": ("SPPA", "kPa", "psi"),
    "0122": ("CHKP", "kPa", "psi"), "0123": ("SPM1", "spm", "spm"), "0124": ("SPM2", "spm", "spm"),
    "0125": ("SPM3", "spm", "spm"), "0129": ("MFOA", "L/min", "gpm"), "0130": ("MFIA", "L/min", "gpm"),
    "0716": ("SMTF", "deg", "deg"), "0717": ("SGTF", "deg", "deg"),
}  # fmt: skip
_DATE, _CLOCK = "05", "06"  # items of every record
_ITEM = re.compile(r"(\d{2})(\d{2})(.*)")
_NULLS = (-9999.0, -8888.0)


def open_wits(path: Path, units: str) -> TableInMemory:
    """The table of a WITS file; a row for each record. Raises InputError where the units are not given."""
    return wits_table(_records(path), printable(str(path)), units)


def wits_table(records: list[tuple[int, dict[str, str]]], source: str, units: str) -> TableInMemory:
    """The table of some records; a row for each.

    Args:
        records: Line on which each begins, and its values by item.
        source: Where they come from, for messages.
        units: "field" or "metric".

    Raises:
        InputError: No item is known, the units are not given, or no record has a time.
    """
    held = [item for item in ITEMS if any(item in record for _, record in records)]
    if not held:
        raise InputError(f"{source}: holds none of the items {', '.join(ITEMS)}")
    unsure = [ITEMS[item][0] for item in held if ITEMS[item][1] != ITEMS[item][2]]
    if unsure and not units:
        raise InputError(
            f"{source}: WITS does not tell the units of {', '.join(unsure)}; add --wits-units field (klbf, psi, "
            "kft lbf, ft) or --wits-units metric (kdaN, kPa, kN m, m)"
        )
    which = 2 if units == "field" else 1
    columns: dict[str, Cells] = {ITEMS[item][0]: [record.get(item, "") for _, record in records] for item in held}
    times = [_stamp(record) for _, record in records]
    if not any(times):
        raise InputError(f"{source}: its records have no date and time (items 05 and 06)")
    heads = Heads((TIME, *columns), ("", *(ITEMS[item][which] for item in held)), _NULLS, "YMD")
    lines = np.array([line for line, _ in records], dtype=np.int64)
    return TableInMemory(heads, Table(source, {TIME: times, **columns}, lines, "line"))


def _records(path: Path) -> list[tuple[int, dict[str, str]]]:
    """Items of each record, and the line that it begins on. Lines between records are left out."""
    records = list(iterate_records(read_lines(path, "WITS file", "latin-1")))
    if not records:
        raise InputError(f"{path}: holds no whole WITS record (&& to !!)")
    return records


def iterate_records(lines: Iterable[str]) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield the line on which each whole record begins, and its values by item."""
    current: dict[str, str] | None = None
    start = 0
    for number, raw in enumerate(lines, 1):
        line = raw.strip("\x00\x02\x03 \r\n")
        if line == "&&":
            current, start = {}, number
        elif line == "!!":
            if current:
                yield start, current
            current = None
        elif current is not None and (match := _ITEM.fullmatch(line)) is not None:
            current[match[1] + match[2]] = match[3].strip()


def is_usable(record: dict[str, str]) -> bool:
    """Whether a record has a time and a value of a known item; streams hold records of other kinds, too."""
    return any(record.get(item) for item in ITEMS) and bool(_stamp(record))


def _stamp(record: dict[str, str]) -> str:
    """Date and time of a record as text; empty where it has none. Dates are YYMMDD, times HHMMSS."""
    number = next(iter(record))[:2]
    date, clock = record.get(number + _DATE, ""), record.get(number + _CLOCK, "")
    date = re.sub(r"\D", "", date.split(".")[0]).zfill(6) if date else ""
    clock = re.sub(r"\D", "", clock.split(".")[0]).zfill(6) if clock else ""
    if len(clock) != 6 or len(date) != 6:
        return ""
    try:
        moment = datetime.datetime.strptime(date + clock, "%y%m%d%H%M%S")
    except ValueError:
        return ""
    return moment.isoformat()
