"""Loads a controller by its name, `module:Class`, and checks every call of a user's controller.

Whatever such a controller raises or returns wrongly becomes an InputError: one line that names the user's file and
line.
"""

from __future__ import annotations

import dataclasses
import math
import numbers
from typing import Any

from slider_drilling.control.interface import Controller, Level, Measurements, RigCommand, Status
from slider_drilling.control.settings import limits_of
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.schema.yaml_tree import shorten
from slider_drilling.user_code import call_user_code, import_reference

DEFAULT_CONTROLLER = "slider_drilling.control:SlideController"
_COMMANDED = tuple(field.name for field in dataclasses.fields(RigCommand))


def load_controller(name: str, rig: Rig) -> Controller:
    """Import `module:Class` and build it as `Class(rig)`; modules in the working directory are found too.

    Args:
        name: module:Class.
        rig: Rig file.

    Raises:
        InputError: The name cannot be imported, the constructor raises, there is no `step`, or the settings cannot be
            used. The message names the place in the user's file.
    """
    where = f"controller = {name!r}"
    kind: Any = import_reference(name, where, DEFAULT_CONTROLLER)
    controller = call_user_code(lambda: kind(rig), f"{where}: {name.partition(':')[2]}(rig)")
    if not callable(call_user_code(lambda: getattr(controller, "step", None), f"{where}: step")):
        raise InputError(f"{where}: has no method step(measurements) -> RigCommand")
    settings_of(controller)
    return controller


def checked_step(controller: Controller, measurements: Measurements) -> RigCommand:
    """Return the command of one step.

    Raises:
        InputError: The controller raises, or its command is not made of finite numbers.
    """
    what = _named(controller, f"step at {measurements.time:g} s")
    command = call_user_code(lambda: controller.step(measurements), what)
    if not isinstance(command, RigCommand):
        raise InputError(f"{_named(controller, 'step')} returned {type(command).__name__}, not a RigCommand")
    values = {name: _number(getattr(command, name)) for name in _COMMANDED}
    for name, value in values.items():
        if value is None:
            what = f"{name} = {shorten(getattr(command, name))}"
            raise InputError(f"{_named(controller, f'step at {measurements.time:g} s')} returned {what}")
    return RigCommand(**values)  # type: ignore[arg-type]


def set_tool_face_target(controller: Controller, target: float) -> None:
    """Set the toolface target (rad) of a controller that has one.

    Raises:
        InputError: The target is not finite, or the controller refuses it.
    """
    if not math.isfinite(target):
        raise InputError(f"tool_face_target = {target}: must be a finite number of rad")
    if _has(controller, "tool_face_target"):
        call_user_code(lambda: setattr(controller, "tool_face_target", target), _named(controller, "tool_face_target"))


def statuses_of(controller: Controller) -> tuple[Status, ...]:
    """Return what a controller reports; empty where it has no `status`.

    Raises:
        InputError: It returns anything but statuses.
    """
    if not _has(controller, "status"):
        return ()
    statuses = call_user_code(lambda: controller.status(), _named(controller, "status"))  # type: ignore[attr-defined]
    if not isinstance(statuses, (tuple, list)):
        raise InputError(f"{_named(controller, 'status')} returned {type(statuses).__name__}, not a tuple of Status")
    for status in statuses:
        if not (isinstance(status, Status) and isinstance(status.level, Level) and isinstance(status.name, str)
                and isinstance(status.message, str) and _are_pairs(status.values)):  # fmt: skip
            raise InputError(f"{_named(controller, 'status')} returned {shorten(status)}, which is not a Status of "
                             "strings")
    return tuple(statuses)


def settings_of(controller: Controller) -> Any:
    """Return a controller's settings, or None where it has none that can change.

    Raises:
        InputError: They are not a dataclass, or a value is out of its range.
    """
    if not (_has(controller, "settings") and _has(controller, "configure")):
        return None
    settings = call_user_code(lambda: controller.settings, _named(controller, "settings"))  # type: ignore[attr-defined]
    if not dataclasses.is_dataclass(settings) or isinstance(settings, type):
        raise InputError(f"{_named(controller, 'settings')} are {type(settings).__name__}, not a dataclass of settings")
    for name, limits in limits_of(settings).items():
        if not limits.low <= (_number(getattr(settings, name)) or 0.0) <= limits.high:
            what = f"settings.{name} = {shorten(getattr(settings, name))}"
            allowed = f"{limits.low:g} to {limits.high:g} {limits.unit}"
            raise InputError(f"{_named(controller, what)}: must be within {allowed}")
    return settings


def configure(controller: Controller, settings: Any) -> None:
    """Make a controller use these settings.

    Raises:
        InputError: The controller refuses them.
    """
    call_user_code(lambda: controller.configure(settings), _named(controller, "configure"))  # type: ignore[attr-defined]


def _has(controller: Controller, name: str) -> bool:
    """Whether there is such an attribute; one that raises counts, and its error shows when it is used."""
    try:
        return hasattr(controller, name)
    except Exception:
        return True


def _named(controller: Controller, what: str) -> str:
    return f"controller {type(controller).__name__}: {what}"


def _number(value: object) -> float | None:
    """The value as a float, or None where it is not a finite real number."""
    if not isinstance(value, numbers.Real) or isinstance(value, bool):
        return None
    try:
        number = float(value)
    except (OverflowError, ValueError):
        return None
    return number if math.isfinite(number) else None


def _are_pairs(values: object) -> bool:
    return isinstance(values, (tuple, list)) and all(
        isinstance(pair, (tuple, list)) and len(pair) == 2 and all(isinstance(word, str) for word in pair)
        for pair in values
    )
