"""Measured beside expected: innovations, the gap over the last seconds and its threshold, and the toolface's zero."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping

import numpy as np

from slider_drilling.angles import wrap_angle
from slider_drilling.twin.channels import COMPARED, SURFACE
from slider_drilling.twin.gap import WINDOWS_S, RunningGap
from slider_drilling.twin.history import History
from slider_drilling.twin.report import ChannelState
from slider_drilling.twin.samples import Array, SampleBuffer

_OFFSET_SAMPLES = 8  # of the toolface, whose median difference is its zero
_NEAR = 2.0  # intervals, within which a sample belongs to a grid point
_MIN_GAPS = 60  # values of the gap, s, from which its threshold is taken
_KEPT_GAPS = 3600
_QUANTILE = 0.99


class Comparison:
    """Compares every channel; a second of a surface channel is compared when late samples have had time to arrive.

    Args:
        buffers: Samples by channel.
        noise: Noise level by channel.
        delay: s that samples may be late.
    """

    def __init__(self, buffers: Mapping[str, SampleBuffer], noise: Mapping[str, float], delay: float) -> None:
        self._buffers, self._delay = buffers, delay
        self.gaps = {name: RunningGap(noise[name]) for name in COMPARED}
        self._usual: dict[str, deque[tuple[float, float]]] = {name: deque(maxlen=_KEPT_GAPS) for name in COMPARED}
        self._differences: deque[float] = deque(maxlen=_OFFSET_SAMPLES)
        self._tool_face_until = -math.inf

    @property
    def tool_face_offset(self) -> float:
        """rad, by which the rig's toolface is ahead of the plant's: the circular median of the last differences."""
        if not self._differences:
            return 0.0
        differences = np.array(self._differences)
        reference = math.atan2(float(np.mean(np.sin(differences))), float(np.mean(np.cos(differences))))
        return reference + float(np.median(wrap_angle(differences - reference)))

    def measured(self, channel: str, grid: Array) -> Array:
        """A channel at the times of an even grid (n,); NaN where it was not measured."""
        time, value = self._buffers[channel].window(float(grid[0]) - 1.0, float(grid[-1]) + 1.0)
        if not time.size:
            return np.full(grid.shape, np.nan)
        after = np.searchsorted(time, grid)
        away = np.minimum(
            np.abs(time[np.minimum(after, time.size - 1)] - grid), np.abs(grid - time[np.maximum(after - 1, 0)])
        )
        interval = float(grid[1] - grid[0])
        return np.where(away <= _NEAR * interval, np.interp(grid, time, value), np.nan)

    def update(self, history: History, values: Array, now: float, usual: bool, changed: float) -> None:
        """Take what has come in.

        Args:
            history: Of the plants.
            values: (p,) calibrated values.
            now: s.
            usual: Whether the rig does what it usually does, so that its gaps say what is usual.
            changed: s, the earliest time of a change that was detected; infinity without one. Gaps since say nothing
                of what is usual.
        """
        end = now - self._delay
        found = history.window(end - 1.0 + 1e-6, end + 1e-6)
        for name in SURFACE:
            if found is not None and found.time.size > 1:
                row = list(COMPARED).index(name)
                innovation = self.measured(name, found.time) - found.at(values)[:, row]
                self.gaps[name].add(end, innovation)
        self._take_tool_faces(history, values, now)
        for name, gaps in self._usual.items():
            gap = self.gaps[name].over(WINDOWS_S[1], now) if usual else math.nan
            if math.isfinite(gap):
                gaps.append((now, gap))
            while gaps and gaps[-1][0] > changed:
                gaps.pop()

    def state(self, name: str, expected: float, now: float) -> ChannelState:
        """The state of a channel; expected: its value in the twin now."""
        gap = self.gaps[name]
        e10, e60, e300 = (gap.over(window, now) for window in WINDOWS_S)
        measured = float(self._buffers[name].value[-1])
        return ChannelState(
            name, COMPARED[name].unit, measured, expected, e10, e60, e300, self.threshold(name), gap.noise
        )

    def threshold(self, name: str) -> float:
        """The gap over 60 s that the channel exceeded in 1 % of the time before a change; NaN before a minute of it."""
        usual = [gap for _, gap in self._usual[name]]
        return float(np.quantile(usual, _QUANTILE)) if len(usual) >= _MIN_GAPS else math.nan

    def _take_tool_faces(self, history: History, values: Array, now: float) -> None:
        time, value = self._buffers["tool_face"].window(self._tool_face_until + 1e-9, now + 1e-9)
        if not time.size:
            return
        self._tool_face_until = float(time[-1])
        difference = wrap_angle(value - history.at("tool_face", time, values))
        known = np.isfinite(difference)
        for at, each in zip(time[known], difference[known], strict=True):
            if self._differences:
                self.gaps["tool_face"].add(float(at), wrap_angle(np.array([each - self.tool_face_offset])))
            self._differences.append(float(each))
