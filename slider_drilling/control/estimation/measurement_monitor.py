"""Validity of the measurements: age of each channel, and a clock that only moves forward."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from slider_drilling.control.interface import Measurements
from slider_drilling.rig.parts import Sensors

CHANNELS = ("top_drive_angle", "surface_torque", "block_position", "hook_load", "standpipe_pressure", "pump_speed")
_MAX_STEP = 2.5    # sample intervals; a gap in the stream must not become a jump of the reference
_RESTART_SAMPLES = 10   # rising stamps from an earlier time, after which that time is taken over
# s for which a noisy reading may repeat itself to the last digit; later it is stuck, and ages as a lost one does.
_FROZEN_AFTER = {"surface_torque": 10.0, "hook_load": 20.0, "standpipe_pressure": 20.0}
_JUMP = 60.0       # s; a longer gap resets the history of the estimators
# Largest magnitude that a channel can have, in its SI unit.
_PLAUSIBLE = {"top_drive_angle": 1e6, "surface_torque": 2e5, "block_position": 1e4, "hook_load": 1e7,
              "standpipe_pressure": 2e8, "pump_speed": 1e3}


@dataclass
class MeasurementMonitor:
    """Last valid value and age of each channel.

    A stamp that repeats or runs backwards does not advance the clock, and its sample is stale. After ten stamps that
    rise again from an earlier time, that time is taken over (a simulation was restarted).

    Attributes:
        time: Clock of the controller, s.
        step: Advance of that clock by the last sample, s; limited, so that a gap causes no jump.
        clock_age: Time for which the stamps have not advanced, s.
        jumped: Whether the last sample moved the clock by more than a minute, or backwards.
        value: Last valid value of each channel, SI unit.
        age: Age of that value, s.
        noisy: Channels whose readings carry noise, so that an unchanging one is stuck.
        stuck: Channels that are stuck now.
    """

    time: float = math.nan
    step: float = 0.0
    clock_age: float = 0.0
    jumped: bool = False
    value: dict[str, float] = field(default_factory=lambda: dict.fromkeys(CHANNELS, math.nan))
    age: dict[str, float] = field(default_factory=lambda: dict.fromkeys(CHANNELS, math.inf))
    noisy: frozenset[str] = frozenset()
    stuck: set[str] = field(default_factory=set)
    _unchanged_for: dict[str, float] = field(default_factory=lambda: dict.fromkeys(_FROZEN_AFTER, 0.0))
    _earlier_time: float = math.nan
    _earlier_count: int = 0

    @classmethod
    def of(cls, sensors: Sensors) -> MeasurementMonitor:
        """A monitor that takes unchanging readings of noisy sensors for stuck ones."""
        known = {name: getattr(sensors, name) for name in _FROZEN_AFTER}
        return cls(noisy=frozenset(name for name, each in known.items() if each.noise > 0.5 * each.resolution))

    def update(self, measurements: Measurements, interval: float) -> None:
        """Take one sample. interval: nominal time between samples, s; ages grow by it while the clock stands still."""
        advanced = self._advance_clock(measurements.time, interval)
        for name in CHANNELS:
            raw = getattr(measurements, name)
            self.age[name] += self.step if self.step > 0.0 else interval
            if advanced and math.isfinite(raw) and abs(raw) <= _PLAUSIBLE[name] and not self._is_stuck(name, raw):
                self.value[name], self.age[name] = raw, 0.0

    def _is_stuck(self, name: str, raw: float) -> bool:
        """Whether a noisy channel has repeated its value for too long; its age then counts from the last change."""
        if name not in self.noisy:
            return False
        before = self._unchanged_for[name]
        self._unchanged_for[name] = before + self.step if raw == self.value[name] else 0.0
        if self._unchanged_for[name] < _FROZEN_AFTER[name]:
            self.stuck.discard(name)
            return False
        if name not in self.stuck:
            self.stuck.add(name)
            self.age[name] = self._unchanged_for[name]
        return True

    def fresh(self, channel: str) -> float:
        """Value of a channel in the last sample; NaN where that sample has none."""
        return self.value[channel] if self.age[channel] == 0.0 else math.nan

    def _advance_clock(self, time: float, interval: float) -> bool:
        self.jumped = False
        if not math.isfinite(time):
            self.step = 0.0
            self.clock_age += interval
            return False
        if math.isnan(self.time) or time > self.time:
            self._move_forward(time, _MAX_STEP * interval)
            return True
        self.step = 0.0
        self.clock_age += interval
        self._earlier_count = self._earlier_count + 1 if time > self._earlier_time else 0
        self._earlier_time = time
        if self._earlier_count >= _RESTART_SAMPLES:
            self.time, self.jumped, self._earlier_count, self._earlier_time = time, True, 0, math.nan
        return False

    def _move_forward(self, time: float, max_step: float) -> None:
        elapsed = 0.0 if math.isnan(self.time) else time - self.time
        self.time, self.step, self.clock_age = time, min(elapsed, max_step), 0.0
        self.jumped = elapsed > _JUMP
        if elapsed > max_step:
            # Values from before the gap are at least as old as the gap is long.
            self.age = {name: age + elapsed - self.step for name, age in self.age.items()}
