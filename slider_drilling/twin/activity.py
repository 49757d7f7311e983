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
from slider_drilling.twin.bit_load import BitLoad
from slider_drilling.twin.rocking_motion import RockingMotion

_SETTLING_S = 60.0  # after a change of what the rig does, until the rig is calibrated again
_FADING_S = 30.0  # after it, in which no channel is compared
_STEERING_S = 30.0  # after it
_FLOW_CHANGE = 0.02  # of the flow
_PUMP_ON = 0.3  # of the reference flow
_LIFTED_M, _BLOCK_S = 0.05, 15  # by which a block picks up, m, and s over which it is averaged
OFF_BOTTOM = "off bottom"
"""Mode in which circulation alone is compared."""
_IDLE = {"hardly loaded": "the bit is hardly loaded", OFF_BOTTOM: "off bottom", "pump off": "pump off"}
_NEW_WORK = {"rocking": "rocking has just begun", "parked": "the drive has just parked",
             "turning": "turning has just begun"}  # fmt: skip
_CIRCULATING_WINDOW_S, _CIRCULATING_AFTER_S = 8.0, 7.0  # of circulation alone, and after what came before it
_MOVED_M = 0.002  # in a second, by which the block moves: a bit off bottom may touch it any time
_TOUCHED_S = 15.0  # before the plant's bit touches bottom, in which the rig's may have done so already


@dataclass(frozen=True)
class Activity:
    """What the rig does now.

    Attributes:
        mode: ``rocking``, ``parked``, ``turning``, ``hardly loaded``, ``off bottom`` or ``pump off``.
        settled: Whether the rig can be calibrated with what the channels show.
        why: In words, where it cannot.
        drilling: Whether it could, were it not for how the drive rocks: the bit is loaded, the pump steady.
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
        pace: Logarithm of the period, s.
    """

    mode: str
    settled: bool
    why: str
    drilling: bool
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
    pace: float = 0.0


class ActivityMonitor:
    """Follows what the rig does from the motion of its drives and from the plant beside it.

    Args:
        rig: The rig file.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._drive: RockingMotion | None = None
        self._bit = BitLoad()
        self._flow: float | None = None
        self._blocks: deque[float] = deque(maxlen=_BLOCK_S)
        self._lowest = -np.inf  # m, lowest mean of the block so far, from which it is lifted
        self._block_moved_at = -np.inf
        self._unsettled, self._unsettled_until = "the twin has just begun", -np.inf
        self._drilling_from = -np.inf
        self._steered_until = self._valid_until = -np.inf
        self._mode = ""
        self._stretch, self._stretch_start = 0, -np.inf

    def update(self, commands: Commands, weight_on_bit: float) -> Activity:
        """Take the drives' motion of the last second and the plant's mean weight on bit in it, N."""
        now = float(commands.time[-1])
        if self._drive is None:
            self._drive = RockingMotion(float(commands.time[0]))
            self._unsettled_until = self._drilling_from = now + _SETTLING_S
            self._stretch_start = now
        drive = self._drive
        self._valid_until = np.inf
        drive.add(commands)
        self._follow_pump(commands, now)
        self._follow_block(commands, now)
        self._bit.add(weight_on_bit, now, drive.period)
        if self._bit.is_rising(now):
            self._unsettle(now, "the bit is being loaded")
        ended = self._follow_mode(drive, now)
        self._follow_steering(drive, commands, now)
        why = self._why_unsettled(now)
        period = _CIRCULATING_WINDOW_S if self._mode == OFF_BOTTOM else drive.update_period(self._mode == "rocking")
        comparable = self._mode not in _IDLE and now - self._stretch_start >= period + _FADING_S
        after = _CIRCULATING_WINDOW_S + _CIRCULATING_AFTER_S
        circulating = self._mode == OFF_BOTTOM and now - self._stretch_start >= after
        hanging = circulating and now - self._block_moved_at >= after
        drilling = self._mode not in _IDLE and now >= self._drilling_from
        return Activity(
            self._mode, not why, why, drilling, period, self._stretch, self._stretch_start, comparable, circulating,
            hanging, ended or hanging, self._valid_until, self._bit.share, drive.travel, drive.swing, math.log(period),
        )  # fmt: skip

    def disturb(self, now: float, why: str) -> None:
        """End the stretch of work now, s, for a reason in words."""
        self._begin_stretch(now)
        self._unsettle(now, why)

    def _begin_stretch(self, now: float) -> None:
        self._stretch, self._stretch_start = self._stretch + 1, now

    def _unsettle(self, now: float, why: str) -> None:
        self._unsettled, self._unsettled_until = why, now + _SETTLING_S
        self._drilling_from = self._unsettled_until

    def _why_unsettled(self, now: float) -> str:
        """Why the rig cannot be calibrated now; empty if it can."""
        if self._mode in _IDLE:
            return _IDLE[self._mode]
        if now < self._unsettled_until:
            return self._unsettled
        return "the centre of the rocking moves" if now < self._steered_until else ""

    def _follow_mode(self, drive: RockingMotion, now: float) -> bool:
        """Begin another stretch where the rig does something else; whether work off bottom has ended."""
        mode = self._present_mode(drive, now)
        ended = self._mode == OFF_BOTTOM != mode
        if mode != self._mode:
            self.disturb(now, (_IDLE | _NEW_WORK)[mode])
            if mode in ("parked", "turning"):
                self._valid_until = drive.moved_at if mode == "parked" else drive.turned_since
            elif ended and mode != "pump off":
                self._valid_until = now - _TOUCHED_S
            self._mode = mode
        return ended

    def _present_mode(self, drive: RockingMotion, now: float) -> str:
        if self._flow is not None and self._flow < _PUMP_ON:
            return "pump off"
        if self._bit.off_bottom(now, drive.period):
            return OFF_BOTTOM
        return "hardly loaded" if self._bit.light else drive.mode(now)

    def _follow_steering(self, drive: RockingMotion, commands: Commands, now: float) -> None:
        """Notice steering, and a swing that may turn what has been at rest: other work, until it has settled."""
        rocking = self._mode == "rocking"
        if drive.follow_centre(rocking, float(commands.time[1] - commands.time[0])):
            self._steered_until = now + _STEERING_S
        if rocking and now >= self._stretch_start + drive.period and drive.swings_wider():
            self._begin_stretch(now)
            self._unsettled, self._unsettled_until = "the drive swings wider than before", now + _SETTLING_S
            self._valid_until = min(self._valid_until, now - 2.0 * drive.period)

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
