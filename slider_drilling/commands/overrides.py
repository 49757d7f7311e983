"""Rig files and settings that `run --set` and `run --effect` change."""

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
    """The rig files of a run.

    Attributes:
        rig: Path of the rig file that controller and log get; "" for the example well.
        plant: Path of the rig file that is simulated; "" if it is the same.
        settings: Settings of the controller.
        notes: Effects that were added, for the log.
    """

    rig: str
    plant: str = ""
    settings: dict[str, float] = field(default_factory=dict)
    notes: str = ""


def apply_changes(
    rig_path: Path | None, sets: Sequence[str], effects: Sequence[str], controller: str | None, folder: Path
) -> ModifiedRig:
    """Write the changed rig files.

    Args:
        rig_path: The rig file; None for the example well.
        sets: ``KEY=VALUE``, with a unit beside the number or without. A key with a dot is one of the rig file
            (mud.density=1100), others are settings of the controller.
        effects: As `with_effect` takes them. Only the simulated rig gets them.
        controller: ``module:Class`` of the controller; None for the default.
        folder: Folder for the files.

    Raises:
        InputError: A key or value cannot be used.
    """
    from slider_drilling.api.rigs import load_rig
    from slider_drilling.api.with_effect import with_effect

    nominal_path = "" if rig_path is None else str(rig_path)
    rig = load_rig(rig_path)
    texts = controller_settings(sets)
    keys = {name: value for name, value in map(_pair, sets) if name not in texts}
    if keys:
        rig = rig.with_({name: _value(value) for name, value in keys.items()})
        nominal_path = _write(rig, folder / "rig.set.yaml")
    settings = _read_settings(texts, controller, rig, "; keys of the rig file have a dot")
    plant = rig
    for effect in effects:
        plant = with_effect(plant, effect)
    path = _write(plant, folder / "rig.plant.yaml") if effects else ""
    return ModifiedRig(nominal_path, path, settings, f"effects: {'; '.join(effects)}" if effects else "")


def controller_settings(sets: Sequence[str]) -> dict[str, str]:
    """The settings of the controller among ``KEY=VALUE``. Raises InputError for a text that is neither."""
    return {name: value for name, value in map(_pair, sets) if "." not in name}


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name.strip() and equals and value.strip()):
        raise InputError(f"--set {text!r}: must be NAME=VALUE, such as mud.density=1100 or gain=1.5")
    return name.strip(), value.strip()


def _value(text: str) -> object:
    """Parse a value of the rig file; unlike in YAML, 1e5 is a number."""
    import yaml

    try:
        return float(text)
    except ValueError:
        pass
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        raise InputError(f"--set: {text!r} is not a value of a rig file") from None


def parse_settings(sets: Sequence[str], controller: str | None, rig: Rig) -> dict[str, float]:
    """Parse settings ``NAME=VALUE`` of the controller and check them on this rig. Raises InputError."""
    return _read_settings(dict(_pair(text) for text in sets), controller, rig, "")


def _read_settings(texts: dict[str, str], controller: str | None, rig: Rig, hint: str) -> dict[str, float]:
    from slider_drilling.control.controller_loader import DEFAULT_CONTROLLER, load_controller
    from slider_drilling.control.interface import AdjustableController
    from slider_drilling.control.settings import limits_of

    if not texts:
        return {}
    name = controller or DEFAULT_CONTROLLER
    built = load_controller(name, rig)
    known = limits_of(built.settings) if isinstance(built, AdjustableController) else {}
    for setting in texts:
        if setting not in known:
            options = f"its settings: {', '.join(known)}" if known else "it has no settings"
            raise InputError(f"--set {setting}: {name} has no such setting; {options}{hint}")
    settings = {name: parse_number(text, f"--set {name}", known[name].unit) for name, text in texts.items()}
    if isinstance(built, AdjustableController):
        built.configure(dataclasses.replace(built.settings, **settings))
    return settings


def _write(rig: Rig, path: Path) -> str:
    from slider_drilling.files.output_files import write_atomically
    from slider_drilling.rig import dump_rig

    write_atomically(path, dump_rig(rig).encode("utf-8"))
    return str(path)
