"""A slide as a step: lift the bit, orient, drill at the toolface, lift the bit while the top drive parks."""

from __future__ import annotations

import enum
import math
from dataclasses import replace

from slider_drilling.control.interface import Measurements, RigCommand, Status
from slider_drilling.control.slide_controller import SlideController
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.programmes.limit_guard import LimitGuard, LimitReached
from slider_drilling.programmes.limits import CompleteLimits
from slider_drilling.programmes.motion import DriveStates
from slider_drilling.programmes.motion_execution import MotionExecution, stopping_motion
from slider_drilling.programmes.steps import Slide
from slider_drilling.programmes.surface_state import SurfaceState
from slider_drilling.rig import Rig

# Shares of the programme's limits within which the slide's own controller steers.
_TORQUE_SHARE, _TORQUE_CLEAR, _WEIGHT_SHARE, _PRESSURE_SHARE = 0.9, 300.0, 0.85, 0.8
_MIN_STALL_SHARE, _STALL_SHARE = 0.2, 0.85
_CLEARANCE = 1.5  # m above the position at which the bit touches bottom, to which the block lifts it
_SET_SHARE, _SET_TIME = 0.6, 30.0  # of the tolerance, and s within it, for a toolface that counts as set
_TOLERANCE_CLEAR = math.radians(5.0)  # swing of the toolface within a rocking cycle
_SIGMAS = 2.0
_PARK_TIME = 120.0  # s, longest


class SlideStage(enum.Enum):
    """What a slide does now."""

    LIFT = "lift"
    ORIENT = "orient"
    DRILL = "drill"
    LEAVE = "leave"


