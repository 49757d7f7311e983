"""Numbers that recorders and exporters write where there is no value, although nothing declares them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from slider_drilling.units import KINDS

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Numbers that exporters write for "no value".
_NULL_LIKE = re.compile(r"-?(?:9{3,}(?:\.(?:25|0+|9+))?|3276[78]|65535|2147483647|2147483648|8888+)")
_SPANS = 3.0  # times the range of all other values that an undeclared null lies outside
_MANY = 10.0  # the same for a number that is no usual null
_MIN_REPEATS = 5  # of a number that no exporter is known to write for "no value"
_MAX_NULLS = 4  # different undeclared nulls of one column
_SPANS_IN_TABLE = 0.5  # the same for a number that is an undeclared null of another column
_MAX_SHARE, _MAX_SHARE_ABOVE = 0.5, 0.2  # of the values, for nulls below and above all others


def without_undeclared_nulls(values: Array, positive: bool) -> tuple[Array, tuple[tuple[float, int], ...]]:
    """The values with numbers as NaN that stand far outside all others and look like a null.

    Such a number is one that exporters write (-999.25, -9999, -999, 99999, -32768). Another one must be repeated to the
    last digit and be impossibly large; or stand five times, far from all others, negative where the quantity cannot be.
    """
    found: list[tuple[float, int]] = []
    values = values.copy()
    for _ in range(_MAX_NULLS):
        known = values[np.isfinite(values)]
        if known.size < 3:
            break
        null = next((end for end in (known.min(), known.max()) if _is_null(float(end), known, positive)), None)
        if null is None:
            break
        same = values == null
        found.append((float(null), int(np.count_nonzero(same))))
        values[same] = math.nan
    return values, tuple(found)


def nulls_of_other_columns(columns: Mapping[str, Array], found: Mapping[str, Sequence[float]]) -> dict[str, set[float]]:
    """Undeclared nulls that a column shares with others, although its own values leave them in doubt.

    A null in ft lbf or deg lies near the readings. It is a null where it stands in a row in which the same number is
    the null of another column, or outside all other values of its column.

    Args:
        columns: Each column with its nulls as numbers, (n,).
        found: Nulls of each column that its own values show.
    """
    shared: dict[str, set[float]] = {}
    for null in sorted({null for nulls in found.values() for null in nulls}):
        owners = [name for name in columns if null in found.get(name, ())]
        rows = np.any([columns[name] == null for name in owners], axis=0)
        for name in columns.keys() - owners:
            same = columns[name] == null
            others = columns[name][np.isfinite(columns[name]) & ~same]
            if is_null_of_others(null, same, others, rows) and (np.any(same & rows) or is_null_like(null)):
                shared.setdefault(name, set()).add(null)
    return shared


def is_null_of_others(value: float, same: Mask, others: Array, beside: Mask) -> bool:
    """Whether a null of other columns is one of a column whose own values leave it in doubt.

    Args:
        value: The null in this column.
        same: Where it stands, (n,).
        others: All other values of the column, (m,).
        beside: Where another column has the null, (n,).
    """
    return bool(np.any(same & beside)) or (bool(same.any()) and _lies_outside(value, others))


def _lies_outside(value: float, others: Array) -> bool:
    if others.size < 2:
        return False
    distance, span, _ = _outside(value, others)
    return distance > _SPANS_IN_TABLE * span


def _is_null(value: float, known: Array, positive: bool) -> bool:
    others = known[known != value]
    count = known.size - others.size
    if others.size < 2 or count > (_MAX_SHARE if value < others[0] else _MAX_SHARE_ABOVE) * known.size:
        return False
    if is_null_like(value):
        return stands_apart(value, others, positive)
    distance, span, high = _outside(value, others)
    if count < 2 or distance <= _MANY * span:
        return False
    if abs(value) > 1e5 * abs(high):
        return True
    # A pressure of -1 is what a sensor with an offset reads of nothing. It is a null where it stands often, to the last
    # digit, and nothing ever comes near it.
    alone = bool(np.abs(others - value).min() > 0.5 * distance)
    return positive and value < 0.0 and count >= _MIN_REPEATS and alone


def _outside(value: float, others: Array) -> tuple[float, float, float]:
    """How far a number lies outside the range of all others, that range, and its upper end."""
    low, high = (float(end) for end in np.quantile(others, (0.01, 0.99)))
    return max(low - value, value - high), max(high - low, 1e-9), high


def stands_apart(value: float, others: Array, positive: bool) -> bool:
    """Whether a number lies far outside all others, or is negative where the quantity cannot be."""
    distance, span, _ = _outside(value, others)
    return distance > _SPANS * span or (positive and value < 0.0)


def is_null_like(value: float) -> bool:
    """Whether exporters write this number for "no value"."""
    return _NULL_LIKE.fullmatch(f"{value:.10g}") is not None or abs(value) >= 1e29


def null_in_some_unit(value: float, unit: str) -> tuple[float, str] | None:
    """The null and its unit that give a value in SI; None where none does."""
    kinds = [units for units in KINDS.values() if next(iter(units)) == unit] or [{unit: 1.0}]
    for units in kinds:
        for name, factor in units.items():
            if factor > 0.0 and is_null_like(value / factor):
                return float(f"{value / factor:.10g}"), name
    return None
