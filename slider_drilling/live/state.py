"""What the page shows of a rig: the last minutes in buffers that do not grow, and the newest of everything else.

One thread writes (the node's), others read (the page's); every method holds the lock as long as it needs.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
from slider_drilling.messages.health import Level, Status
from slider_drilling.rig import Rig

WINDOW = 300.0  # s that the strips show
MAX_SAMPLES = 6000  # of the strips, whatever the rate
MAX_TOOL_FACES = 30  # toolfaces on the dial
MAX_STATUSES = 64
MAX_NOTICES = 20
STALE = 2.0  # s after which a pressure is no longer shown
_AT_ONCE = 1e-6  # s, filter of differential pressure: none


@dataclass(frozen=True)
class StripSample:
    """One sample of the strips: s, N m, Pa, rad."""

    time: float
    surface_torque: float
    differential_pressure: float
    top_drive_angle: float


@dataclass(frozen=True)
class ToolFacePoint:
    """A toolface as measured: s, rad."""

    measured_at: float
    tool_face: float


@dataclass(frozen=True)
class LiveParameter:
    """A parameter that can change while its node runs; low and high are inclusive."""

    node: str
    name: str
    value: float
    unit: str
    low: float
    high: float
    about: str


@dataclass(frozen=True)
class Notice:
    """Something to tell whoever looks: what was refused, what was done. number: counts them."""

    number: int
    text: str
    success: bool


class LiveState:
    """Fed by messages as they come, read by the page ten times a second."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._rows: deque[StripSample] = deque(maxlen=MAX_SAMPLES)
        self._count = 0  # rows taken so far
        self._dots: deque[ToolFacePoint] = deque(maxlen=MAX_TOOL_FACES)
        self._notices: deque[Notice] = deque(maxlen=MAX_NOTICES)
        self._told = 0
        self._statuses: dict[str, Status] = {}
        self._settings: dict[tuple[str, str], LiveParameter] = {}
        self._rig: Rig | None = None
        self._motor: DifferentialPressure | None = None
        self._pressure = self._pump = (math.nan, math.nan)
        self.target = math.nan  # rad
        self.truth: float | None = None  # rad, of the bit, in a simulation
        self.recording: bool | None = None  # None: nobody has said

    def set_rig(self, rig: Rig) -> None:
        """The rig file, from which differential pressure and the hole's course follow."""
        with self._lock:
            self._rig, self._motor = rig, DifferentialPressure(rig, 0.0, _AT_ONCE, _AT_ONCE)

    @property
    def rig(self) -> Rig | None:
        """The rig file, None until it has come."""
        return self._rig

    def set_pressure(self, time: float, pressure: float) -> None:
        """Standpipe pressure: s, Pa."""
        self._pressure = (time, pressure)

    def set_pump_speed(self, time: float, speed: float) -> None:
        """Crank speed of the pump: s, rad/s."""
        self._pump = (time, speed)

    def add_sample(self, time: float, angle: float, torque: float) -> None:
        """One sample of the top drive, the last to come of its stamp: s, rad, N m. A clock set back begins anew."""
        with self._lock:
            if self._rows and time < self._rows[-1].time:
                self._begin_anew()
            self._rows.append(StripSample(time, torque, self._across_motor(time), angle))
            self._count += 1
            while self._rows[0].time < time - WINDOW:
                self._rows.popleft()

    def _across_motor(self, time: float) -> float:
        """Differential pressure, Pa; NaN where what it takes has not come lately."""
        newest = (self._pressure, self._pump)
        known = all(math.isfinite(value) and abs(time - since) <= STALE for since, value in newest)
        if self._motor is None or not known:
            return math.nan
        self._motor.update(self._pressure[1], self._pump[1], 1.0)
        return self._motor.quick

    def _begin_anew(self) -> None:
        self._rows.clear()
        self._dots.clear()
        self._statuses.clear()

    def add_tool_face(self, measured_at: float, tool_face: float) -> None:
        """A decoded toolface: s, rad."""
        with self._lock:
            self._dots.append(ToolFacePoint(measured_at, tool_face))

    def update_statuses(self, statuses: Iterable[Status]) -> None:
        """Statuses named ``node: what``; the newest of each name counts."""
        with self._lock:
            for status in statuses:
                if status.name in self._statuses or len(self._statuses) < MAX_STATUSES:
                    self._statuses[status.name] = status

    def update_parameters(self, settings: Iterable[LiveParameter]) -> None:
        """Parameters of a node; the newest value of each counts."""
        with self._lock:
            self._settings.update({(one.node, one.name): one for one in settings})

    def add_notice(self, text: str, success: bool) -> None:
        """Leave a notice for whoever looks."""
        with self._lock:
            self._told += 1
            self._notices.append(Notice(self._told, text, success))

    def samples_after(self, count: int) -> tuple[list[StripSample], int]:
        """Rows that came after so many, as far as they are kept, and how many there have been."""
        with self._lock:
            fresh = min(self._count - count, len(self._rows))
            rows = [self._rows[k] for k in range(len(self._rows) - fresh, len(self._rows))] if fresh > 0 else []
            return rows, self._count

    def notices_after(self, number: int) -> list[Notice]:
        """Notices beyond this number."""
        with self._lock:
            return [one for one in self._notices if one.number > number]

    @property
    def last_notice(self) -> int:
        """The number of the newest notice, 0 before the first."""
        return self._told

    def tool_faces(self) -> list[ToolFacePoint]:
        """The toolfaces, oldest first."""
        with self._lock:
            return list(self._dots)

    def latest_sample(self) -> StripSample | None:
        """The newest row."""
        with self._lock:
            return self._rows[-1] if self._rows else None

    def statuses(self) -> list[Status]:
        """All statuses, worst first."""
        with self._lock:
            return sorted(self._statuses.values(), key=lambda one: (-one.level, one.name))

    def status_value(self, what: str, key: str) -> float | None:
        """A number of the status ``what`` of any node, None where it has not been said."""
        with self._lock:
            for name, status in self._statuses.items():
                if name.endswith(f": {what}"):
                    for one, text in status.values:
                        if one == key:
                            return _number(text)
        return None

    def parameters(self) -> list[LiveParameter]:
        """Every parameter that can be changed, in the order of their declaration."""
        with self._lock:
            return list(self._settings.values())

    def worst_level(self) -> Level:
        """The worst level of any status."""
        with self._lock:
            return max((one.level for one in self._statuses.values()), default=Level.OK)


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
