"""Numbers as they are rounded in a table."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def equal_as_rounded(
    first_texts: Sequence[str], first: Array, first_unit: float, texts: Sequence[str], other: Array, unit: float
) -> bool:
    """Whether two columns hold the same quantities, as far as the decimals of both show.

    Args:
        first_texts: Cells of one column as they are written, n.
        first: Their numbers, NaN where there is none, (n,).
        first_unit: SI value of its unit.
        texts: Cells of the other column, n.
        other: Their numbers, (n,).
        unit: SI value of its unit.
    """
    if not np.array_equal(np.isnan(first), np.isnan(other)) or np.all(np.isnan(first)):
        return False
    either = 0.5 * (_last_digit(first_texts) * first_unit + _last_digit(texts) * unit)  # each is rounded to its nearest
    apart = np.abs(first * first_unit - other * unit)
    return bool(np.nanmax(apart - 1e-9 * np.abs(other * unit)) <= either)


def _last_digit(texts: Sequence[str]) -> float:
    """What one step of the last digit of a column is worth, in its unit."""
    return 10.0 ** -max((len(match[1]) for text in texts if (match := re.search(r"[.,](\d+)\s*$", text))), default=0)
