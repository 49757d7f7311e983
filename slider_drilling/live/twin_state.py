"""What a twin says of the rig, as the page shows it: expected channels, gap, trends and detections."""

from __future__ import annotations

import json
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from slider_drilling.live.freshness import Arrivals, Freshness

MAX_EXPECTED = 6000  # samples
TREND_PERIOD = 10.0  # s between points of the trends that are kept
MAX_TREND_POINTS = 720  # two hours
MAX_DETECTIONS = 50
_SAME = 1e-4  # s within which messages are of one moment


@dataclass(frozen=True)
class ExpectedSample:
    """What the twin expects at one time; NaN where it expects nothing.

    Attributes:
        time: s.
        surface_torque: N m.
        differential_pressure: Pa.
        hook_load: N.
        tool_face: rad.
    """

    time: float
    surface_torque: float
    differential_pressure: float
    hook_load: float
    tool_face: float


@dataclass(frozen=True)
class TrendPoint:
    """Calibrated parameters at one time, s: (value, lower, upper) by name."""

    time: float
    numbers: Mapping[str, tuple[float, float, float]]


class TwinState:
    """Written by the dashboard node, read by the page; methods lock what they use.

    Args:
        now: Monotonic time, s.

    Attributes:
        revision: Grows with every change but expected samples.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._lock = threading.Lock()
        self._arrivals = Arrivals()
        self.revision = 0
        self.clear()

    def clear(self) -> None:
        """Forget everything: the rig's clock was set back."""
        with self._lock:
            self._expected: deque[ExpectedSample] = deque(maxlen=MAX_EXPECTED)
            self._count = 0
            self._parts: dict[str, tuple[float, float]] = {}  # channel -> time s and value of its last message
            self._gaps: dict[int, dict[str, float]] = {}
            self._thresholds: dict[str, float] = {}
            self._bounds: dict[str, tuple[float, dict[str, float]]] = {}
            self._trends: deque[TrendPoint] = deque(maxlen=MAX_TREND_POINTS)
            self._latest: TrendPoint | None = None
            self._diagnosis: dict[str, Any] = {}
            self.revision += 1

    def set_expected(self, channel: str, at: float, value: float) -> None:
        """Take a number of one channel; `finish_expected` makes a sample of those of one time. at: s."""
        self._parts[channel] = (at, value)

    def finish_expected(self, at: float, circulation: float) -> None:
        """All channels of a time have come: at s; circulation: pressure that the flow takes off bottom, Pa."""

        def of(channel: str) -> float:
            time_s, value = self._parts.get(channel, (math.nan, math.nan))
            return value if abs(time_s - at) < _SAME else math.nan

        sample = ExpectedSample(
            at, of("surface_torque"), of("standpipe_pressure") - circulation, of("hook_load"), of("tool_face")
        )
        with self._lock:
            self._expected.append(sample)
            self._count += 1

    def expected_after(self, count: int) -> tuple[list[ExpectedSample], int]:
        """The expected samples after the first `count`, as far as they are kept, and the number of all."""
        with self._lock:
            fresh = max(min(self._count - count, len(self._expected)), 0)
            return list(self._expected)[len(self._expected) - fresh :], self._count

    def set_gaps(self, seconds: int, gaps: Mapping[str, float]) -> None:
        """Set the gap of each channel over a time, noise levels."""
        with self._lock:
            self._arrivals.note(self._now())
            self._gaps[seconds] = dict(gaps)
            self.revision += 1

    def set_thresholds(self, thresholds: Mapping[str, float]) -> None:
        """Set the gap of each channel above which it shows a change, noise levels."""
        with self._lock:
            self._thresholds = dict(thresholds)

    def set_trends(self, bound: str, at: float, numbers: Mapping[str, float]) -> None:
        """Take the values, or the lower or upper ends of their intervals; at: s. They make a point once all came."""
        with self._lock:
            self._bounds[bound] = (at, dict(numbers))
            value, low, high = (self._bounds.get(name, (math.nan, {})) for name in ("value", "lower", "upper"))
            if not (value[0] == low[0] == high[0]):
                return
            point = TrendPoint(at, {
                name: (number, low[1].get(name, math.nan), high[1].get(name, math.nan))
                for name, number in value[1].items()
            })  # fmt: skip
            self._latest = point
            if not self._trends or at - self._trends[-1].time >= TREND_PERIOD:
                self._trends.append(point)
                self.revision += 1

    def set_diagnosis(self, text: str) -> None:
        """Take the JSON of `gap/diagnosis`. Raises ValueError if it is none."""
        tree = json.loads(text)
        if not isinstance(tree, dict):
            raise ValueError("not an object")
        with self._lock:
            self._diagnosis = tree
            self.revision += 1

    def gaps(self) -> dict[str, tuple[float, float, float, float]]:
        """Channel -> gap over 10, 60 and 300 s and its threshold, noise levels; NaN where not known."""
        with self._lock:
            by_time = [self._gaps.get(seconds, {}) for seconds in (10, 60, 300)]
            names = dict.fromkeys(name for gaps in (*by_time, self._thresholds) for name in gaps)
            return {
                name: (
                    by_time[0].get(name, math.nan), by_time[1].get(name, math.nan), by_time[2].get(name, math.nan),
                    self._thresholds.get(name, math.nan),
                )
                for name in names
            }  # fmt: skip

    def trends(self) -> list[TrendPoint]:
        """Calibrated parameters over time, oldest first."""
        with self._lock:
            return list(self._trends)

    def latest_trends(self) -> dict[str, tuple[float, float, float]]:
        """The calibrated parameters now: (value, lower, upper) by name; empty before they are known."""
        with self._lock:
            return {} if self._latest is None else dict(self._latest.numbers)

    def diagnosis(self) -> dict[str, Any]:
        """The last JSON of `gap/diagnosis`; empty before the first."""
        with self._lock:
            return self._diagnosis

    @property
    def compared(self) -> bool:
        """Whether the twin has learnt the rig, so that a change would show."""
        return bool(self.diagnosis().get("compared"))

    def detections(self) -> list[dict[str, Any]]:
        """The detections, newest last."""
        found = self.diagnosis().get("detections", [])
        return [one for one in found if isinstance(one, dict)][-MAX_DETECTIONS:]

    def answer(self) -> tuple[float, str] | None:
        """When the last diagnosis answered, s, and what it says by itself; None before the first."""
        said = self.diagnosis()
        answered, answer = said.get("answered"), said.get("answer")
        if not isinstance(answered, (int, float)) or not isinstance(answer, dict):
            return None
        return answered, str(answer.get("summary", ""))

    def freshness(self) -> Freshness | None:
        """Whether the twin still speaks; None without one."""
        with self._lock:
            return self._arrivals.freshness(self._now()) if self._gaps else None

    def age(self) -> float:
        """Time since its last status, s."""
        with self._lock:
            return self._arrivals.age(self._now())
