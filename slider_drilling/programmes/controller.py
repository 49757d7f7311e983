"""The controller that runs a programme: its steps, its limits, the interlocks, and a safe abort."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import replace

from slider_drilling.control.interface import Level, Measurements, RigCommand, Status
from slider_drilling.control.interlocks.motor_stall import StallGuard
from slider_drilling.control.interlocks.slide_interlocks import HOLD_AFTER, MIN_FLOW_SHARE, Interlocks
from slider_drilling.errors import InputError
from slider_drilling.programmes.limit_guard import LimitGuard, LimitReached
from slider_drilling.programmes.limits import complete
from slider_drilling.programmes.motion import DriveStates
from slider_drilling.programmes.motion_execution import MotionExecution, stopping_motion
from slider_drilling.programmes.open_loop import SETTLING
from slider_drilling.programmes.plan_motion import plan_motion
from slider_drilling.programmes.programme import Programme
from slider_drilling.programmes.progress import ProgrammeProgress, ProgrammeState, StepRecord
from slider_drilling.programmes.rig_check import nominal_times
from slider_drilling.programmes.slide_execution import SlideExecution
from slider_drilling.programmes.steps import Slide
from slider_drilling.programmes.surface_state import SurfaceState
from slider_drilling.rig import Rig

_STALL_SHARE, _RELEASED_SHARE = 0.85, 0.1
_TARE_FLOW_SHARE = 0.8  # of the reference flow, below which pressure is not tared
_LIFT = 0.5  # m, beyond the stretch that the weight gives, by which an abort lifts the bit


class ProgrammeController:
    """Runs a programme step by step.

    It begins with the string hanging free at the reference flow: a rest of three seconds tares hook load and pressure.
    A step that is about to exceed a limit is aborted: block and top drive stop, and where the limit is one of weight,
    pressure or toolface the bit is lifted. Nothing follows an abort.

    Args:
        rig: Rig file.
        programme: The programme.
        source: Names the programme in errors and statuses.

    Raises:
        InputError: The rig cannot run the programme, or not within its limits.
    """

    def __init__(self, rig: Rig, programme: Programme, source: str = "programme") -> None:
        self._rig, self._programme, self._source = rig, programme, source
        self._times = nominal_times(programme, rig, source)
        self._limits = tuple(complete(step.limits, programme.limits, rig) for step in programme.steps)
        self._surface = SurfaceState(rig, programme.bit_height)
        self._guard = LimitGuard(rig, self._surface.interval)
        self._reference_pump = rig.reference_pump_speed
        stall = StallGuard(_STALL_SHARE * rig.motor.max_pressure, _RELEASED_SHARE * rig.motor.max_pressure)
        first = self._limits[0]
        self._interlocks = Interlocks(first.right_torque, first.left_torque, stall,
                                      MIN_FLOW_SHARE * self._reference_pump)  # fmt: skip
        self._state, self._reason, self._asked = ProgrammeState.TARING, "", ""
        self._taring_for = 0.0
        self._index = -1
        self._records: list[StepRecord] = []
        self._execution: MotionExecution | SlideExecution | None = None
        self._command = RigCommand(0.0, 0.0, 0.0, self._reference_pump)

    @property
    def ended(self) -> bool:
        """Whether all steps are done, or one was aborted and the rig stands still."""
        still = not isinstance(self._execution, MotionExecution) or self._execution.done
        return self._state.ended and still

    @property
    def longest_time(self) -> float:
        """Time within which the programme ends, s: twice the nominal one, and what orienting may take at most."""
        orienting = sum(step.action.orient_time for step in self._programme.steps if isinstance(step.action, Slide))
        return SETTLING + 2.0 * sum(self._times) + orienting + 60.0

    @property
    def held_tool_face(self) -> float | None:
        """Toolface that the present step holds, rad; None where it holds none."""
        action = self._programme.steps[self._index].action if 0 <= self._index < len(self._times) else None
        return action.tool_face if isinstance(action, Slide) and self._state is ProgrammeState.RUNNING else None

    def abort(self, reason: str = "asked for") -> str:
        """End the programme safely at the next step; returns what happens."""
        if self._state.ended:
            return f"nothing to abort: {self.progress()}"
        self._asked = reason
        return "the programme is aborted"

    def step(self, measurements: Measurements) -> RigCommand:
        """Return the setpoints until the next sample."""
        self._surface.read(measurements, self._state is ProgrammeState.TARING)
        if self._state is ProgrammeState.TARING:
            self._command = self._tare()
        else:
            fault = self._check_interlocks()
            if self._state is ProgrammeState.RUNNING:
                fault = self._advance(measurements) or fault
                if self._asked:
                    fault = LimitReached("abort", self._asked, False)
                if fault is not None:
                    self._abort(fault)
            elif isinstance(self._execution, MotionExecution):
                # Stopping goes on where the stamps stand still.
                self._execution.advance(self._surface.monitor.step or self._surface.interval)
            if self._execution is not None:
                self._command = self._execution.command()
        return self._command

    def progress(self) -> ProgrammeProgress:
        """How far the programme is."""
        action = self._programme.steps[self._index].key if 0 <= self._index < len(self._times) else ""
        execution = self._execution
        stage = execution.stage.value if isinstance(execution, SlideExecution) else ""
        left = 0.0 if self._state.ended else sum(self._times[self._index + 1 :])
        if self._state is ProgrammeState.TARING:
            left += max(SETTLING - self._taring_for, 0.0)
        elif isinstance(execution, SlideExecution):
            left += execution.time_left
        elif execution is not None and not self._state.ended:
            left += max(execution.motion.duration - execution.elapsed, 0.0)
        number = min(self._index + 1, len(self._times))
        return ProgrammeProgress(self._state, number, len(self._times), action, stage, left, self._reason,
                                 tuple(self._records))  # fmt: skip

    def status(self) -> tuple[Status, ...]:
        """Progress, and every interlock with its reason."""
        progress = self.progress()
        level = {ProgrammeState.ABORTED: Level.ERROR}.get(self._state, Level.OK)
        message = str(progress)
        if self._state is ProgrammeState.TARING and self._surface.missing:
            level, message = Level.WARN, f"waiting for {self._surface.missing} before the first step"
        values = (("state", self._state.value), ("step", str(progress.step)), ("steps", str(progress.steps)),
                  ("action", progress.action), ("stage", progress.stage), ("time_left_s", f"{progress.time_left:.0f}"),
                  ("programme", self._programme.name or self._source))  # fmt: skip
        slide = self._execution.statuses() if isinstance(self._execution, SlideExecution) else ()
        return (Status(level, "programme", message, values), *(slide or self._interlocks.statuses()))

    def _tare(self) -> RigCommand:
        """Hold still and tare; begin the first step when that is over and every channel is there."""
        surface, value = self._surface, self._surface.monitor.value
        angle = value["top_drive_angle"]
        pump = value["pump_speed"] if math.isfinite(value["pump_speed"]) else self._reference_pump
        if self._taring_for == 0.0:
            self._command = RigCommand(angle if math.isfinite(angle) else 0.0, 0.0, 0.0, pump)
        if surface.missing:
            return self._command
        self._check_interlocks()
        if self._asked:
            self._abort(LimitReached("abort", self._asked, False))
            return self._command
        self._taring_for += surface.monitor.step
        if self._taring_for < SETTLING - 0.5 * surface.interval:
            return self._command
        if reason := self._refuse_to_start(pump):
            self._abort(LimitReached("start", reason, False))
            return self._command
        bottom = value["block_position"] + self._programme.bit_height
        drives = DriveStates(
            self._command.top_drive_angle, 0.0, value["block_position"], 0.0, 0.0, pump, bottom, bottom
        )
        self._begin(0, drives)
        return self._execution.command() if self._execution is not None else self._command

    def _refuse_to_start(self, pump: float) -> str:
        """Why the programme cannot start from here, or ""."""
        if pump < _TARE_FLOW_SHARE * self._reference_pump:
            return (f"the pump runs at {pump:.1f} rad/s; start it at {self._reference_pump:.1f} rad/s, the rig file's "
                    "reference flow, off bottom")  # fmt: skip
        if swing := self._surface.unsteady_hook_load:
            return (f"hook load changes by {swing / 1e3:.0f} kN while nothing moves, so weight cannot be tared: wait "
                    "until it is steady")  # fmt: skip
        if error := self._surface.pressure.tare_error:
            return (f"standpipe pressure is {100.0 * error:+.0f} % beside the rig file's: is the bit loaded? start off "
                    "bottom, or correct hydraulics.reference_pressure")  # fmt: skip
        return ""

    def _begin(self, index: int, drives: DriveStates) -> None:
        """Begin a step, or end the programme after the last."""
        self._index, time = index, self._surface.monitor.time
        if index == len(self._programme.steps):
            self._state = ProgrammeState.DONE
            motion = stopping_motion(drives, self._programme.drive_acceleration, 0.0)
            self._execution = MotionExecution(motion, self._surface.interval)
            return
        self._state = ProgrammeState.RUNNING
        step, limits = self._programme.steps[index], self._limits[index]
        self._interlocks.make_up, self._interlocks.back_off = limits.right_torque, limits.left_torque
        self._records.append(StepRecord(index + 1, step.key, time))
        if isinstance(step.action, Slide):
            self._execution = SlideExecution(step.action, limits, self._rig, drives, self._surface, self._guard)
            return
        where = f"{self._source}: steps[{index}].{step.key}"
        motion = plan_motion(step.action, drives, self._rig, self._programme.drive_acceleration, where)
        self._execution = MotionExecution(motion, self._surface.interval)

    def _advance(self, measurements: Measurements) -> LimitReached | None:
        """Go on by one sample, into the next step where one has ended; returns why it must be aborted, or None."""
        execution, step = self._execution, self._surface.monitor.step
        if isinstance(execution, SlideExecution):
            fault = execution.advance(measurements)
            self._records[-1] = replace(self._records[-1], tool_face_set=execution.tool_face_set,
                                        tool_face_left=execution.tool_face_left)  # fmt: skip
            if execution.done and fault is None:
                return self._next(execution.drives)
            return fault
        assert execution is not None
        execution.advance(step)
        if execution.done:
            over = execution.elapsed - execution.motion.duration
            fault = self._next(self._surface.measured(execution.motion.end))
            if fault is None and isinstance(self._execution, MotionExecution):
                self._execution.advance(max(over, 0.0))
            return fault
        turning = execution.command().top_drive_speed, execution.turning_at(2.0 * self._surface.interval)
        lowering = execution.command().block_speed
        return self._guard.check(self._limits[self._index], self._surface, turning, lowering)

    def _next(self, drives: DriveStates) -> LimitReached | None:
        """End this step and begin the next; returns why that cannot be begun, or None."""
        self._records[-1] = replace(self._records[-1], end=self._surface.monitor.time, outcome="done")
        try:
            self._begin(self._index + 1, drives)
        except InputError as error:
            return LimitReached("step", str(error), False)
        return None

    def _check_interlocks(self) -> LimitReached | None:
        """Update the interlocks; returns why they stop what the programme does, or None."""
        surface, monitor, command = self._surface, self._surface.monitor, self._command
        interlocks = self._interlocks
        if not monitor.clock_age:
            interlocks.drives.update_pump(monitor.value["pump_speed"], command.pump_speed, monitor.step)
            interlocks.drives.update_block(monitor.fresh("block_position"), command.block_speed, monitor.step)
        off = monitor.value["top_drive_angle"] - command.top_drive_angle
        pressure = surface.pressure.quick if surface.motor_pressure_known else 0.0
        permission = interlocks.update(monitor, monitor.step or surface.interval, pressure, 0.0, off)
        if isinstance(self._execution, SlideExecution) and self._state is ProgrammeState.RUNNING:
            return None  # a slide has its own, and goes on after a stall
        if permission.pick_up:
            return LimitReached("motor_stall", "the motor stalls", True)
        moves = command.block_speed != 0.0 or command.top_drive_speed != 0.0
        oldest = max(*monitor.age.values(), monitor.clock_age)
        if not permission.rock or (moves and oldest > HOLD_AFTER):
            return self._tripped("a channel is lost")
        follows = interlocks.drives.pump_follows and interlocks.drives.block_follows and not abs(off) > 3.0
        if moves and not follows:
            return self._tripped("a drive does not follow its command")
        return None

    def _tripped(self, otherwise: str) -> LimitReached:
        """The first interlock that is not in order."""
        faults = [status for status in self._interlocks.statuses()
                  if status.level is not Level.OK and status.name not in ("torque_limits", "circulation")]  # fmt: skip
        first = faults[0] if faults else Status(Level.ERROR, "interlock", otherwise)
        return LimitReached(first.name, f"{first.name}: {first.message}", False)

    def _abort(self, fault: LimitReached) -> None:
        """Stop block and top drive, and lift the bit where the fault asks for it."""
        execution, surface = self._execution, self._surface
        self._state, self._reason = ProgrammeState.ABORTED, fault.message
        if self._records:
            self._records[-1] = dataclasses.replace(self._records[-1], end=surface.monitor.time, outcome=fault.message)
        command = self._command
        drives = DriveStates(command.top_drive_angle, command.top_drive_speed, 0.0, command.block_speed, 0.0,
                             command.pump_speed, 0.0, 0.0)  # fmt: skip
        if isinstance(execution, MotionExecution):
            drives = execution.drives()
        drives = surface.measured(drives)
        weight = max(surface.deficit, 0.0) if math.isfinite(surface.deficit) else 0.0
        lift = weight / self._rig.string.axial_stiffness + _LIFT if fault.pick_up else 0.0
        reduced = fault.limit == "pressure" and command.pump_speed > self._reference_pump
        motion = stopping_motion(drives, self._guard.braking, lift, self._reference_pump if reduced else None)
        self._execution = MotionExecution(motion, surface.interval)
