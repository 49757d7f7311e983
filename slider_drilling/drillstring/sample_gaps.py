"""Gaps between samples: where a recorder lost some."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array

_LOST_INTERVALS = 3.0  # samples were lost where two are this many median intervals apart


def gap_indices(time: Array) -> NDArray[np.int_]:
    """Indices of the samples (n,) after which some were lost."""
    steps = np.diff(time)
    return np.flatnonzero(steps > _LOST_INTERVALS * np.median(steps)) if steps.size else np.empty(0, dtype=int)


def in_gap(time: Array, others: Array) -> NDArray[np.bool_]:
    """(m,) whether each of other times lies where samples at ``time`` (n,) were lost."""
    cell = np.searchsorted(time, others, side="right") - 1
    return np.asarray(np.isin(cell, gap_indices(time)) & ~np.isin(others, time))


def times_in_gaps(time: Array, others: Array) -> Array:
    """Those of other times (m,) that lie where samples at ``time`` (n,) were lost."""
    return np.asarray(others[in_gap(time, others)], dtype=np.float64)
