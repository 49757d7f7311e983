"""What the node, the closed loop and `--controller module:Class` expect of a controller.

A controller is built as `Class(rig)` from a `slider_drilling.rig.Rig` and needs `step`. The rest is used
where it is there: `tool_face_target` (a plain attribute, rad) follows the topic `tool_face/target`;
`settings` (a frozen dataclass made with `control.settings.setting`) becomes ROS parameters, a change of
which calls `configure`; `status` is published in `diagnostics`.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from slider_drilling.control.interface import Measurements, RigCommand
from slider_drilling.messages.health import Level, Status

__all__ = ["AdjustableController", "Controller", "Level", "ReportingController", "Status", "TargetedController"]


@runtime_checkable
class Controller(Protocol):
    """The least a controller is."""

    def step(self, measurements: Measurements) -> RigCommand:
        """The command that holds until the next step; called once a sample of the surface channels."""
        ...


@runtime_checkable
class TargetedController(Controller, Protocol):
    """A controller that holds a toolface. tool_face_target: rad, may be set between any two steps."""

    tool_face_target: float


@runtime_checkable
class AdjustableController(Controller, Protocol):
    """A controller whose settings can change while it runs."""

    @property
    def settings(self) -> Any:
        """The settings in use, a frozen dataclass."""
        ...

    def configure(self, settings: Any) -> None:
        """Use these settings from the next step on. Raises InputError, changing nothing, if they cannot be."""
        ...


@runtime_checkable
class ReportingController(Controller, Protocol):
    """A controller that says how it fares."""

    def status(self) -> tuple[Status, ...]:
        """The present state, interlocks included."""
        ...
