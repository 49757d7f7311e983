"""Gaps between samples, where a recorder lost some."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array

_GAP_INTERVALS = 3.0  # two samples are a gap apart where more than this many median intervals lie between them


def gap_indices(time: Array) -> NDArray[np.int_]:
    """Indices of the samples (n,) that a gap follows."""
    steps = np.diff(time)
    return np.flatnonzero(steps > _GAP_INTERVALS * np.median(steps)) if steps.size else np.empty(0, dtype=int)


def in_gap(time: Array, others: Array) -> NDArray[np.bool_]:
    """Whether each of other times (m,) lies in a gap of the samples at ``time`` (n,)."""
    cell = np.searchsorted(time, others, side="right") - 1
    return np.asarray(np.isin(cell, gap_indices(time)) & ~np.isin(others, time))


def times_in_gaps(time: Array, others: Array) -> Array:
    """Those of other times (m,) that lie in a gap of the samples at ``time`` (n,)."""
    return np.asarray(others[in_gap(time, others)], dtype=np.float64)
