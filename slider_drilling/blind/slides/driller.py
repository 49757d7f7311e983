"""Who runs a sealed slide: the controller or a crew that rocks by hand, and in between a driller with an operation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.blind.slides.crew import RockingChange, settings_at
from slider_drilling.blind.slides.operations import DURATIONS, Operation
from slider_drilling.control.fixed_rocking import FixedRocking, FixedRockingSettings
from slider_drilling.control.interface import Measurements, MwdSample, RigCommand
from slider_drilling.control.slide_controller import SlideController
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.drillstring.drives import DriveState
from slider_drilling.rig import Rig


class Driller:
    """Gives every command of a slide.

    After an operation that moved the drives the controller begins anew, with clock and drives at zero.

    Args:
        rig: The rig file.
        operations: In their order.
        target: Toolface at the start, rad.
        rocking: How a crew rocks by hand; empty where the controller slides.
    """

    def __init__(
        self, rig: Rig, operations: Sequence[Operation], target: float, rocking: Sequence[RockingChange] = ()
    ) -> None:
        self._rig, self._operations, self._target = rig, tuple(operations), target
        self._rocking, self._pump_speed = tuple(rocking), rig.reference_pump_speed
        self._started: set[str] = set()
        self._began = Measurements(0.0, 0.0, 0.0, math.nan, 0.0, 0.0, math.nan, math.nan, 0.0)
        self._controller = self._new_controller(0.0)
        self._operating = False

    def command(self, measured: Measurements, interval: float) -> RigCommand:
        """The command that follows a sample; interval: s until the next one."""
        time = measured.time + interval
        operation = next((each for each in self._operations if each.drives_at(time)), None)
        if self._operating and operation is None:
            self._began = measured
            self._controller = self._new_controller(time)
        self._operating = operation is not None
        self._begin(time)
        command = self._controller.step(self._relative(measured))
        angle = command.top_drive_angle + self._began.top_drive_angle
        command = replace(command, top_drive_angle=angle)
        if operation is None:
            return command
        drives = DriveState(
            measured.top_drive_angle, measured.top_drive_speed, measured.block_position, measured.block_speed,
            measured.pump_speed,
        )  # fmt: skip
        return operation.command(time, drives, command, interval)

    def _begin(self, time: float) -> None:
        """New targets, flows and ways of rocking take effect."""
        for each in self._operations:
            if DURATIONS[each.name] or each.start > time or each.name in self._started:
                continue
            self._started.add(each.name)
            if each.name == "flow":
                self._pump_speed = each.amount * self._rig.reference_pump_speed
            else:
                self._target += each.amount
                self._controller.tool_face_target = self._target
        self._configure(time)

    def _new_controller(self, time: float) -> SlideController | FixedRocking:
        if self._rocking:
            return FixedRocking(self._rig, self._by_hand(time), self._target)
        return SlideController(self._rig, replace(SlideSettings(), pump_speed=self._pump_speed), self._target)

    def _by_hand(self, time: float) -> FixedRockingSettings:
        return replace(settings_at(self._rocking, time), pump_speed=self._pump_speed)

    def _configure(self, time: float) -> None:
        """Give the controller the settings of now, where they have changed."""
        controller = self._controller
        if isinstance(controller, FixedRocking):
            if controller.settings != (settings := self._by_hand(time)):
                controller.configure(settings)
        elif controller.settings.pump_speed != self._pump_speed:
            controller.configure(replace(controller.settings, pump_speed=self._pump_speed))

    def _relative(self, measured: Measurements) -> Measurements:
        """A sample by the clock and the drives of the controller's beginning."""
        since = self._began.time
        return replace(
            measured, time=measured.time - since,
            top_drive_angle=measured.top_drive_angle - self._began.top_drive_angle,
            block_position=measured.block_position - self._began.block_position,
            mwd=tuple(
                MwdSample(each.measured_at - since, each.arrived_at - since, each.tool_face)
                for each in measured.mwd if each.measured_at > since
            ),
        )  # fmt: skip
