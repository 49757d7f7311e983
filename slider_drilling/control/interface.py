"""The interface between a rig and its controller: measurements one way, commands the other.

Rig and controller import this module and neither imports the other, so any controller runs on any rig.

A controller is a class that is built as ``Class(rig)`` from a `slider_drilling.rig.Rig` and has `step` (`Controller`).
The node, the closed loop and ``--controller module:Class`` also use what the other three protocols name, where a
controller has it: a toolface target, settings that become ROS parameters, and a status for `diagnostics`.

SI units, angles in rad; times are rig (or simulation) seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from slider_drilling.messages.health import Level, Status

__all__ = ["AdjustableController", "Controller", "Level", "Measurements", "MwdSample", "ReportingController",
           "RigCommand", "Status", "TargetedController"]


@dataclass(frozen=True)
class MwdSample:
    """A toolface as decoded at surface.

    Attributes:
        measured_at: Time at which the tool was read downhole, s.
        arrived_at: Time at which surface received it, s.
        tool_face: rad, in (-pi, pi].
    """

    measured_at: float
    arrived_at: float
    tool_face: float


@dataclass(frozen=True)
class Measurements:
    """One sample of the surface channels; a missing channel is NaN.

    Attributes:
        time: s.
        top_drive_angle: rad.
        top_drive_speed: rad/s.
        surface_torque: Torque that the top drive feels, N m.
        block_position: Distance lowered since the start, m.
        block_speed: m/s, positive lowers.
        hook_load: N.
        standpipe_pressure: Pa.
        pump_speed: Crank speed of the mud pump, rad/s.
        mwd: Toolfaces that arrived since the last sample, oldest first.
    """

    time: float
    top_drive_angle: float
    top_drive_speed: float
    surface_torque: float
    block_position: float
    block_speed: float
    hook_load: float
    standpipe_pressure: float
    pump_speed: float
    mwd: tuple[MwdSample, ...] = ()


@dataclass(frozen=True)
class RigCommand:
    """Setpoints that hold until the controller's next command.

    Attributes:
        top_drive_angle: Angle reference for now, rad.
        top_drive_speed: Slope of that reference, rad/s.
        block_speed: m/s, positive lowers.
        pump_speed: Crank speed of the mud pump, rad/s.
    """

    top_drive_angle: float
    top_drive_speed: float
    block_speed: float
    pump_speed: float


@runtime_checkable
class Controller(Protocol):
    """What every controller must have."""

    def step(self, measurements: Measurements) -> RigCommand:
        """Return the command that holds until the next step; called once per sample of the surface channels."""
        ...


@runtime_checkable
class TargetedController(Controller, Protocol):
    """A controller that holds a toolface.

    Attributes:
        tool_face_target: rad; a plain attribute that follows the topic `tool_face/target` between steps.
    """

    tool_face_target: float


@runtime_checkable
class AdjustableController(Controller, Protocol):
    """A controller whose settings can change while it runs; they become ROS parameters."""

    @property
    def settings(self) -> Any:
        """The settings in use: a frozen dataclass of fields made with `control.settings.setting`."""
        ...

    def configure(self, settings: Any) -> None:
        """Use these settings from the next step on.

        Raises:
            InputError: The settings cannot be used; nothing has changed.
        """
        ...


@runtime_checkable
class ReportingController(Controller, Protocol):
    """A controller that publishes its state in `diagnostics`."""

    def status(self) -> tuple[Status, ...]:
        """The present state, interlocks included."""
        ...
