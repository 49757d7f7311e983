"""WITSML time logs from a file: log objects of 1.3.1.1 and 1.4.1.1, channel sets of 2.0 and 2.1.

Read with lxml, without the packages of generated classes (komle-plus, energyml-witsml): these need a package for each
version of the schema and refuse files that break it in a detail, as files of servers and recorders do.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.table_import.numbers import NULL_WORDS
from slider_drilling.table_import.optional import library
from slider_drilling.table_import.source import Cells, Heads, Table, TableInMemory, distinct


def open_witsml(path: Path) -> TableInMemory:
    """The first time log of a file. Raises InputError where it is no XML, or holds none."""
    etree = library("lxml.etree", path, "WITSML")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=True, remove_comments=True)
    try:
        root = etree.parse(str(path), parser).getroot()
    except (etree.XMLSyntaxError, OSError) as error:
        raise InputError(f"{path}: cannot read this XML: {' '.join(str(error).split())[:200]}") from None
    for element in root.iter():
        name = _name(element)
        if name == "log" and _child(element, "logData") is not None:
            return _log_object(element, path)
        if name == "ChannelSet" and _child(element, "Data") is not None:
            return _channel_set(element, path)
    raise InputError(f"{path}: holds no WITSML log with data (log/logData, or ChannelSet/Data)")


def _name(element: Any) -> str:
    tag = element.tag
    return tag.rpartition("}")[2] if isinstance(tag, str) else ""


def _children(element: Any, name: str) -> list[Any]:
    return [child for child in element if _name(child) == name]


def _child(element: Any, name: str) -> Any:
    return next(iter(_children(element, name)), None)


def _text(element: Any, name: str) -> str:
    """The text of a child; empty where there is none."""
    child = None if element is None else _child(element, name)
    return "" if child is None or child.text is None else child.text.strip()


def _log_object(log: Any, path: Path) -> TableInMemory:
    """A log object: mnemonicList, unitList and rows of comma-separated data."""
    kind = _text(log, "indexType").lower()
    if kind and "time" not in kind:
        raise InputError(f"{path}: is a log by {kind}; an import needs one by time")
    infos = {_text(info, "mnemonic") or info.get("uid", ""): info for info in _children(log, "logCurveInfo")}
    data = _children(log, "logData")
    listed = _text(data[0], "mnemonicList")
    names = [name.strip() for name in listed.split(",")] if listed else list(infos)
    units = [unit.strip() for unit in _text(data[0], "unitList").split(",")] if _text(data[0], "unitList") else [
        _text(infos.get(name), "unit") for name in names]  # fmt: skip
    nulls = {_text(log, "nullValue"), *(_text(info, "nullValue") for info in infos.values())}
    rows = [(row.text or "").split(",") for part in data for row in _children(part, "data")]
    return _table(names, units, nulls, rows, path)


def _channel_set(channels: Any, path: Path) -> TableInMemory:
    """A channel set: rows of [[index], [values]] as JSON."""
    indices = _children(channels, "Index")
    members = _children(channels, "Channel")
    if indices and "time" not in (_text(indices[0], "IndexKind") or _text(indices[0], "IndexType") or "time").lower():
        raise InputError(f"{path}: is a channel set by depth; an import needs one by time")
    names = [_text(part, "Mnemonic") for part in (*indices, *members)]
    units = [_text(part, "Uom") or _text(part, "UoM") for part in (*indices, *members)]
    data = _child(channels, "Data")
    written = _text(data, "Data") or (data.text or "").strip()
    try:
        rows = [_flat(row) for row in json.loads(written)]
    except (ValueError, TypeError, RecursionError):
        raise InputError(f"{path}: the channel set's Data is not rows of [[index], [values]]") from None
    return _table(names, units, {_text(part, "NullValue") for part in members}, rows, path)


def _flat(row: Any) -> list[str]:
    """One row without its brackets; a value with attributes is a list, whose first entry counts."""
    index, values = row[0], row[1] if len(row) > 1 else []
    cells = [*index, *(value[0] if isinstance(value, list) and value else value for value in values)]
    return ["" if cell is None or isinstance(cell, (list, dict)) else str(cell) for cell in cells]


def _table(names: list[str], units: list[str], nulls: set[str], rows: list[list[str]], path: Path) -> TableInMemory:
    width = len(names)
    if not rows or not width:
        raise InputError(f"{path}: its log has no rows of data")
    wide = next((place for place, row in enumerate(rows) if len(row) != width), None)
    if wide is not None:
        raise InputError(f"{path}: data row {wide}: {len(rows[wide])} values where {width} mnemonics are named")
    plain = distinct(names)
    columns: dict[str, Cells] = {name: [row[place].strip() for row in rows] for place, name in enumerate(plain)}
    shown = tuple("" if unit.lower() in NULL_WORDS or unit.lower() == "unitless" else unit for unit in units)
    numbers = []
    for text in nulls:
        try:
            numbers.append(float(text))
        except ValueError:
            continue
    heads = Heads(plain, (shown + ("",) * width)[:width], tuple(sorted(numbers)))
    return TableInMemory(heads, Table(printable(str(path)), columns, np.arange(len(rows), dtype=np.int64)))
