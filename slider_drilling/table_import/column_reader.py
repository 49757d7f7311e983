"""The columns of a table as numbers, each read once."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.null_values import nulls_of_other_columns
from slider_drilling.table_import.doubtful import check_points
from slider_drilling.table_import.findings import Findings
from slider_drilling.table_import.mapping import AUTO, TableLayout
from slider_drilling.table_import.numbers import Numbers, numbers
from slider_drilling.table_import.source import Array, Table


@dataclass
class ColumnReader:
    """Reads columns, and knows which were read and how.

    Attributes:
        table: The table.
        layout: Its format.
        nulls: Numbers that mean no value.
        delimiter: Between the cells of a text, empty for other tables.
        columns: What was read so far, by name.
    """

    table: Table
    layout: TableLayout
    nulls: tuple[float, ...]
    delimiter: str = ""
    columns: dict[str, Numbers] = field(default_factory=dict, init=False)

    def values(self, name: str, positive: bool = False) -> Array:
        """A column as numbers; positive: whether the quantity cannot be negative. Raises InputError."""
        if name not in self.columns:
            table = without_words(self.table, name, self.layout.null_words)
            self.columns[name] = numbers(table, name, self.nulls, self.layout.decimal, positive, self.delimiter)
        return self.columns[name].values

    def share_nulls(self, names: Collection[str]) -> None:
        """Take undeclared nulls of one of these columns for nulls of the others, too. They were read before."""
        read = {name: self.columns[name] for name in names}
        found = {name: [null for null, _ in column.undeclared] for name, column in read.items()}
        written = {name: column.written for name, column in read.items()}
        for name, nulls in nulls_of_other_columns(written, found).items():
            self.columns[name] = self.columns[name].without(nulls)

    def note(self, found: Findings) -> None:
        """Tell which nulls were not declared, and which marks were read. Raises InputError for doubtful points."""
        columns = self.columns
        if self.layout.decimal == AUTO and any(column.comma for column in columns.values()):
            table = self.table
            for name in columns:
                table = without_words(table, name, self.layout.null_words)
            check_points(table, list(columns))
        for name, column in columns.items():
            for null, count in column.undeclared:
                times = "once" if count == 1 else f"{count} times"
                found.add(
                    "nulls",
                    f"{name!r}: {null:g}, {times}, is no value of a rig: taken as null; declare it in null_values",
                )
        if any(column.comma for column in columns.values()):
            found.add("table", "commas are read as decimal marks")
        if any(column.thousands for column in columns.values()):
            found.add("table", "marks between thousands are left out")


def without_words(table: Table, name: str, words: tuple[str, ...]) -> Table:
    """A table with cells of one column empty where they hold one of these words."""
    cells = table.columns[name]
    if not words or isinstance(cells, np.ndarray):
        return table
    lower = {word.strip().lower() for word in words}
    cleaned = ["" if str(cell).strip().lower() in lower else str(cell) for cell in cells]
    return replace(table, columns={**table.columns, name: cleaned})
