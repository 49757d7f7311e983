"""The gap live: RMS of measured minus expected over the last seconds, in noise levels."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from slider_drilling.twin.samples import Array

WINDOWS_S = (10.0, 60.0, 300.0)


class RunningGap:
    """Sums of squared innovations of one channel, a second each.

    Args:
        noise: Standard deviation of the noise.
    """

    def __init__(self, noise: float) -> None:
        self.noise = noise
        self._sums: deque[tuple[float, float, int]] = deque()

    def add(self, end: float, innovation: Array) -> None:
        """Take innovations (n,) of the second that ends at `end`, s; NaN are left out."""
        known = innovation[np.isfinite(innovation)]
        if known.size:
            self._sums.append((end, float(known @ known) / self.noise**2, known.size))
        while self._sums and self._sums[0][0] < end - WINDOWS_S[-1]:
            self._sums.popleft()

    def over(self, window: float, now: float) -> float:
        """E over the last so many s; NaN without a sample."""
        inside = [(total, count) for end, total, count in self._sums if end > now - window]
        count = sum(number for _, number in inside)
        return math.sqrt(sum(total for total, _ in inside) / count) if count else math.nan
