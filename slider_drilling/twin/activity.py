"""What the rig does: rocking, parked or turning, on bottom, pump on; since when, and whether it has settled.

A stretch of work lasts until the rig does something else: another mode, another flow, a pick-up. The detector compares
stretches of the same mode. Calibration is stricter: it also waits until the bit is loaded and steering is over.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.rig import Rig
from slider_drilling.twin.samples import Array

_MEMORY_S = 120.0
_STILL = 0.02  # rad/s, of a drive that is parked
_PARKED_S = 8.0  # without motion, after which a drive is parked
_TURNING_S, _TURNING_SHARE = 12.0, 0.7  # in one direction, and of the rocking period, after which a drive turns
_CENTRE_S, _CENTRE_SHIFT = 30.0, 3.0  # s, and rad by which the centre of the rocking moves in it: steering
_SETTLING_S = 60.0  # after a change of what the rig does, until the rig is calibrated again
_FADING_S = 30.0  # after it, in which no channel is compared
_STEERING_S = 30.0  # after it
_FLOW_CHANGE = 0.02  # of the flow
_PUMP_ON = 0.3  # of the reference flow
_LIFTED_M, _BLOCK_S = 0.05, 15  # by which a block picks up, m, and s over which it is averaged
OFF_BOTTOM = "off bottom"
"""Mode in which circulation alone is compared."""
_IDLE = {"hardly loaded": "the bit is hardly loaded", OFF_BOTTOM: "off bottom", "pump off": "pump off"}
_PERIODS_S = (6.0, 80.0)  # of rocking
_DEFAULT_WINDOW_S = 20.0
_CIRCULATING_WINDOW_S, _CIRCULATING_AFTER_S = 8.0, 7.0  # of circulation alone, and after what came before it
_MOVED_M = 0.002  # in a second, by which the block moves: a bit off bottom may touch it any time
_TOUCHED_S = 15.0  # before the plant's bit touches bottom, in which the rig's may have done so already
_LOADING_S, _LOAD_MEMORY_S = 300.0, 40  # after the bit came on bottom, in which it is loaded; seconds looked at
_LONGEST_LIFT_S = 20.0  # without weight, that a bit which stays on bottom may show within a rocking period
_STEADY_LOAD = 0.15  # of the weight on bit, within which it is steady
_SMALL_SHIFT = 1.0  # rad: smaller changes from period to period are jitter
_LEAST_SWING, _WIDER = 0.1, 0.1  # rad; share by which a swing exceeds all before: it reaches what has not been seen yet
_LIGHT, _LOADED = 0.12, 0.2  # of the largest load: the bit hardly drills below the first, until it exceeds the second


@dataclass(frozen=True)
class Activity:
    """What the rig does now.

    Attributes:
        mode: ``rocking``, ``parked``, ``turning``, ``hardly loaded``, ``off bottom`` or ``pump off``.
        settled: Whether the rig can be calibrated with what the channels show.
        why: In words, where it cannot.
        period: s, of the rocking; of other work a stretch to average over.
        stretch: Number of the stretch of work.
        stretch_start: s, when that began.
        comparable: Whether a window of one period belongs to the stretch alone, with the bit on bottom and the pump on.
        circulating: Whether it belongs to circulation alone: off bottom, and the pump is steady.
        hanging: Whether the string hangs still, too.
        circulation_known: Whether what circulation has shown can be compared: the string hangs still, so that the bit
            cannot touch bottom unseen, or work off bottom has just ended.
        valid_until: s; what was seen after it, up to now, belongs to another stretch although it looked so then.
        load: Weight on bit over the last rocking period, of its largest.
        steering: How far the centre of the rocking has moved so far, rad; small moves count by their squares.
        swing: Logarithm of how far the drive swings, rad.
    """

    mode: str
    settled: bool
    why: str
    period: float
    stretch: int
    stretch_start: float
    comparable: bool
    circulating: bool
    hanging: bool
    circulation_known: bool
    valid_until: float
    load: float = 0.0
    steering: float = 0.0
    swing: float = 0.0


class Travel:
    """How far something has moved: the sum of its changes from one rocking period to the next.

    Args:
        small: Changes up to this size count by their squares, larger ones by their size.

    Attributes:
        total: So far.
    """

    def __init__(self, small: float) -> None:
        self._small = small
        self.total = 0.0
        self._means: deque[float] = deque(maxlen=round(_PERIODS_S[1]))

    def add(self, mean: float, period: float) -> None:
        """Take the mean of the period, s, that ends now, once a second; NaN where it has none: it begins anew."""
        if math.isnan(mean):
            self._means.clear()
        else:
            self._means.append(mean)
        apart = max(round(period), 1)
        moved = self._means[-1] - self._means[-1 - apart] if len(self._means) > apart else 0.0
        self.total += moved**2 / (self._small + abs(moved)) / apart


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
        self._blocks: deque[float] = deque(maxlen=_BLOCK_S)
        self._lowest = -np.inf  # m, lowest mean of the block so far, from which it is lifted
        self._block_moved_at = -np.inf
        self._unsettled = "the twin has just begun"
        self._unsettled_until: float | None = None
        self._mode = ""
        self._stretch, self._stretch_start = 0, -np.inf
        self._last_period, self._steered_until = _DEFAULT_WINDOW_S, -np.inf
        self._angles: deque[Array] = deque(maxlen=round(_PERIODS_S[1]) + 1)
        self._centres: deque[float] = deque(maxlen=round(_CENTRE_S))
        self._valid_until = np.inf
        self._loads: deque[float] = deque(maxlen=_LOAD_MEMORY_S)
        self._on_bottom_at = self._on_bottom_since = -np.inf
        self._steering = Travel(_SMALL_SHIFT)
        self._load, self._largest_load, self._light = 0.0, 1.0, False
        self._swing, self._widest = 0.0, -math.inf

    def update(self, commands: Commands, weight_on_bit: float) -> Activity:
        """Take the drives' motion of the last second and the plant's mean weight on bit in it, N."""
        now = float(commands.time[-1])
        if self._unsettled_until is None:
            self._unsettled_until, self._stretch_start = now + _SETTLING_S, now
            self._moved_at = self._turned_since = float(commands.time[0])
        self._valid_until = np.inf
        self._follow_drive(commands)
        self._follow_pump(commands, now)
        self._follow_block(commands, now)
        self._follow_load(weight_on_bit, now)
        mode = self._present_mode(now)
        ended = self._mode == OFF_BOTTOM != mode
        if mode != self._mode:
            self.disturb(now, _IDLE.get(mode, f"the rig is {mode}"))
            if mode in ("parked", "turning"):
                self._valid_until = self._moved_at if mode == "parked" else self._turned_since
            elif ended and mode != "pump off":
                self._valid_until = now - _TOUCHED_S
            self._mode = mode
        self._follow_centre(commands, now)
        why = self._why_unsettled(mode, now)
        period = self._period()
        comparable = mode not in _IDLE and now - self._stretch_start >= period + _FADING_S
        after = _CIRCULATING_WINDOW_S + _CIRCULATING_AFTER_S
        circulating = mode == OFF_BOTTOM and now - self._stretch_start >= after
        hanging = circulating and now - self._block_moved_at >= after
        return Activity(
            mode, not why, why, period, self._stretch, self._stretch_start, comparable, circulating, hanging,
            ended or hanging, self._valid_until, self._load, self._steering.total, self._swing,
        )  # fmt: skip

    def _why_unsettled(self, mode: str, now: float) -> str:
        """Why the rig cannot be calibrated now; empty if it can."""
        if mode in _IDLE:
            return _IDLE[mode]
        if self._unsettled_until is not None and now < self._unsettled_until:
            return self._unsettled
        return "the centre of the rocking moves" if now < self._steered_until else ""

    def disturb(self, now: float, why: str) -> None:
        """End the stretch of work now, s, for a reason in words."""
        self._stretch, self._stretch_start = self._stretch + 1, now
        self._unsettle(now, why)

    def _unsettle(self, now: float, why: str) -> None:
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
        self._angles.append(commands.top_drive_angle)
        interval = float(commands.time[1] - commands.time[0])
        recent = np.concatenate(list(self._angles)[-math.ceil(self._last_period) - 1 :])
        recent = recent[-max(round(self._last_period / interval), 1) :]
        centre, self._swing = float(np.mean(recent)), math.log(max(float(np.ptp(recent)), _LEAST_SWING))
        if self._mode == "rocking" and self._centres and abs(centre - self._centres[0]) > _CENTRE_SHIFT:
            self._steered_until = now + _STEERING_S
        self._centres.append(centre)
        if self._mode == "rocking" and now >= self._stretch_start + self._last_period:
            self._notice_wider_swing(now)
        self._steering.add(centre if self._mode == "rocking" else math.nan, self._last_period)

    def _notice_wider_swing(self, now: float) -> None:
        """A swing that is wider than any before may turn what has been at rest: other work, until it has settled."""
        if self._swing > self._widest + _WIDER:
            if math.isfinite(self._widest):
                self.disturb(now, "the drive swings wider than before")
                self._valid_until = min(self._valid_until, now - 2.0 * self._last_period)
            self._widest = self._swing

    def _follow_pump(self, commands: Commands, now: float) -> None:
        share = float(np.mean(commands.pump_speed)) * self._rig.mud_pump.displacement
        share /= self._rig.hydraulics.reference_flow
        if self._flow is not None and abs(share - self._flow) > _FLOW_CHANGE * max(self._flow, 0.1):
            self.disturb(now, "the flow has changed")
            self._flow = share
        self._flow = share if self._flow is None else self._flow

    def _follow_block(self, commands: Commands, now: float) -> None:
        """Notice a pick-up: the block goes up for longer than a wave or a stroke lifts it."""
        self._blocks.append(float(np.mean(commands.block_position)))
        if abs(commands.block_position[-1] - commands.block_position[0]) > _MOVED_M:
            self._block_moved_at = now
        block = float(np.mean(self._blocks))
        if block < self._lowest - _LIFTED_M:
            self.disturb(now, "the string was picked up")
            self._valid_until = min(self._valid_until, now - len(self._blocks))
            self._lowest = block
        self._lowest = max(self._lowest, block)

    def _follow_load(self, weight_on_bit: float, now: float) -> None:
        """Whether the bit is on bottom, and loaded. Weight is compared over rocking periods: it swings within one."""
        if weight_on_bit > 0.0:
            self._on_bottom_at = now
        if self._off_bottom(now):
            self._on_bottom_since = now
        self._loads.append(weight_on_bit)
        if math.isfinite(weight_on_bit):
            self._largest_load = max(self._largest_load, float(np.mean(self._loads)))
            self._load = float(np.mean(list(self._loads)[-max(round(self._last_period), 1) :])) / self._largest_load
            self._light = self._load < (_LOADED if self._light else _LIGHT)
        if now - self._on_bottom_since < _LOADING_S:
            half = len(self._loads) // 2
            loads = np.array(self._loads)
            steady = half and abs(np.mean(loads[:half]) - np.mean(loads[half:])) < _STEADY_LOAD * np.mean(loads)
            if not steady or half < _LOAD_MEMORY_S // 2:
                self._unsettle(now, "the bit is being loaded")

    def _off_bottom(self, now: float) -> bool:
        """Without weight for a whole rocking period: a momentary lift is none."""
        return now - self._on_bottom_at >= min(self._last_period, _LONGEST_LIFT_S)

    def _present_mode(self, now: float) -> str:
        if self._flow is not None and self._flow < _PUMP_ON:
            return "pump off"
        if self._off_bottom(now):
            return OFF_BOTTOM
        if self._light:
            return "hardly loaded"
        if now - self._moved_at > _PARKED_S:
            return "parked"
        if now - self._turned_since > max(_TURNING_S, _TURNING_SHARE * self._last_period):
            return "turning"
        return "rocking"

    def _period(self) -> float:
        if self._mode == OFF_BOTTOM:
            return _CIRCULATING_WINDOW_S
        if self._mode != "rocking" or len(self._reversals) < 3:
            return _DEFAULT_WINDOW_S
        strokes = np.diff(np.array(self._reversals))
        period = 2.0 * float(np.median(strokes[strokes > 1.0])) if (strokes > 1.0).any() else _DEFAULT_WINDOW_S
        self._last_period = float(np.clip(period, *_PERIODS_S))
        return self._last_period
