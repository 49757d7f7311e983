"""A controller by its name, `module:Class`, and every call of a user's own controller checked.

Whatever such a controller raises or hands back becomes an InputError, one line that names the user's file and line.
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
    """Import `module:Class` and build it as `Class(rig)`; modules beside the working directory are found too.

    Raises InputError, naming where in the user's file it went wrong, for a name that cannot be imported, a
    constructor that raises, an object without `step`, and settings or a status that cannot be used.
    """
    where = f"controller = {name!r}"
    kind: Any = import_reference(name, where, DEFAULT_CONTROLLER)
    controller = call_user_code(lambda: kind(rig), f"{where}: {name.partition(':')[2]}(rig)")
    if not callable(call_user_code(lambda: getattr(controller, "step", None), f"{where}: step")):
        raise InputError(f"{where}: has no method step(measurements) -> RigCommand")
    settings_of(controller)
    return controller


def checked_step(controller: Controller, measurements: Measurements) -> RigCommand:
    """One step. Raises InputError where the controller raises, or its command is not finite numbers."""
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
    """Tell a controller that holds a toolface which, rad; others are left alone. Raises InputError."""
    if not math.isfinite(target):
        raise InputError(f"tool_face_target = {target}: must be a finite number of rad")
    if _has(controller, "tool_face_target"):
        call_user_code(lambda: setattr(controller, "tool_face_target", target), _named(controller, "tool_face_target"))


def statuses_of(controller: Controller) -> tuple[Status, ...]:
    """What a controller reports, nothing where it does not. Raises InputError for anything but statuses."""
    if not _has(controller, "status"):
        return ()
    found = call_user_code(lambda: controller.status(), _named(controller, "status"))  # type: ignore[attr-defined]
    if not isinstance(found, (tuple, list)):
        raise InputError(f"{_named(controller, 'status')} returned {type(found).__name__}, not a tuple of Status")
    for one in found:
        if not (isinstance(one, Status) and isinstance(one.level, Level) and isinstance(one.name, str)
                and isinstance(one.message, str) and _are_pairs(one.values)):  # fmt: skip
            raise InputError(f"{_named(controller, 'status')} returned {shorten(one)}, which is no Status of texts")
    return tuple(found)


def settings_of(controller: Controller) -> Any:
    """A controller's settings, None where it has none that can change. Raises InputError for what are none."""
    if not (_has(controller, "settings") and _has(controller, "configure")):
        return None
    settings = call_user_code(lambda: controller.settings, _named(controller, "settings"))  # type: ignore[attr-defined]
    if not dataclasses.is_dataclass(settings) or isinstance(settings, type):
        raise InputError(f"{_named(controller, 'settings')} are {type(settings).__name__}, not a dataclass of settings")
    for name, limits in limits_of(settings).items():
        if not limits.low <= (_number(getattr(settings, name)) or 0.0) <= limits.high:
            what = f"settings.{name} = {shorten(getattr(settings, name))}"
            raise InputError(f"{_named(controller, what)}: not in its range")
    return settings


def configure(controller: Controller, settings: Any) -> None:
    """Have a controller use these settings. Raises InputError where it will not, or cannot."""
    call_user_code(lambda: controller.configure(settings), _named(controller, "configure"))  # type: ignore[attr-defined]


def _has(controller: Controller, name: str) -> bool:
    """Whether there is such an attribute; one that raises is there, and says so when it is used."""
    try:
        return hasattr(controller, name)
    except Exception:
        return True


def _named(controller: Controller, what: str) -> str:
    return f"controller {type(controller).__name__}: {what}"


def _number(value: object) -> float | None:
    """A finite number of any kind that numpy or Python has as a float, None for anything else."""
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
