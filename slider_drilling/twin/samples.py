"""Samples of one channel in the order of their times, as long as they are needed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.problem.noise import difference_noise

Array = NDArray[np.float64]
_FIRST_SIZE = 1024
_NOISE_SAMPLES = 600  # from which on they show their noise


class SampleBuffer:
    """A bounded record of one channel: samples may come late, twice or not at all.

    Args:
        kept: s; what is older than the newest sample by more is forgotten.
    """

    def __init__(self, kept: float) -> None:
        self._kept = kept
        self._time, self._value = np.empty(_FIRST_SIZE), np.empty(_FIRST_SIZE)
        self._begin = self._end = 0

    def __len__(self) -> int:
        return self._end - self._begin

    @property
    def time(self) -> Array:
        """(n,) s, increasing; a view that holds until the next `add`."""
        return self._time[self._begin : self._end]

    @property
    def value(self) -> Array:
        """(n,) values, a view."""
        return self._value[self._begin : self._end]

    @property
    def last(self) -> float:
        """Time of the newest sample, s; minus infinity without any."""
        return float(self._time[self._end - 1]) if len(self) else -np.inf

    def add(self, time: Array, value: Array) -> None:
        """Take samples (n,); NaN are left out; a second sample of the same time replaces the first."""
        known = np.isfinite(time) & np.isfinite(value)
        time, value = time[known], value[known]
        if not time.size:
            return
        if time.size > 1 and np.any(np.diff(time) <= 0.0):
            order = np.argsort(time, kind="stable")
            time, value = time[order], value[order]
            newest = np.append(np.diff(time) > 0.0, True)
            time, value = time[newest], value[newest]
        if time[0] > self.last:
            self._append(time, value)
        else:
            self._merge(time, value)

    def window(self, begin: float, end: float) -> tuple[Array, Array]:
        """Copies of times and values from `begin` up to and without `end`, s."""
        rows = slice(*np.searchsorted(self.time, (begin, end)))
        return self.time[rows].copy(), self.value[rows].copy()

    def _append(self, time: Array, value: Array) -> None:
        self._begin += int(np.searchsorted(self.time, time[-1] - self._kept))
        if self._end + time.size > self._time.size:
            self._make_room(time.size)
        end = self._end + time.size
        self._time[self._end : end], self._value[self._end : end] = time, value
        self._end = end

    def _merge(self, time: Array, value: Array) -> None:
        joined, values = np.concatenate([self.time, time]), np.concatenate([self.value, value])
        order = np.argsort(joined, kind="stable")
        joined, values = joined[order], values[order]
        newest = np.append(np.diff(joined) > 0.0, True)
        self._begin = self._end = 0
        self._append(joined[newest], values[newest])

    def _make_room(self, more: int) -> None:
        """Move the samples to the front; a larger array where they fill more than half."""
        count = len(self)
        size = self._time.size
        while size < 2 * (count + more):
            size *= 2
        time, value = np.empty(size), np.empty(size)
        time[:count], value[:count] = self.time, self.value
        self._time, self._value, self._begin, self._end = time, value, 0, count


def noise_and_interval(buffer: SampleBuffer, declared: float, interval: float) -> tuple[float, float]:
    """Noise of a channel, at least what is declared, and s between two samples; what is given until there are many."""
    if len(buffer) < _NOISE_SAMPLES:
        return declared, interval
    return max(declared, difference_noise(buffer.value)), float(np.median(np.diff(buffer.time)))
