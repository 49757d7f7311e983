"""Interlocks: what must be true before the block is lowered, the top drive turned.

Each interlock looks at the age of what it needs, so one that loses its topic trips. `Permission` is what is left to
the control law.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from slider_drilling.control.interface import Level, Status
from slider_drilling.control.interlocks.measurement_monitor import MeasurementMonitor
from slider_drilling.control.interlocks.torque_prediction import Stroke, TorquePredictor

HOLD_AFTER = 1.0      # s without a channel: stop lowering, hold the centre
STOP_AFTER = 10.0     # s without it: stop rocking
RESUME_AFTER = 3.0    # s of good data before lowering again
MWD_HOLD_AFTER = 150.0   # s without an MWD sample: stop lowering
_BEHIND = 3.0            # rad between top drive and reference that are not tolerated
_STALL_CONFIRMED = 0.5   # s of stall pressure before picking up
_RELEASED_SHARE = 0.25   # of the pressure wanted: the bit has let go
_LETTING_GO = 2.0        # s
_PICK_UP_TIMEOUT = 120.0  # s


class StallState(enum.Enum):
    """Where the handling of a motor stall stands."""

    NONE = "no stall"
    SUSPECTED = "pressure spike: lowering stopped"
    PICKING_UP = "motor stalled: picking up"
    LETTING_GO = "bit is free: waiting for the motor to turn"


@dataclass(frozen=True)
class Permission:
    """What the interlocks leave: may the block be lowered, must it be lifted, may the drive rock, must it stop."""

    lower: bool
    pick_up: bool
    rock: bool


class StallGuard:
    """Pressure spike -> stop lowering -> pick up -> resume. limit: Pa, taken for a stall; released: Pa, bit free."""

    def __init__(self, limit: float, released: float):
        self.limit = limit
        self.released = released
        self.state = StallState.NONE
        self.count = 0
        self._since = 0.0

    def update(self, pressure: float, known: bool, step: float) -> None:
        """pressure: Pa across the motor, `known` while it is measured. A lost pressure keeps the state."""
        self._since += step
        if not known:
            return
        if self.state is StallState.NONE and pressure >= self.limit:
            self._enter(StallState.SUSPECTED)
        elif self.state is StallState.SUSPECTED:
            if pressure < 0.9 * self.limit:
                self._enter(StallState.NONE)
            elif self._since >= _STALL_CONFIRMED:
                self.count += 1
                self._enter(StallState.PICKING_UP)
        elif self.state is StallState.PICKING_UP and (pressure <= self.released or self._since >= _PICK_UP_TIMEOUT):
            self._enter(StallState.LETTING_GO)
        elif self.state is StallState.LETTING_GO and self._since >= _LETTING_GO:
            self._enter(StallState.NONE)

    def _enter(self, state: StallState) -> None:
        self.state, self._since = state, 0.0


class Interlocks:
    """All interlocks of a slide. make_up, back_off: N m."""

    def __init__(self, make_up: float, back_off: float, stall: StallGuard, least_pump_speed: float):
        self.make_up = make_up
        self.back_off = back_off
        self.stall = stall
        self._least_pump_speed = least_pump_speed
        self._good_for = 0.0
        self._trend = TorquePredictor()
        self.torque_trips = 0
        self._trip_side = 0.0
        self._reasons: list[tuple[Level, str, str]] = []

    def update(
        self, watch: MeasurementMonitor, step: float, pressure: float, mwd_age: float, behind: float
    ) -> Permission:
        """Judge one sample. step: s; pressure: Pa across the motor; mwd_age: s since a toolface was read; behind: rad
        between the top drive and what it was told."""
        self._reasons = []
        worst = max(self._stale(watch), watch.clock_age)
        pump = watch.value["pump_speed"]
        circulating = math.isfinite(pump) and pump >= self._least_pump_speed
        # Without flow, pressure less circulation says nothing of the motor.
        self.stall.update(pressure, watch.age["standpipe_pressure"] <= HOLD_AFTER and circulating, step)
        self._report_pump(circulating, pump)
        follows = not abs(behind) > _BEHIND
        self._report_following(follows, behind)
        self._report_mwd(mwd_age)
        self._report_stall(pressure)
        healthy = worst <= HOLD_AFTER and circulating and follows
        self._good_for = self._good_for + step if healthy else 0.0
        lower = self._good_for >= RESUME_AFTER and self.stall.state is StallState.NONE and mwd_age <= MWD_HOLD_AFTER
        return Permission(lower, self.stall.state is StallState.PICKING_UP, worst <= STOP_AFTER)

    def must_reverse(self, arriving: float, stroke: Stroke, step: float) -> bool:
        """Whether a stroke must end, or meet its torque limit. arriving: N m, of the torque, that comes from below: all
        but what the pipe takes at the speed that it is turned with; step: s since the last sample. A stroke that does
        not move to its side yet is only watched."""
        side, ahead = stroke.side, self._trend.predict_peak(arriving, stroke, step)
        if stroke.speed <= 0.0:
            return False
        limit = self.make_up if side > 0.0 else self.back_off
        over = math.isfinite(ahead) and ahead >= limit
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
        return (torque, *(Status(level, name, message) for level, name, message in self._reasons))

    def _stale(self, watch: MeasurementMonitor) -> float:
        worst = 0.0
        for name, age in watch.age.items():
            worst = max(worst, age)
            if age > STOP_AFTER:
                self._reasons.append((Level.ERROR, name, f"no valid sample for {age:.0f} s: rocking stopped"))
            elif age > HOLD_AFTER:
                self._reasons.append((Level.WARN, name, f"no valid sample for {age:.1f} s: lowering stopped"))
            else:
                self._reasons.append((Level.OK, name, "measured"))
        if watch.clock_age > HOLD_AFTER:
            level = Level.ERROR if watch.clock_age > STOP_AFTER else Level.WARN
            self._reasons.append((level, "clock", f"stamps have not advanced for {watch.clock_age:.0f} s"))
        else:
            self._reasons.append((Level.OK, "clock", "stamps advance"))
        return worst

    def _report_pump(self, circulating: bool, pump: float) -> None:
        if circulating:
            self._reasons.append((Level.OK, "circulation", "the motor is fed"))
        else:
            self._reasons.append((Level.WARN, "circulation",
                                  f"pump speed {pump:.1f} rad/s is below {self._least_pump_speed:.1f}: not lowering"))

    def _report_following(self, follows: bool, behind: float) -> None:
        if follows:
            self._reasons.append((Level.OK, "top_drive", "follows its reference"))
        else:
            self._reasons.append((Level.WARN, "top_drive", f"{behind:+.1f} rad off its reference: lowering stopped"))

    def _report_mwd(self, age: float) -> None:
        if age > MWD_HOLD_AFTER:
            self._reasons.append((Level.WARN, "mwd_tool_face", f"none for {age:.0f} s: lowering stopped"))
        else:
            self._reasons.append((Level.OK, "mwd_tool_face", f"last one read {age:.0f} s ago"))

    def _report_stall(self, pressure: float) -> None:
        state = self.stall.state
        level = Level.OK if state is StallState.NONE else Level.ERROR
        message = f"{state.value} ({pressure / 1e5:.1f} bar across the motor, limit {self.stall.limit / 1e5:.1f}, "
        self._reasons.append((level, "motor_stall", message + f"{self.stall.count} stalls so far)"))
