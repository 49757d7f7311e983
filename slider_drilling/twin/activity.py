"""What the rig does: rocking, parked or turning, on bottom, pump on; and whether that changed a moment ago."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.rig import Rig

_MEMORY_S = 120.0
_STILL = 0.02  # rad/s, of a drive that is parked
_PARKED_S = 8.0  # without motion, after which a drive is parked
_TURNING_S, _TURNING_SHARE = 12.0, 0.7  # in one direction, and of the rocking period, after which a drive turns
_CENTRE_S, _CENTRE_SHIFT = 30.0, 3.0  # s, and rad by which the centre of the rocking moves in it: steering
_SETTLING_S = 60.0  # after a change of what the rig does
_STEERING_S = 30.0  # after it
_FLOW_CHANGE = 0.02  # of the flow
_PUMP_ON = 0.3  # of the reference flow
_LIFTED_M = 0.05  # by which a block that goes up picks up
_PERIODS_S = (6.0, 80.0)  # of rocking
_DEFAULT_WINDOW_S = 20.0
_LOADING_S, _LOAD_MEMORY_S = 300.0, 40  # after the bit came on bottom, in which it is loaded; seconds looked at
_STEADY_LOAD = 0.15  # of the weight on bit, within which it is steady


@dataclass(frozen=True)
class Activity:
    """What the rig does now.

    Attributes:
        mode: ``rocking``, ``parked``, ``turning``, ``off bottom`` or ``pump off``.
        settled: Whether that has lasted long enough to judge what the channels show.
        why: In words, where it has not.
        period: s, of the rocking; of other work a stretch to average over.
        changes: How often the work has changed.
        valid_until: s; what was seen after it, up to now, belongs to no settled work although it looked so then.
    """

    mode: str
    settled: bool
    why: str
    period: float
    changes: int
    valid_until: float


class ActivityMonitor:
    """Follows what the rig does from the motion of its drives and from the plant beside it.

    Args:
        rig: The rig file.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._reversals: deque[float] = deque()
        self._direction = 0.0
        self._moved_at = self._turned_since = -np.inf
        self._flow: float | None = None
        self._highest = -np.inf  # m, lowest point of the block so far, from which it is lifted
        self._unsettled = "the twin has just begun"
        self._unsettled_until: float | None = None
        self._mode = ""
        self._changes = 0
        self._last_period, self._steered_until = _DEFAULT_WINDOW_S, -np.inf
        self._angles: deque[float] = deque(maxlen=round(_PERIODS_S[1]))
        self._centres: deque[float] = deque(maxlen=round(_CENTRE_S))
        self._valid_until = np.inf
        self._loads: deque[float] = deque(maxlen=_LOAD_MEMORY_S)
        self._on_bottom_since = -np.inf

    def update(self, commands: Commands, weight_on_bit: float) -> Activity:
        """Take the drives' motion of the last second and the plant's weight on bit then, N."""
        now = float(commands.time[-1])
        if self._unsettled_until is None:
            self._unsettled_until = now + _SETTLING_S
            self._moved_at = self._turned_since = float(commands.time[0])
        self._valid_until = np.inf
        self._follow_drive(commands)
        self._follow_pump(commands, now)
        self._follow_block(commands, now)
        mode = self._present_mode(commands, weight_on_bit, now)
        self._follow_load(weight_on_bit, now)
        if mode != self._mode:
            self.disturb(now, f"the rig is {mode}" if "off" not in mode else mode)
            if mode in ("parked", "turning"):
                self._valid_until = self._moved_at if mode == "parked" else self._turned_since
            self._mode = mode
        self._follow_centre(commands, now)
        idle = mode in ("off bottom", "pump off")
        steered, unsettled = now < self._steered_until, now < self._unsettled_until
        why = mode if idle else self._unsettled if unsettled else "the centre of the rocking moves" if steered else ""
        settled = not why
        return Activity(mode, settled, why, self._period(), self._changes, self._valid_until)

    def disturb(self, now: float, why: str) -> None:
        """Take the work as unsettled from now, s, for a reason in words."""
        if self._unsettled_until is not None and now >= self._unsettled_until:
            self._changes += 1
        self._unsettled, self._unsettled_until = why, now + _SETTLING_S

    def _follow_drive(self, commands: Commands) -> None:
        for time, speed in zip(commands.time, commands.top_drive_speed, strict=True):
            if abs(speed) <= _STILL:
                continue
            self._moved_at = float(time)
            if speed * self._direction < 0.0:
                self._reversals.append(float(time))
            if speed * self._direction <= 0.0:
                self._turned_since = float(time)
                self._direction = float(np.sign(speed))
        while self._reversals and self._reversals[0] < commands.time[-1] - _MEMORY_S:
            self._reversals.popleft()

    def _follow_centre(self, commands: Commands, now: float) -> None:
        """Notice steering: the mean angle of a rocking period moves."""
        self._angles.append(float(np.mean(commands.top_drive_angle)))
        recent = list(self._angles)[-max(round(self._last_period), 1) :]
        centre = float(np.mean(recent))
        if self._mode == "rocking" and self._centres and abs(centre - self._centres[0]) > _CENTRE_SHIFT:
            if now >= self._steered_until:
                self._valid_until = min(self._valid_until, now - _CENTRE_S)
            self._steered_until = now + _STEERING_S
        self._centres.append(centre)

    def _follow_pump(self, commands: Commands, now: float) -> None:
        share = float(np.mean(commands.pump_speed)) * self._rig.mud_pump.displacement
        share /= self._rig.hydraulics.reference_flow
        if self._flow is not None and abs(share - self._flow) > _FLOW_CHANGE * max(self._flow, 0.1):
            self.disturb(now, "the flow has changed")
            self._flow = share
        self._flow = share if self._flow is None else self._flow

    def _follow_block(self, commands: Commands, now: float) -> None:
        block = float(commands.block_position[-1])
        if block < self._highest - _LIFTED_M:
            self.disturb(now, "the string was picked up")
            self._highest = block
        self._highest = max(self._highest, block)

    def _follow_load(self, weight_on_bit: float, now: float) -> None:
        """Wait until the bit is loaded after it came on bottom."""
        if weight_on_bit <= 0.0:
            self._on_bottom_since = now
        self._loads.append(weight_on_bit)
        if now - self._on_bottom_since < _LOADING_S:
            half = len(self._loads) // 2
            loads = np.array(self._loads)
            steady = half and abs(np.mean(loads[:half]) - np.mean(loads[half:])) < _STEADY_LOAD * np.mean(loads)
            if not steady or half < _LOAD_MEMORY_S // 2:
                self.disturb(now, "the bit is being loaded")

    def _present_mode(self, commands: Commands, weight_on_bit: float, now: float) -> str:
        if self._flow is not None and self._flow < _PUMP_ON:
            return "pump off"
        if weight_on_bit <= 0.0:
            return "off bottom"
        if now - self._moved_at > _PARKED_S:
            return "parked"
        if now - self._turned_since > max(_TURNING_S, _TURNING_SHARE * self._last_period):
            return "turning"
        return "rocking"

    def _period(self) -> float:
        if self._mode != "rocking" or len(self._reversals) < 3:
            return _DEFAULT_WINDOW_S
        strokes = np.diff(np.array(self._reversals))
        period = 2.0 * float(np.median(strokes[strokes > 1.0])) if (strokes > 1.0).any() else _DEFAULT_WINDOW_S
        self._last_period = float(np.clip(period, *_PERIODS_S))
        return self._last_period
