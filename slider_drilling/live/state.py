"""The state of a rig that the page shows: the last minutes in bounded buffers, and the latest of everything else.

The node's thread writes and the page's threads read; methods lock what they use.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
from slider_drilling.live.drilling_progress import DrillingProgress
from slider_drilling.live.freshness import Arrivals, Freshness
from slider_drilling.live.twin_state import TwinState
from slider_drilling.messages.health import Level, Status
from slider_drilling.rig import Rig

WINDOW = 300.0  # s that the strip charts show
MAX_SAMPLES = 6000  # of the strip charts
MAX_TOOL_FACES = 30  # measured ones on the dial
MAX_STATUSES = 64
MAX_NOTICES = 20
STALE = 2.0  # s after which a pressure is no longer shown
_CIRCULATION_SAMPLES = 600  # that are kept for what a twin expects, which comes a few seconds later
_HALF_SAMPLE = 0.05  # s
STALE_DEPTH = 10.0  # s after which a rig's bit depth is no longer shown
_NO_FILTER = 1e-6  # s, filter time of differential pressure


@dataclass(frozen=True)
class StripSample:
    """One sample of the strip charts: time s, torque N m, pressure Pa, angle rad, hook load N."""

    time: float
    surface_torque: float
    differential_pressure: float
    top_drive_angle: float
    hook_load: float = math.nan


@dataclass(frozen=True)
class DrillingFigures:
    """Numbers of the drilling; NaN where not known.

    Attributes:
        hook_load: N.
        bit_depth: Measured depth, m.
        rate_of_penetration: m/s.
        slide_length: Hole made since the slide began, m.
    """

    hook_load: float
    bit_depth: float
    rate_of_penetration: float
    slide_length: float


@dataclass(frozen=True)
class ToolFacePoint:
    """A measured toolface: time s, angle rad."""

    measured_at: float
    tool_face: float


@dataclass(frozen=True)
class LiveParameter:
    """A parameter that can change while its node runs.

    Attributes:
        node: Name of its node.
        name: Its name.
        value: NaN until it has been read.
        unit: "-" if it has none.
        low: Smallest value, inclusive.
        high: Largest value, inclusive.
        description: What it means.
    """

    node: str
    name: str
    value: float
    unit: str
    low: float
    high: float
    description: str


def zero_meaning(parameter: LiveParameter) -> str:
    """What a value of 0 stands for, such as "automatic"; "" for another value, or where 0 is a number."""
    _, marker, meaning = parameter.description.partition("; 0: ")
    return meaning if marker and parameter.value == 0.0 else ""


@dataclass(frozen=True)
class Notice:
    """The outcome of a request, for everybody who has the page open.

    Attributes:
        number: Counts the notices.
        text: One line.
        success: Whether the request was carried out.
    """

    number: int
    text: str
    success: bool


@dataclass
class _KeptStatus:
    """The latest status of a name, and when those of this name came."""

    status: Status
    arrivals: Arrivals = field(default_factory=Arrivals)


@dataclass(frozen=True)
class ShownStatus:
    """A status with its age.

    Attributes:
        status: The latest of its name.
        age: Time since it came, s of the wall's clock.
        freshness: Whether it still comes.
    """

    status: Status
    age: float
    freshness: Freshness

    @property
    def level(self) -> Level:
        """Severity; a status that no longer comes is an error whatever it said last."""
        return Level.ERROR if self.freshness is Freshness.LOST else Level(self.status.level)

    @property
    def message(self) -> str:
        """What the status says, or for how long it has said nothing."""
        if self.freshness is Freshness.LOST:
            return f"no status for {self.age:.0f} s; last: {self.status.message}"
        return self.status.message


class LiveState:
    """Written by the dashboard node as messages come, read by the page ten times a second.

    Args:
        now: Monotonic time, s.

    Attributes:
        target: Toolface to hold, rad.
        truth: True toolface, rad, of a simulation.
        recording: Whether the recorder records; None without a recorder.
        twin: What a twin says.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._sample_arrivals = Arrivals()
        self._lock = threading.Lock()
        self._samples: deque[StripSample] = deque(maxlen=MAX_SAMPLES)
        self._count = 0  # of all samples so far
        self._tool_faces: deque[ToolFacePoint] = deque(maxlen=MAX_TOOL_FACES)
        self._notices: deque[Notice] = deque(maxlen=MAX_NOTICES)
        self._last_notice = 0
        self._statuses: dict[str, _KeptStatus] = {}
        self._parameters: dict[tuple[str, str], LiveParameter] = {}
        self._rig: Rig | None = None
        self._motor: DifferentialPressure | None = None
        self._pressure = self._pump = self._depth = (math.nan, math.nan)
        self._block = (math.nan, math.nan, math.nan)
        self._progress = DrillingProgress()
        self._circulation: deque[tuple[float, float]] = deque(maxlen=_CIRCULATION_SAMPLES)
        self.twin = TwinState(now)
        self.target = math.nan
        self.truth: float | None = None
        self.recording: bool | None = None

    def set_rig(self, rig: Rig) -> None:
        """Set the rig, which gives differential pressure and the well path."""
        with self._lock:
            self._rig, self._motor = rig, DifferentialPressure(rig, 0.0, _NO_FILTER, _NO_FILTER)

    @property
    def rig(self) -> Rig | None:
        """The rig; None until it is known."""
        return self._rig

    def set_pressure(self, time: float, pressure: float) -> None:
        """Set the standpipe pressure: time s, pressure Pa."""
        self._pressure = (time, pressure)

    def set_pump_speed(self, time: float, speed: float) -> None:
        """Set the pump's crank speed: time s, speed rad/s."""
        self._pump = (time, speed)

    def set_block(self, time: float, position: float, hook_load: float) -> None:
        """Set the block: time s, lowered since the start m, hook load N."""
        self._block = (time, position, hook_load)

    def set_bit_depth(self, time: float, depth: float) -> None:
        """Set the bit's depth where a rig gives it: time s, measured depth m."""
        self._depth = (time, depth)

    def add_sample(self, time: float, angle: float, torque: float) -> None:
        """Add a sample of the top drive, whose message is the last of its stamp: time s, angle rad, torque N m.

        If the clock was set back, the buffers are cleared.
        """
        with self._lock:
            if self._samples and time < self._samples[-1].time:
                self._clear()
            pressure = self._differential_pressure(time)
            self._circulation.append((time, self._pressure[1] - pressure))
            hook_load = self._block[2] if abs(time - self._block[0]) <= STALE else math.nan
            self._samples.append(StripSample(time, torque, pressure, angle, hook_load))
            self._progress.add(time, self._bit_depth(time), angle)
            self._count += 1
            self._sample_arrivals.note(self._now())
            while self._samples[0].time < time - WINDOW:
                self._samples.popleft()

    def _differential_pressure(self, time: float) -> float:
        """Differential pressure, Pa; NaN without recent pressure and pump speed."""
        readings = (self._pressure, self._pump)
        are_recent = all(math.isfinite(value) and abs(time - at) <= STALE for at, value in readings)
        if self._motor is None or not are_recent:
            return math.nan
        self._motor.update(self._pressure[1], self._pump[1], 1.0)
        return self._motor.quick

    def _bit_depth(self, time: float) -> float:
        """Measured depth of the bit, m: the rig's own, else by the block; NaN if it is not recent."""
        if math.isfinite(self._depth[0]):
            return self._depth[1] if abs(time - self._depth[0]) <= STALE_DEPTH else math.nan
        length = math.nan if self._rig is None else self._rig.string.length
        return length + self._block[1] if abs(time - self._block[0]) <= STALE else math.nan

    def circulation_at(self, time: float) -> float:
        """Pressure that the flow takes off bottom at the time of a recent sample, Pa; NaN where not known."""
        with self._lock:
            recent = reversed(self._circulation)
            return next((pressure for at, pressure in recent if at <= time + _HALF_SAMPLE), math.nan)

    def drilling(self) -> DrillingFigures:
        """Hook load, depth, rate of penetration and length of the slide."""
        with self._lock:
            if not self._samples:
                return DrillingFigures(math.nan, math.nan, math.nan, math.nan)
            last, progress = self._samples[-1], self._progress
            return DrillingFigures(
                last.hook_load, self._bit_depth(last.time), progress.rate_of_penetration, progress.slide_length
            )

    def _clear(self) -> None:
        self._circulation.clear()
        self._progress = DrillingProgress()
        self.twin.clear()
        self._samples.clear()
        self._tool_faces.clear()
        self._statuses.clear()

    def add_tool_face(self, measured_at: float, tool_face: float) -> None:
        """Add a decoded toolface: time s, angle rad."""
        with self._lock:
            self._tool_faces.append(ToolFacePoint(measured_at, tool_face))

    def update_statuses(self, statuses: Iterable[Status]) -> None:
        """Update statuses, named ``node: subject``; the latest of each name counts, the newest names are kept."""
        with self._lock:
            now = self._now()
            for status in statuses:
                # Removed first, so that the dictionary is in the order of the last arrival.
                kept = self._statuses.pop(status.name, None) or _KeptStatus(status)
                kept.status = status
                kept.arrivals.note(now)
                self._statuses[status.name] = kept
            while len(self._statuses) > MAX_STATUSES:
                del self._statuses[next(iter(self._statuses))]

    def update_parameters(self, parameters: Iterable[LiveParameter]) -> None:
        """Update parameters of a node."""
        with self._lock:
            self._parameters.update({(parameter.node, parameter.name): parameter for parameter in parameters})

    def add_notice(self, text: str, success: bool) -> None:
        """Add a notice; success: whether a request was carried out."""
        with self._lock:
            self._last_notice += 1
            self._notices.append(Notice(self._last_notice, text, success))

    def samples_after(self, count: int) -> tuple[list[StripSample], int]:
        """The samples after the first `count`, as far as they are kept, and the number of all samples."""
        with self._lock:
            fresh = min(self._count - count, len(self._samples))
            return list(self._samples)[len(self._samples) - max(fresh, 0) :], self._count

    def notices_after(self, number: int) -> list[Notice]:
        """The notices after one of this number."""
        with self._lock:
            return [notice for notice in self._notices if notice.number > number]

    @property
    def last_notice(self) -> int:
        """The number of the latest notice; 0 before the first."""
        return self._last_notice

    def tool_faces(self) -> list[ToolFacePoint]:
        """The measured toolfaces, oldest first."""
        with self._lock:
            return list(self._tool_faces)

    def latest_sample(self) -> StripSample | None:
        """The latest sample; None before the first."""
        with self._lock:
            return self._samples[-1] if self._samples else None

    def statuses(self) -> list[ShownStatus]:
        """All statuses with their age, the most severe first."""
        with self._lock:
            now = self._now()
            shown = [
                ShownStatus(kept.status, kept.arrivals.age(now), kept.arrivals.freshness(now))
                for kept in self._statuses.values()
            ]
        return sorted(shown, key=lambda one: (-one.level, one.status.name))

    def samples_age(self) -> tuple[float, Freshness]:
        """Time since the last sample, s of the wall's clock, and whether samples still come."""
        with self._lock:
            now = self._now()
            return self._sample_arrivals.age(now), self._sample_arrivals.freshness(now)

    def status_value(self, subject: str, key: str) -> float | None:
        """A number of the status ``subject`` of any node; None if it is not known or the status no longer comes."""
        with self._lock:
            now = self._now()
            values = [
                value
                for name, kept in self._statuses.items()
                if name.endswith(f": {subject}") and kept.arrivals.freshness(now) is not Freshness.LOST
                for value in kept.status.values
            ]
        return next((_number(text) for name, text in values if name == key), None)

    def parameters(self) -> list[LiveParameter]:
        """Every parameter that can be changed, in the order of declaration."""
        with self._lock:
            return list(self._parameters.values())


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
