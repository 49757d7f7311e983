"""Watches every feature of every channel for a change."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from slider_drilling.twin.activity import OFF_BOTTOM, Activity
from slider_drilling.twin.change_statistic import FeatureChange, Uncertainty, likeliest_change
from slider_drilling.twin.feature_means import FeatureSeries
from slider_drilling.twin.features import Feature
from slider_drilling.twin.samples import Array
from slider_drilling.twin.wander import ROCKING_OR_OFF_BOTTOM, comparisons, wander_of

MEMORY_S = 1800.0
"""s for which values of work are kept."""
# s for which those of circulation off bottom are kept: from one connection to the next. There are no more of them than
# of work, for a test takes as long as the cube of their number.
_OFF_BOTTOM_MEMORY_S, _MOST_VALUES = 14400.0, 360
_CONFIRMED_S = 12.0  # for which a feature must show a change without a break

_DATES = 5.0  # evidence of a feature from which it dates what a diagnosis has found
# s and values of a stretch of work that give the level of the hook load in it.
_HOOK_LOAD_S, _HOOK_LOAD_VALUES = 300.0, 6

Key = tuple[str, str, str]
"""Kind of work (`wander.comparisons`), channel and kind of a feature."""


@dataclass(frozen=True)
class Alarm:
    """A feature that has changed.

    Attributes:
        time: s, of the last value that shows it, or when it was noticed.
        channel, kind: Of the feature.
        change: What changed.
    """

    time: float
    channel: str
    kind: str
    change: FeatureChange


@dataclass(frozen=True)
class _Value:
    time: float
    value: float
    stretch: int
    stretch_start: float
    window: float
    load: float
    steering: float
    swing: float
    pace: float
    hook_load_moved: float
    sensitivity: Array


class ChangeDetector:
    """Keeps every feature for some time, apart for each mode of work, and tests it; memory is bounded.

    Args:
        uncertain: What is uncertain of the tracked parameters.
    """

    def __init__(self, uncertain: Uncertainty) -> None:
        self.uncertain = uncertain
        self._shown_since: dict[Key, float] = {}
        self._series: dict[Key, deque[_Value]] = {}

    @classmethod
    def before_learning(cls, count: int) -> ChangeDetector:
        """A detector that only keeps: nothing of the `count` parameters is uncertain, because nothing is tested."""
        return cls(Uncertainty(np.zeros((count, count)), np.zeros((count, 1))))

    def add(self, time: float, activity: Activity, found: Sequence[Feature]) -> None:
        """Take the features of a window of one period that ends at `time`, s, where they can be compared."""
        for key, series in self._series.items():
            while series and series[-1].time > activity.valid_until:
                series.pop()
                self._shown_since.pop(key, None)
        if not activity.comparable and not activity.circulating:
            return
        moved = self._hook_load_moved(time, activity, found)
        for feature in found:
            block_moves = feature.channel == "hook_load" and activity.circulating and not activity.hanging
            if block_moves:
                continue
            value = _Value(
                time, feature.value, activity.stretch, activity.stretch_start, activity.period,
                0.0 if activity.circulating else activity.load, activity.steering, activity.swing, activity.pace,
                moved, feature.sensitivity,
            )  # fmt: skip
            for work in comparisons(activity.mode, feature.channel, feature.kind):
                if wander_of(work, feature.channel, feature.kind) is not None:
                    self._keep((work, feature.channel, feature.kind), value)

    def _hook_load_moved(self, time: float, activity: Activity, found: Sequence[Feature]) -> float:
        """Noise levels by which the hook load has left its level in this stretch of work; 0 where that is not known.

        A string that slips where the plant's holds takes weight to the bit, and the hook load with it.
        """
        mean = next((each.value for each in found if (each.channel, each.kind) == ("hook_load", "mean")), None)
        series = self._series.get((activity.mode, "hook_load", "mean"), ())
        level = [each.value for each in series
                 if each.stretch == activity.stretch and each.time >= time - _HOOK_LOAD_S]  # fmt: skip
        return 0.0 if mean is None or len(level) < _HOOK_LOAD_VALUES else abs(mean - float(np.median(level)))

    def _keep(self, key: Key, value: _Value) -> None:
        series = self._series.setdefault(key, deque())
        series.append(value)
        kept = _OFF_BOTTOM_MEMORY_S if key[0] == OFF_BOTTOM else MEMORY_S
        while series[0].time < value.time - kept or len(series) > _MOST_VALUES:
            series.popleft()

    def recalibrated(self, moved: Array, uncertain: Uncertainty) -> ChangeDetector:
        """The same values, as they would be with other parameters of the plant.

        Args:
            moved: By how much the parameters have moved, (p,).
            uncertain: What is uncertain of them now.
        """
        detector = ChangeDetector(uncertain)
        for key, series in self._series.items():
            detector._series[key] = deque(
                replace(each, value=each.value - float(each.sensitivity @ moved)) for each in series
            )
        return detector

    def forget(self, until: float) -> None:
        """Forget what was before a change, s: from now on the rig is compared with what it is since then."""
        for series in self._series.values():
            while series and series[0].time < until:
                series.popleft()

    def watched(self, mode: str) -> list[Key]:
        """The features so far that work of a mode may show a change of."""
        return [key for key in self._series if key[0] in (mode, ROCKING_OR_OFF_BOTTOM)]

    def change(self, key: Key) -> FeatureChange | None:
        """The likeliest change of one feature, whether or not it is significant."""
        wander = wander_of(*key)
        if wander is None or not self._series[key]:
            return None
        return likeliest_change(self.series(key), self.uncertain, wander)

    def dated(self, low: float, high: float) -> FeatureChange | None:
        """The most evident change of a feature that began between two times, s; None if none is evident."""
        found = [change for key in self._series if (change := self.change(key)) is not None]
        within = [each for each in found if low <= each.since <= high and each.evidence >= _DATES]
        return max(within, key=lambda each: each.evidence, default=None)

    def series(self, key: Key) -> FeatureSeries:
        """What is kept of a feature, one value or more."""
        values = self._series[key]
        return FeatureSeries(
            **{field.name: np.array([getattr(each, field.name) for each in values]) for field in fields(FeatureSeries)}
        )

    def test(self, key: Key, complete: bool = False) -> Alarm | None:
        """An alarm if the feature has shown a change for some time, beyond what happens by chance.

        Args:
            key: Of the feature.
            complete: Whether the stretch of work is over, and need not show it longer.
        """
        change, wander = self.change(key), wander_of(*key)
        if change is None or wander is None or not wander.exceeded_by(change):
            self._shown_since.pop(key, None)
            return None
        now = self._series[key][-1].time
        if not complete and now - self._shown_since.setdefault(key, now) < _CONFIRMED_S:
            return None
        return Alarm(now, *key[1:], change)