class SlideExecution:
    """Runs one slide.

    Args:
        action: The slide.
        limits: Of the step.
        rig: Rig file.
        drives: Where the drives are.
        state: The surface channels, which are read before every call.
        guard: Of the limits.

    Attributes:
        stage: What it does now.
        tool_face_set: Time of the controller's clock at which the toolface counted as set, s; None before.
        tool_face_left: Time at which the bit is lifted after that, s; None before.
        done: Whether the slide is over and the bit lifted.
    """

    def __init__(
        self, action: Slide, limits: CompleteLimits, rig: Rig, drives: DriveStates, state: SurfaceState,
        guard: LimitGuard,
    ) -> None:  # fmt: skip
        self._action, self._limits, self._rig, self._state, self._guard = action, limits, rig, state, guard
        self._start, self._stage_time, self._within = drives, 0.0, 0.0
        self._controller: SlideController | None = None
        self._motion = self._lift(drives)
        self._command = RigCommand(drives.angle, drives.turning, drives.lowering, drives.pump)
        self.stage = SlideStage.LIFT
        self.tool_face_set: float | None = None
        self.tool_face_left: float | None = None
        self.done = False

    def advance(self, measurements: Measurements) -> LimitReached | None:
        """Take one sample; returns why the slide must be aborted, or None."""
        step = self._state.monitor.step
        self._stage_time += step
        if self.stage is SlideStage.LIFT:
            self._motion.advance(step)
            self._command = self._motion.command()
            if self._motion.done:
                self._controller = self._make_controller()
                self._enter(SlideStage.ORIENT)
            return self._guard.check_slide(self._limits, self._state, 0.0)
        controller = self._controller
        assert controller is not None
        command = replace(controller.step(measurements), pump_speed=self._start.pump)
        if self.stage is SlideStage.LEAVE:
            self._motion.advance(step)
            self._command = replace(command, block_speed=self._motion.command().block_speed)
            parked = controller.parked or self._stage_time > _PARK_TIME
            self.done = self._motion.done and parked
            return self._guard.check_slide(self._limits, self._state, 0.0)
        self._command = command
        fault = self._orient(controller, step) if self.stage is SlideStage.ORIENT else self._drill(controller)
        return fault or self._guard.check_slide(self._limits, self._state, controller.weight_on_bit)

    def command(self) -> RigCommand:
        """Setpoints for now."""
        return self._command

    @property
    def drives(self) -> DriveStates:
        """Where the drives are, by the commands and the measured block."""
        command = self._command
        start = replace(self._start, angle=command.top_drive_angle, turning=command.top_drive_speed,
                        lowering=command.block_speed, block_speed=0.0, pump=command.pump_speed)  # fmt: skip
        return self._state.measured(start)

    @property
    def time_left(self) -> float:
        """s of drilling and leaving that are left, by the rate that was asked for."""
        action, drilled = self._action, self._drilled
        if action.time is not None:
            return max(action.time - (self._stage_time if self.stage is SlideStage.DRILL else 0.0), 0.0)
        return max((action.length or 0.0) - drilled, 0.0) / action.rate_of_penetration

    def statuses(self) -> tuple[Status, ...]:
        """Those of the slide's controller."""
        return () if self._controller is None else self._controller.status()

    @property
    def _drilled(self) -> float:
        """New hole since the start of the slide, by the block, m."""
        return max(self._state.monitor.value["block_position"] - self._start.deepest, 0.0)

    def _lift(self, drives: DriveStates) -> MotionExecution:
        """The motion that stops the top drive and takes the bit off bottom."""
        bottom, height = self._state.bottom, drives.touching - drives.block
        lift = 0.0 if bottom is not None and bottom.surely_off else max(_CLEARANCE - height, 0.0)
        return MotionExecution(stopping_motion(drives, self._guard.braking, lift), self._state.interval)

    def _make_controller(self) -> SlideController:
        controller = SlideController(self._rig, self._settings(), self._action.tool_face)
        controller.start_off_bottom(self._start.touching, self._state.free_hook_load)
        return controller

    def _settings(self) -> SlideSettings:
        limits, motor = self._limits, self._rig.motor
        left = limits.pressure - self._state.pressure.circulating(self._start.pump)
        stall = min(_STALL_SHARE, max(_PRESSURE_SHARE * left / motor.max_pressure, _MIN_STALL_SHARE))
        return SlideSettings(
            make_up_torque_limit=_TORQUE_SHARE * limits.right_torque - _TORQUE_CLEAR,
            back_off_torque_limit=_TORQUE_SHARE * limits.left_torque - _TORQUE_CLEAR,
            weight_on_bit_limit=_WEIGHT_SHARE * limits.weight_on_bit,
            rate_of_penetration=self._action.rate_of_penetration, stall_share=stall, pump_speed=self._start.pump,
        )  # fmt: skip

    def _enter(self, stage: SlideStage) -> None:
        self.stage, self._stage_time = stage, 0.0

    def _orient(self, controller: SlideController, step: float) -> LimitReached | None:
        error = abs(controller.error) + _SIGMAS * controller.tool_face_sigma
        within = error < _SET_SHARE * self._limits.tool_face_tolerance and controller.drills
        self._within = self._within + step if within else 0.0
        if self._within >= _SET_TIME:
            self.tool_face_set = self._state.monitor.time
            self._enter(SlideStage.DRILL)
            return None
        target = math.degrees(self._action.tool_face)
        if self._stage_time > self._action.orient_time:
            return LimitReached("orient_time", f"the toolface of {target:.0f} deg was not set within "
                                f"{self._action.orient_time:.0f} s", True)  # fmt: skip
        if self._action.length is not None and self._drilled >= self._action.length:
            return LimitReached("length", f"{self._action.length:g} m were drilled before the toolface of "
                                f"{target:.0f} deg was set", True)  # fmt: skip
        return None

    def _drill(self, controller: SlideController) -> LimitReached | None:
        clear = max(_TOLERANCE_CLEAR, _SIGMAS * controller.tool_face_sigma)
        tolerance = self._limits.tool_face_tolerance
        if abs(controller.error) > tolerance - clear:
            off, known, most = (math.degrees(angle) for angle in (controller.error, clear, tolerance))
            message = (
                f"the toolface is {off:+.0f} deg from its target, known within {known:.0f} deg: it may leave the "
                f"tolerance of {most:.0f} deg"
            )
            return LimitReached("tool_face_tolerance", message, True)
        length, time = self._action.length, self._action.time
        if (length is not None and self._drilled >= length) or (time is not None and self._stage_time >= time):
            controller.configure(replace(controller.settings, rocking=0.0))
            self._motion = self._lift(self.drives)
            self.tool_face_left = self._state.monitor.time
            self._enter(SlideStage.LEAVE)
        return None
