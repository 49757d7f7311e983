"""What a rate adds up to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def integral(time: Array, rate: Array) -> Array:
    """(n,) of a rate (n,), a second, over time (n,), s, by trapezoids from zero at the first sample."""
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(time)
    return np.concatenate([[0.0], np.cumsum(steps)])[: rate.size]
