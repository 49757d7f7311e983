"""Watches every feature of every channel for a change."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.twin.activity import Activity
from slider_drilling.twin.change_statistic import Change, likeliest_change
from slider_drilling.twin.features import Feature
from slider_drilling.twin.samples import Array
from slider_drilling.twin.wander import THRESHOLD, WANDERS

MEMORY_S = 900.0
_CONFIRMED_S = 14.0  # for which a feature must show a change without a break


@dataclass(frozen=True)
class Alarm:
    """A feature that has changed.

    Attributes:
        time: s, when it was noticed.
        channel, kind: Of the feature.
        change: What changed.
    """

    time: float
    channel: str
    kind: str
    change: Change


@dataclass(frozen=True)
class _Value:
    time: float
    value: float
    work: int
    window: float
    sensitivity: Array


class ChangeDetector:
    """Keeps every feature for some minutes and tests it; memory is bounded.

    Args:
        covariance: (p, p), what is uncertain of the tracked parameters.
    """

    def __init__(self, covariance: Array) -> None:
        self._covariance = covariance
        self._shown_since: dict[tuple[str, str], float] = {}
        self._series: dict[tuple[str, str], deque[_Value]] = {}

    def add(self, time: float, activity: Activity, found: Sequence[Feature], window: float | None = None) -> None:
        """Take the features of a window that ends at `time`, s; nothing is taken while the work is not settled.

        Args:
            time: s.
            activity: What the rig does.
            found: The features.
            window: s over which they were taken; None for the rocking period.
        """
        for series in self._series.values():
            while series and series[-1].time > activity.valid_until:
                series.pop()
        if not activity.settled:
            self._shown_since.clear()
            return
        width = activity.period if window is None else window
        for feature in found:
            series = self._series.setdefault((feature.channel, feature.kind), deque())
            series.append(_Value(time, feature.value, activity.changes, width, feature.sensitivity))
            while series[0].time < time - MEMORY_S:
                series.popleft()

    def forget(self, until: float) -> None:
        """Forget what was before a change, s: from now on the rig is compared with what it is since then."""
        for series in self._series.values():
            while series and series[0].time < until:
                series.popleft()

    def watched(self) -> list[tuple[str, str]]:
        """(channel, kind) of the features so far."""
        return list(self._series)

    def change(self, channel: str, kind: str) -> Change | None:
        """The likeliest change of one feature, whether or not it is significant."""
        series = self._series[channel, kind]
        if len(series) < 2:
            return None
        return likeliest_change(
            np.array([each.time for each in series]), np.array([each.value for each in series]),
            np.array([each.work for each in series]), np.array([each.window for each in series]),
            np.stack([each.sensitivity for each in series]), self._covariance, WANDERS[channel, kind],
        )  # fmt: skip

    def test(self, channel: str, kind: str) -> Alarm | None:
        """An alarm if the feature has shown a change for some time, beyond what happens by chance."""
        key, change = (channel, kind), self.change(channel, kind)
        smallest = WANDERS[key].smallest
        if change is None or change.evidence < THRESHOLD or abs(change.size) < smallest:
            self._shown_since.pop(key, None)
            return None
        now = self._series[key][-1].time
        if now - self._shown_since.setdefault(key, now) < _CONFIRMED_S:
            return None
        return Alarm(now, channel, kind, change)
