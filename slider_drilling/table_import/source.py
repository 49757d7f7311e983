"""What every format of a table gives: heads, units and columns, before any of it is a channel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError

Array = NDArray[np.float64]
# Text as it stands in the file, numbers, or ns since the epoch (numpy datetime64[ns]).
Cells = Sequence[str] | Array | NDArray[np.datetime64]


@dataclass(frozen=True)
class Heads:
    """The columns that a table has.

    Attributes:
        names: One name each; of equal names all but the first get a number, "RPM (2)".
        units: One each, as the table writes it; empty where it gives none.
        nulls: Numbers that the table itself declares to mean no value.
        date_order: Order of the date's parts that the table declares, "DMY", "MDY" or "YMD"; empty where it does not.
        named: Whether the names are the table's own; numbers of a table without a header line are not.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    nulls: tuple[float, ...] = ()
    date_order: str = ""
    named: bool = True


@dataclass(frozen=True)
class Table:
    """The columns that were asked for.

    Attributes:
        source: The file, for messages.
        columns: Cells of each column by its name, n each.
        rows: Number of each row in the file, (n,).
        row_word: What such a number counts: "line" or "row".
        notes: What was done to read it, one sentence each.
    """

    source: str
    columns: dict[str, Cells]
    rows: NDArray[np.int64]
    row_word: str = "row"
    notes: tuple[str, ...] = ()

    def where(self, index: int) -> str:
        """The place of a row for a message."""
        return f"{self.source}: {self.row_word} {self.rows[index]}"


class TableSource(Protocol):
    """A table of some format that was opened."""

    @property
    def heads(self) -> Heads:
        """Its columns."""

    def sample(self) -> Table:
        """The first rows with all columns."""

    def read(self, names: Sequence[str], rows: tuple[int, int] | None) -> Table:
        """These columns, of these data rows (first and last, from 0) or of all. Raises InputError."""


SAMPLE_ROWS = 200


@dataclass(frozen=True)
class TableInMemory:
    """A table that its reader gives as a whole.

    Attributes:
        heads: Its columns.
        table: All of them.
    """

    heads: Heads
    table: Table

    def sample(self) -> Table:
        """The first rows with all columns."""
        return self._part(self.heads.names, slice(0, SAMPLE_ROWS))

    def read(self, names: Sequence[str], rows: tuple[int, int] | None) -> Table:
        """These columns, of these data rows or of all. Raises InputError where there are no such rows."""
        count = len(self.table.rows)
        if rows is not None and not rows[0] <= rows[1] < count:
            raise InputError(f"{self.table.source}: rows {rows[0]}:{rows[1]}: the table has rows 0 to {count - 1}")
        if not count:
            raise InputError(f"{self.table.source}: has no rows of numbers")
        return self._part(names, slice(None) if rows is None else slice(rows[0], rows[1] + 1))

    def _part(self, names: Sequence[str], part: slice) -> Table:
        columns = {name: self.table.columns[name][part] for name in names}
        return replace(self.table, columns=columns, rows=self.table.rows[part])


def distinct(names: Sequence[str]) -> tuple[str, ...]:
    """Names with a number behind all but the first of equal ones."""
    seen: dict[str, int] = {}
    result = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        result.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return tuple(result)
