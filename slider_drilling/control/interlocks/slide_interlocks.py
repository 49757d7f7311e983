"""Interlocks of a slide: what must hold before the block is lowered and the top drive turned.

Each interlock checks the age of its inputs, so losing a topic trips it. `Permission` is what remains to the controller.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.control.estimation.measurement_monitor import MeasurementMonitor
from slider_drilling.control.interface import Level, Status
from slider_drilling.control.interlocks.drive_following import DriveFollowing
from slider_drilling.control.interlocks.motor_stall import StallGuard, StallState
from slider_drilling.control.interlocks.torque_prediction import Stroke, TorquePredictor

MIN_RATE = 5.0        # Hz of the surface channels; at 3 Hz the toolface error doubles, at 2 Hz nothing is drilled
MIN_FLOW_SHARE = 0.3  # of the reference flow, below which the motor is not driven and nothing is lowered
HOLD_AFTER = 1.0      # s without a channel: stop lowering, hold the centre
STOP_AFTER = 10.0     # s without it: stop rocking
RESUME_AFTER = 3.0    # s of good data before lowering again
MWD_HOLD_AFTER = 150.0   # s without an MWD sample: stop lowering
_MAX_TRACKING_ERROR = 3.0   # rad between the top drive and its reference


@dataclass(frozen=True)
class Permission:
    """What the interlocks allow.

    Attributes:
        lower: The block may be lowered.
        pick_up: The bit must be lifted.
        rock: The top drive may rock; it must stop otherwise.
    """

    lower: bool
    pick_up: bool
    rock: bool


class Interlocks:
    """All interlocks of a slide.

    Args:
        make_up: Torque limit to the right, N m.
        back_off: Torque limit to the left, N m.
        stall: Handling of motor stalls.
        min_pump_speed: Crank speed below which the motor is not driven, rad/s.

    Attributes:
        drives: Whether block and pump follow their commands.
        torque_trips: Strokes cut short at a torque limit so far.
    """

    def __init__(self, make_up: float, back_off: float, stall: StallGuard, min_pump_speed: float):
        self.make_up = make_up
        self.back_off = back_off
        self.stall = stall
        self._min_pump_speed = min_pump_speed
        self.drives = DriveFollowing()
        self._healthy_for = 0.0
        self._predictor = TorquePredictor()
        self.torque_trips = 0
        self._trip_side = 0.0
        self._statuses: list[Status] = []

    def update(
        self, monitor: MeasurementMonitor, step: float, pressure: float, mwd_age: float, tracking_error: float,
        mwd_stuck: bool = False, mwd_jump: float = 0.0,
    ) -> Permission:  # fmt: skip
        """Check one sample.

        Args:
            monitor: Values and ages of the channels.
            step: Time since the last sample, s.
            pressure: Across the motor, Pa.
            mwd_age: Time since the last accepted toolface was read, s.
            tracking_error: Top-drive angle minus its reference, rad.
            mwd_stuck: Whether MWD repeats its reading.
            mwd_jump: By how much MWD has jumped lately without the string turning, rad.
        """
        self._statuses = []
        oldest = max(self._check_ages(monitor), monitor.clock_age)
        pump_speed = monitor.value["pump_speed"]
        circulating = math.isfinite(pump_speed) and pump_speed >= self._min_pump_speed
        # Without flow, standpipe pressure less circulation does not show the motor's load.
        known = monitor.age["standpipe_pressure"] <= HOLD_AFTER and circulating and self.drives.pump_follows
        self.stall.update(pressure, known, step)
        self._report_pump(circulating, pump_speed)
        self.drives.update_drive(tracking_error, step)
        follows = not abs(tracking_error) > _MAX_TRACKING_ERROR
        self._report_following(follows, tracking_error)
        self._report_block()
        self._report_mwd(mwd_age, mwd_stuck, mwd_jump)
        self._report_stall(pressure)
        healthy = (oldest <= HOLD_AFTER and circulating and follows and self.drives.pump_follows
                   and self.drives.block_follows)
        self._healthy_for = self._healthy_for + step if healthy else 0.0
        lower = (self._healthy_for >= RESUME_AFTER and self.stall.state is StallState.NONE
                 and mwd_age <= MWD_HOLD_AFTER and not mwd_stuck)
        return Permission(lower, self.stall.state is StallState.PICKING_UP, oldest <= STOP_AFTER)

    def must_reverse(self, torque_from_below: float, stroke: Stroke, step: float) -> bool:
        """Return whether the stroke must end now to stay below its torque limit.

        A stroke that does not yet move to its side is only observed.

        Args:
            torque_from_below: Surface torque less what the pipe takes at its present speed, N m, positive right.
            stroke: The stroke in progress.
            step: Time since the last sample, s.
        """
        side, peak = stroke.side, self._predictor.predict_peak(torque_from_below, stroke, step)
        if stroke.speed <= 0.0:
            return False
        limit = self.make_up if side > 0.0 else self.back_off
        over = math.isfinite(peak) and peak >= limit
        if over and self._trip_side != side:
            self.torque_trips += 1
        self._trip_side = side if over else (0.0 if self._trip_side == side else self._trip_side)
        return over

    def statuses(self) -> tuple[Status, ...]:
        """Every interlock with its reason, tripped or not."""
        torque = Status(
            Level.WARN if self._trip_side else Level.OK, "torque_limits",
            "stroke cut short at the torque limit" if self._trip_side else "torque within make-up and back-off limits",
            (("make_up_n_m", f"{self.make_up:.0f}"), ("back_off_n_m", f"{self.back_off:.0f}"),
             ("strokes_cut_short", str(self.torque_trips))))
        return (torque, *self._statuses)

    def _report(self, level: Level, name: str, message: str) -> None:
        self._statuses.append(Status(level, name, message))

    def _check_ages(self, monitor: MeasurementMonitor) -> float:
        """Report every channel and the clock; returns the age of the oldest channel, s."""
        oldest = 0.0
        for name, age in monitor.age.items():
            oldest = max(oldest, age)
            if name in monitor.stuck:
                self._report(Level.ERROR, name, f"stuck: the same reading for {age:.0f} s: treated as lost")
            elif age > STOP_AFTER:
                self._report(Level.ERROR, name, f"no valid sample for {age:.0f} s: rocking stopped")
            elif age > HOLD_AFTER:
                self._report(Level.WARN, name, f"no valid sample for {age:.1f} s: lowering stopped")
            else:
                self._report(Level.OK, name, "measured")
        if monitor.clock_age > HOLD_AFTER:
            level = Level.ERROR if monitor.clock_age > STOP_AFTER else Level.WARN
            self._report(level, "clock", f"time stamps have not advanced for {monitor.clock_age:.0f} s")
        else:
            self._report(Level.OK, "clock", "time stamps advance")
        return oldest

    def _report_pump(self, circulating: bool, pump_speed: float) -> None:
        if circulating and not self.drives.pump_follows:
            self._report(Level.ERROR, "circulation", f"the pump's counter shows {pump_speed:.2f} rad/s, another speed "
                         "than commanded: lowering stopped; check the counter, or give the setting pump_speed")
        elif circulating:
            self._report(Level.OK, "circulation", "mud flows through the motor")
        else:
            self._report(Level.WARN, "circulation", f"pump speed {pump_speed:.1f} rad/s is below "
                         f"{self._min_pump_speed:.1f} rad/s: lowering stopped")

    def _report_following(self, follows: bool, tracking_error: float) -> None:
        if follows and self.drives.drive_follows:
            self._report(Level.OK, "top_drive", "follows its reference")
        elif follows:
            self._report(Level.WARN, "top_drive", f"{self.drives.drive_offset:+.1f} rad off its reference on average: "
                         "check its encoder")
        else:
            self._report(Level.WARN, "top_drive", f"{tracking_error:+.1f} rad off its reference: lowering stopped")

    def _report_block(self) -> None:
        if self.drives.block_follows and self.drives.block_fault:
            self._report(Level.WARN, "block_following", self.drives.block_fault)
        elif self.drives.block_follows:
            self._report(Level.OK, "block_following", "the block moves as commanded")
        else:
            self._report(Level.ERROR, "block_following", f"the block has moved {self.drives.block_missing:.2f} m less "
                         "than commanded: lowering stopped; check drawworks and block position")

    def _report_mwd(self, age: float, stuck: bool, jump: float) -> None:
        if stuck:
            self._report(Level.ERROR, "mwd_tool_face", f"stuck: the same toolface for {age:.0f} s: lowering stopped")
        elif age > MWD_HOLD_AFTER:
            self._report(Level.WARN, "mwd_tool_face", f"no MWD toolface for {age:.0f} s: lowering stopped")
        elif jump:
            self._report(Level.WARN, "mwd_tool_face", f"MWD jumped by {math.degrees(jump):+.0f} deg, which torque and "
                         "top drive do not show: the toolface follows MWD; check it")
        else:
            self._report(Level.OK, "mwd_tool_face", f"last MWD toolface read {age:.0f} s ago")

    def _report_stall(self, pressure: float) -> None:
        state, limit = self.stall.state, self.stall.limit
        self._report(Level.OK if state is StallState.NONE else Level.ERROR, "motor_stall",
                     f"{state.value} ({pressure / 1e5:.1f} bar across the motor, limit {limit / 1e5:.1f} bar, "
                     f"{self.stall.count} stalls so far)")
