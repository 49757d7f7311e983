"""Arrays of many rigs in one: a row for each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from slider_drilling.drillstring.kernel_arrays import Array, aligned

_LINE = 8  # doubles in a cache line


def stack_rows(rows: Sequence[Array], above: int = 0) -> Array:
    """Rows of one length or several in one array (rows, width); each row begins a cache line.

    Args:
        rows: At least one.
        above: Index within a row that begins the cache line, for arrays with rows before that of the first element.
    """
    longest = max(1, *(row.size for row in rows))
    width = -(-longest // _LINE) * _LINE
    stacked = np.zeros((len(rows), width))
    for index, row in enumerate(rows):
        stacked[index, : row.size] = row
    return aligned(stacked.ravel(), above).reshape(len(rows), width)


def stack_fields(kind: Any, rows: Sequence[Any], above: Sequence[str] = ()) -> Any:
    """Named tuples of arrays, one a rig, as one of arrays (rigs, ...).

    Args:
        kind: The tuple's class.
        rows: The tuples.
        above: Fields with one row before that of the first element. Arrays of one value a rig stay (rigs, 1).
    """
    stacked = {}
    for name in kind._fields:
        values = [np.atleast_1d(getattr(row, name)) for row in rows]
        small = all(value.size <= 2 for value in values) and len({value.size for value in values}) == 1
        stacked[name] = np.stack(values) if small else stack_rows(values, 1 if name in above else 0)
    return kind(**stacked)
