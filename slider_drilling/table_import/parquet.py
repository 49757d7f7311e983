"""Parquet files: columns keep their types; pandas' index is a column like the others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.table_import.optional import library
from slider_drilling.table_import.source import Cells, Heads, Table, TableInMemory, distinct


def open_parquet(path: Path) -> TableInMemory:
    """The table of a Parquet file. Raises InputError where it cannot be read."""
    pyarrow = library("pyarrow", path, "a Parquet file")
    parquet = library("pyarrow.parquet", path, "a Parquet file")
    try:
        table = parquet.read_table(path)
    except (pyarrow.ArrowException, OSError) as error:
        raise InputError(f"{path}: cannot read this Parquet file: {' '.join(str(error).split())[:200]}") from None
    names = distinct(table.column_names)
    columns = {name: _cells(table.column(place), pyarrow) for place, name in enumerate(names)}
    units = tuple(_unit(table.schema.field(place)) for place in range(len(names)))
    rows = np.arange(table.num_rows, dtype=np.int64)
    return TableInMemory(Heads(names, units), Table(printable(str(path)), columns, rows))


def _unit(field: Any) -> str:
    """The unit in a column's metadata; empty where it has none."""
    metadata = field.metadata or {}
    return next(
        (metadata[key].decode("utf-8", "replace") for key in (b"unit", b"units", b"uom") if key in metadata), ""
    )


def _cells(column: Any, pyarrow: Any) -> Cells:
    kind = column.type
    if pyarrow.types.is_timestamp(kind) or pyarrow.types.is_date(kind):
        return np.asarray(column.cast(pyarrow.timestamp("ns")).to_numpy(), dtype="datetime64[ns]")
    if pyarrow.types.is_floating(kind) or pyarrow.types.is_integer(kind) or pyarrow.types.is_decimal(kind):
        return np.asarray(column.cast(pyarrow.float64(), safe=False).to_numpy(), dtype=np.float64)
    return ["" if value is None else str(value) for value in column.to_pylist()]
