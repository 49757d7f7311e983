"""Which measurements can be believed: age of each channel, and a clock that only goes forward."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from slider_drilling.control.interface import Measurements

CHANNELS = ("top_drive_angle", "surface_torque", "block_position", "hook_load", "standpipe_pressure", "pump_speed")
_LONGEST_STEP = 2.5    # sample periods; a gap in the stream must not become a leap of the reference
_PLAUSIBLE = {"top_drive_angle": 1e6, "surface_torque": 2e5, "block_position": 1e4, "hook_load": 1e7,
              "standpipe_pressure": 2e8, "pump_speed": 1e3}


@dataclass
class MeasurementMonitor:
    """Last believable value and age (s) of each channel; `step` is how far control's own clock moved.

    A stamp that repeats or runs backwards moves nothing; its sample is stale. After a second of stamps that go
    forward again from an earlier time the new time is taken (a simulation that was restarted).
    """

    time: float = math.nan
    step: float = 0.0
    clock_age: float = 0.0
    jumped: bool = False
    value: dict[str, float] = field(default_factory=lambda: dict.fromkeys(CHANNELS, math.nan))
    age: dict[str, float] = field(default_factory=lambda: dict.fromkeys(CHANNELS, math.inf))
    _other: float = math.nan
    _forward: int = 0

    def update(self, m: Measurements, nominal: float) -> None:
        """Take a sample. nominal: s between samples, by which ages grow while the clock gives none."""
        fresh = self._advance_clock(m.time, nominal)
        for name in CHANNELS:
            raw = getattr(m, name)
            self.age[name] += self.step if self.step > 0.0 else nominal
            if fresh and math.isfinite(raw) and abs(raw) <= _PLAUSIBLE[name]:
                self.value[name], self.age[name] = raw, 0.0

    def _advance_clock(self, time: float, nominal: float) -> bool:
        self.jumped = False
        if not math.isfinite(time):
            self.step = 0.0
            self.clock_age += nominal
            return False
        if math.isnan(self.time) or time > self.time:
            elapsed = 0.0 if math.isnan(self.time) else time - self.time
            longest = _LONGEST_STEP * nominal
            self.time, self.step, self.clock_age = time, min(elapsed, longest), 0.0
            self.jumped = elapsed > 60.0
            if elapsed > longest:
                # What came before the gap is as old as the gap is long.
                self.age = {name: age + elapsed - self.step for name, age in self.age.items()}
            return True
        self.step = 0.0
        self.clock_age += nominal
        self._forward = self._forward + 1 if time > self._other else 0
        self._other = time
        if self._forward >= 10:
            self.time, self.jumped, self._forward, self._other = time, True, 0, math.nan
        return False
