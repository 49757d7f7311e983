"""Depth, rate of penetration and length of the slide, sample by sample."""

from __future__ import annotations

import itertools
import math
from collections import deque
from typing import NamedTuple

from slider_drilling.rig_activities.classify import ROCKING_NET_SHARE, ROCKING_TIME

RATE_TIME = 60.0  # s over which the rate of penetration is taken
_MIN_RATE_TIME = 20.0  # s
_POINT_PERIOD = 1.0  # s between points that are kept
_MAX_POINTS = int(ROCKING_TIME / _POINT_PERIOD) + 2


class _Point(NamedTuple):
    """One second: time, s; deepest depth so far, m; angle, rad; angle turned in both directions so far, rad."""

    time: float
    deepest: float
    angle: float
    turned: float


class DrillingProgress:
    """Follows the bit of one run. Depths are m below any fixed point; the stretch of the string is left out.

    Attributes:
        slide_start: Depth at which the slide began, m: where the run or the last rotation ended.
    """

    def __init__(self) -> None:
        self._points: deque[_Point] = deque(maxlen=_MAX_POINTS)
        self._deepest = self.slide_start = math.nan
        self._angle = math.nan
        self._turned = 0.0

    def add(self, time: float, depth: float, angle: float) -> None:
        """Add a sample: time s, depth of the bit m, angle of the top drive rad; NaN for one that is missing."""
        if math.isfinite(angle):
            self._turned += abs(angle - self._angle) if math.isfinite(self._angle) else 0.0
            self._angle = angle
        if math.isfinite(depth):
            self._deepest = depth if math.isnan(self._deepest) else max(self._deepest, depth)
        if math.isnan(self.slide_start):
            self.slide_start = self._deepest
        if self._points and time - self._points[-1].time < _POINT_PERIOD:
            return
        self._points.append(_Point(time, self._deepest, self._angle, self._turned))
        if self.is_rotating:
            self.slide_start = self._deepest

    @property
    def is_rotating(self) -> bool:
        """Whether the top drive turns to one side: in both halves of ROCKING_TIME, as no rocking drive does."""
        if len(self._points) < _MAX_POINTS - 1:
            return False
        middle = self._points[len(self._points) // 2]
        edges = (self._points[0], middle, self._points[-1])
        halves = [(b.angle - a.angle, b.turned - a.turned) for a, b in itertools.pairwise(edges)]
        one_way = all(turned > 2.0 * math.pi and abs(net) > ROCKING_NET_SHARE * turned for net, turned in halves)
        return one_way and halves[0][0] * halves[1][0] > 0.0

    @property
    def rate_of_penetration(self) -> float:
        """Mean over RATE_TIME, m/s; NaN before it is known."""
        if not self._points:
            return math.nan
        last = self._points[-1]
        first = next(one for one in self._points if one.time >= last.time - RATE_TIME)
        elapsed = last.time - first.time
        return (last.deepest - first.deepest) / elapsed if elapsed >= _MIN_RATE_TIME else math.nan

    @property
    def slide_length(self) -> float:
        """Hole made since the slide began, m; NaN before it is known, 0 while the top drive rotates."""
        return self._deepest - self.slide_start
