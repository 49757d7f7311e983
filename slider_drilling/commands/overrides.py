"""What `run --set` and `run --effect` change, and who is told of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.errors import InputError
from slider_drilling.schema.changes import parse_number

if TYPE_CHECKING:
    from slider_drilling.rig import Rig


@dataclass(frozen=True)
class ModifiedRig:
    """rig: path of the rig file that everybody is told of; plant: of the one simulated, "" if the same.

    settings: of the controller; notes: what was planted, for the log.
    """

    rig: str
    plant: str = ""
    settings: dict[str, float] = field(default_factory=dict)
    notes: str = ""


def apply_changes(
    rig_path: Path | None, sets: Sequence[str], effects: Sequence[str], controller: str | None, folder: Path
) -> ModifiedRig:
    """Make the rig files that are wanted, in ``folder``. Raises InputError.

    sets: ``KEY=VALUE`` of the rig file (mud.density=1100), which has a dot, or of the controller's settings.
    effects: what `with_effect` takes; only the plant has them, neither the controller nor the log's rig file.
    """
    from slider_drilling.api.rigs import load_rig
    from slider_drilling.api.with_effect import with_effect

    given = "" if rig_path is None else str(rig_path)
    rig = load_rig(rig_path)
    pairs = dict(_pair(text) for text in sets)
    keys = {name: value for name, value in pairs.items() if "." in name}
    own = {name: parse_number(value, f"--set {name}") for name, value in pairs.items() if "." not in name}
    if keys:
        rig = rig.with_({name: _value(value) for name, value in keys.items()})
        given = _write(rig, folder / "rig.set.yaml")
    _check_settings(own, controller, rig, "; keys of the rig file have a dot")
    plant = rig
    for effect in effects:
        plant = with_effect(plant, effect)
    path = _write(plant, folder / "rig.planted.yaml") if effects else ""
    return ModifiedRig(given, path, own, f"planted: {'; '.join(effects)}" if effects else "")


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name.strip() and equals and value.strip()):
        raise InputError(f"--set {text!r}: must be NAME=VALUE, such as mud.density=1100 or gain=1.5")
    return name.strip(), value.strip()


def _value(text: str) -> object:
    """A value as in a rig file, except that 1e5 is a number here."""
    import yaml

    try:
        return float(text)
    except ValueError:
        pass
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        raise InputError(f"--set: {text!r} is no value of a rig file") from None


def parse_settings(sets: Sequence[str], controller: str | None, rig: Rig) -> dict[str, float]:
    """Settings of the controller from ``NAME=VALUE``, tried on this rig. Raises InputError."""
    pairs = dict(_pair(text) for text in sets)
    settings = {name: parse_number(value, f"--set {name}") for name, value in pairs.items()}
    _check_settings(settings, controller, rig, "")
    return settings


def _check_settings(settings: dict[str, float], controller: str | None, rig: Rig, hint: str) -> None:
    from slider_drilling.control.controller_loader import DEFAULT_CONTROLLER, load_controller
    from slider_drilling.control.interface import AdjustableController
    from slider_drilling.control.settings import limits_of

    if not settings:
        return
    name = controller or DEFAULT_CONTROLLER
    built = load_controller(name, rig)
    known = limits_of(built.settings) if isinstance(built, AdjustableController) else {}
    for one in settings:
        if one not in known:
            there = f"its settings: {', '.join(known)}" if known else "it has no settings"
            raise InputError(f"--set {one}: no setting of {name}; {there}{hint}")
    if isinstance(built, AdjustableController):
        built.configure(dataclasses.replace(built.settings, **settings))


def _write(rig: Rig, path: Path) -> str:
    from slider_drilling.files.output_files import write_atomically
    from slider_drilling.rig import dump_rig

    write_atomically(path, dump_rig(rig).encode("utf-8"))
    return str(path)
