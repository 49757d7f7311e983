"""The rig: all blocks of a rig file together, read, checked, changed and written. Nothing else parses rig YAML."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from slider_drilling.effects import Effects
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.rig import relations
from slider_drilling.rig.assumptions import Assumption, put_assumptions, take_assumptions
from slider_drilling.rig.parts import (
    FLOW_EXPONENT,
    MAX_BLOCK_SPEED,
    Bit,
    Contact,
    DrawWorks,
    Hydraulics,
    Motor,
    Mud,
    MudPump,
    Sensors,
    String,
    TopDrive,
    Well,
)
from slider_drilling.schema.changes import apply_changes
from slider_drilling.schema.fields import NumberField, build_dataclass, not_in_file, number_fields, to_tree
from slider_drilling.schema.option_types import check_argument
from slider_drilling.schema.yaml_tree import parse_yaml

SCHEMA = "slider_drilling/rig/1"
MAX_BYTES = 1_000_000
"""Size of a rig file; one with ten thousand survey stations has half of it."""


@dataclass(frozen=True)
class Rig:
    """Everything that a simulation needs: one rig file, see `load_rig`.

    `assumed` lists its numbers that stand on no paper.
    """

    well: Well
    mud: Mud
    string: String
    contact: Contact
    bit: Bit
    motor: Motor
    mud_pump: MudPump
    hydraulics: Hydraulics
    top_drive: TopDrive
    sensors: Sensors
    schema: str = SCHEMA
    draw_works: DrawWorks = DrawWorks()
    effects: Effects = Effects()
    assumed: tuple[Assumption, ...] = not_in_file(())

    @property
    def circulating_pressure(self) -> float:
        """Standpipe pressure (Pa) at the reference flow with this mud and an idle motor (`model.md` section 4)."""
        return self.hydraulics.reference_pressure * (self.mud.density / self.hydraulics.reference_density)

    def circulation_at(self, pump_speed: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Standpipe pressure (Pa) that circulation alone needs, at a pump speed in rad/s (`model.md` section 4)."""
        flow = np.maximum(pump_speed, 0.0) * self.mud_pump.displacement
        return np.asarray(self.circulating_pressure * (flow / self.hydraulics.reference_flow) ** FLOW_EXPONENT)

    @property
    def max_block_speed(self) -> float:
        """Fastest block, m/s, either way."""
        return MAX_BLOCK_SPEED if self.draw_works.max_speed is None else self.draw_works.max_speed

    @property
    def max_pump_speed(self) -> float:
        """Fastest crank of the mud pump, rad/s."""
        limit = self.mud_pump.max_speed
        return 2.0 * self.reference_pump_speed if limit is None else limit

    @property
    def reference_pump_speed(self) -> float:
        """Crank speed of the mud pump at the reference flow, rad/s."""
        return self.hydraulics.reference_flow / self.mud_pump.displacement

    def with_(self, changes: Mapping[str, Any] | None = None, /, **blocks: Any) -> Rig:
        """This rig with some values changed, checked as a rig file is.

        Args:
            changes: Path to value, such as ``{"mud.density": 1100.0, "string.sections[0].length": 3900.0}``.
            **blocks: The same as nested mappings, such as ``mud={"density": 1100.0}``.

        Raises:
            InputError: Naming key, value and range of what a rig file could not hold.
        """
        check_argument(changes, Mapping | None, "rig: changes")
        return rig_from_tree(apply_changes(rig_tree(self), {**(changes or {}), **blocks}, "rig"))

    def __repr__(self) -> str:
        on = [field.name for field in fields(Effects) if getattr(self.effects, field.name) != field.default]
        return (
            f"Rig({self.string.length:g} m of string in a {self.well.hole_diameter:g} m hole, "
            f"effects: {', '.join(on) or 'none'})"
        )


def load_rig(path: str | os.PathLike[str]) -> Rig:
    """Read a rig file. Raises InputError naming file, key and value of what cannot be used."""
    return parse_rig(read_text(path, "rig file", MAX_BYTES), str(path))


def parse_rig(text: str, source: str = "rig") -> Rig:
    """A rig from YAML text; ``source`` names the text in errors. Raises InputError."""
    return rig_from_tree(parse_yaml(text, source), source)


def rig_from_tree(tree: Any, source: str = "rig") -> Rig:
    """A rig from keys and values as YAML gives them; ``source`` names them in errors. Raises InputError."""
    plain, assumed = take_assumptions(tree, _numbers(), source)
    rig = replace(build_dataclass(Rig, plain, source), assumed=assumed)
    _check_relations(rig, source)
    return rig


def rig_tree(rig: Rig) -> dict[str, Any]:
    """Keys and values of a rig as its file holds them; the inverse of `rig_from_tree`."""
    return put_assumptions(to_tree(rig), rig.assumed)


@cache
def _numbers() -> tuple[NumberField, ...]:
    return tuple(number_fields(Rig))


def check_rig(rig: Rig, source: str = "rig") -> Rig:
    """Check a rig that was made in code, and return it. Raises InputError as `parse_rig` does.

    The constructor does not check: fits try numbers that no file may hold, thousands of times a second.
    """
    rig_from_tree(rig_tree(rig), source)
    return rig


def check_duration(rig: Rig, duration: float, source: str) -> None:
    """Check that a run of ``duration`` s does not outlast an effect that changes with time. Raises InputError."""
    rate = rig.effects.friction_drift.rate
    if not math.isfinite(duration):
        raise InputError(f"{source}: a run of {duration} s: give a finite duration")
    if 1.0 + rate * duration <= 0.0:
        raise InputError(
            f"{source}: effects.friction_drift.rate = {rate:g}: leaves no friction after {-1.0 / rate:.0f} s, and the "
            f"run takes {duration:.0f} s; give a slower drift"
        )


def dump_rig(rig: Rig) -> str:
    """The rig as YAML that `parse_rig` reads back unchanged; effects that are switched off are left out."""
    tree = rig_tree(rig)
    off = Effects()
    effects = {name: block for name, block in tree.pop("effects").items() if block != to_tree(getattr(off, name))}
    if effects:
        tree["effects"] = effects
    if not tree["draw_works"]:
        del tree["draw_works"]
    if not rig.well.name:
        del tree["well"]["name"]
    for name in ("weight_factor", "contact_radius_factor"):
        if tree["string"][name] == 1.0:  # an assumed number is a mapping
            del tree["string"][name]
    return yaml.safe_dump({"schema": tree.pop("schema"), **tree}, sort_keys=False, width=120, default_flow_style=None)


def _check_relations(rig: Rig, source: str) -> None:
    if rig.schema != SCHEMA:
        raise InputError(f"{source}: schema = {rig.schema[:60]!r}: this version reads {SCHEMA!r}")
    relations.check_sections(rig.string, rig.well, source)
    relations.check_survey(rig.well, rig.string, source)
    relations.check_friction_intervals(rig.well, rig.string, source)
    relations.check_material(rig.string, rig.mud, source)
    relations.check_contact(rig.contact, source)
    relations.check_bit_and_motor(rig.bit, rig.motor, rig.well, source)
    relations.check_effects(rig.effects, rig.string, source)
