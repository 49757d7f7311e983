"""A controller by its name: `module:Class`, the user's own or one of this package's."""

from __future__ import annotations

import importlib
import importlib.util
import math
import sys
import traceback
from pathlib import Path

from slider_drilling.control.protocol import Controller
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.signals import Measurements, RigCommand

DEFAULT = "slider_drilling.control:SlideController"


def load_controller(name: str, rig: Rig) -> Controller:
    """Import `module:Class` and build it as `Class(rig)`; modules beside the working directory are found too.

    Raises InputError, naming where in the user's file it went wrong, for a name that cannot be imported, a
    constructor that raises, and an object without `step`.
    """
    module_name, colon, class_name = name.partition(":")
    if not (module_name and colon and class_name.isidentifier()):
        raise InputError(f"controller = {name!r}: must be module:Class, such as {DEFAULT}")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        kind = getattr(importlib.import_module(module_name), class_name)
    except Exception as error:
        raise InputError(f"controller = {name!r}: cannot be imported: {_told(error)}") from error
    try:
        controller = kind(rig)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"controller = {name!r}: {class_name}(rig) raised {_told(error)}") from error
    if not isinstance(controller, Controller):
        raise InputError(f"controller = {name!r}: has no method step(measurements) -> RigCommand")
    return controller


def step_checked(controller: Controller, measurements: Measurements) -> RigCommand:
    """One step. Raises InputError where the controller raises, or its command is not finite numbers."""
    name = type(controller).__name__
    try:
        command = controller.step(measurements)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"controller {name}: step at {measurements.time:g} s raised {_told(error)}") from error
    if not isinstance(command, RigCommand):
        raise InputError(f"controller {name}: step returned {type(command).__name__}, not a RigCommand")
    for quantity in ("top_drive_angle", "top_drive_speed", "block_speed", "pump_speed"):
        value = getattr(command, quantity)
        if not (isinstance(value, (int, float)) and math.isfinite(value)):
            raise InputError(f"controller {name}: step at {measurements.time:g} s returned {quantity} = {value}")
    return command


def _told(error: Exception) -> str:
    """The error in one line, with the innermost line of code that is not this package's machinery."""
    frames = traceback.extract_tb(error.__traceback__)
    last = frames[-1] if frames else None
    where = "" if last is None or last.filename == __file__ else f" at {Path(last.filename).name}:{last.lineno}"
    return f"{type(error).__name__}: {error}{where}"
