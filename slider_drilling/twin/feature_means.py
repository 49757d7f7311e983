"""A feature over time, and its means over some tens of seconds of one stretch of work."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from slider_drilling.twin.samples import Array

_LEAST_SHARE = 1.0 / 3.0  # of its values, that a mean needs; what is left at the end of a stretch joins the mean before


@dataclass(frozen=True)
class FeatureSeries:
    """A feature over time.

    Attributes:
        time: s, (n,), increasing.
        value: Noise levels, (n,).
        stretch: Number of the stretch of work, (n,).
        stretch_start: s, when that stretch began, (n,).
        window: s over which each value was taken, (n,).
        load, steering, swing, pace: Load, travel of the centre, swing and pace of the drive, see `activity.Activity`,
            (n,).
        hook_load_moved: Noise levels by which the hook load has left its level in the stretch, (n,).
        sensitivity: (n, p) to the tracked parameters.
    """

    time: Array
    value: Array
    stretch: Array
    stretch_start: Array
    window: Array
    load: Array
    steering: Array
    swing: Array
    pace: Array
    hook_load_moved: Array
    sensitivity: Array

    def first(self, count: int) -> FeatureSeries:
        """The first values of it."""
        return FeatureSeries(**{field.name: getattr(self, field.name)[:count] for field in fields(self)})


@dataclass(frozen=True)
class FeatureMeans:
    """Means of a `FeatureSeries`; fields of the same name are means of its fields, (m,).

    Attributes:
        begin, end: s, times of the first and the last value of each mean.
        count: Values of each mean.
        age: s since the stretch began.
        weights: (m, n), of the values in the means.
    """

    time: Array
    begin: Array
    end: Array
    value: Array
    count: Array
    stretch: Array
    age: Array
    load: Array
    steering: Array
    swing: Array
    pace: Array
    hook_load_moved: Array
    sensitivity: Array
    weights: Array

    def average(self, values: Array) -> Array:
        """Means (m, k) of as many values (n, k)."""
        return np.asarray(self.weights @ values)


def means_of(series: FeatureSeries, values: int) -> FeatureMeans:
    """Means over so many values each, none over two stretches; the last of a stretch may have fewer or more."""
    groups = _groups(series.stretch, values)
    weights = np.zeros((len(groups), series.time.size))
    for row, (start, end) in enumerate(groups):
        weights[row, start:end] = 1.0 / (end - start)
    first, after = np.array(groups, dtype=int).reshape(-1, 2).T
    return FeatureMeans(
        weights @ series.time, series.time[first], series.time[after - 1], weights @ series.value,
        (after - first).astype(float), series.stretch[first], weights @ (series.time - series.stretch_start),
        weights @ series.load, weights @ series.steering, weights @ series.swing, weights @ series.pace,
        weights @ series.hook_load_moved, weights @ series.sensitivity, weights,
    )  # fmt: skip


def _groups(stretch: Array, values: int) -> list[tuple[int, int]]:
    """First value of each mean, and the one after its last."""
    groups: list[tuple[int, int]] = []
    edges = np.flatnonzero(np.diff(stretch)) + 1
    for start, end in zip((0, *edges), (*edges, stretch.size), strict=True):
        firsts = list(range(start, end, values))
        if len(firsts) > 1 and end - firsts[-1] < _LEAST_SHARE * values:
            firsts.pop()
        own = list(zip(firsts, (*firsts[1:], end), strict=True))
        groups += [(first, after) for first, after in own if after - first >= _LEAST_SHARE * values]
    return groups
