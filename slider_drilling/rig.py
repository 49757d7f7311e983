"""The rig file: everything that a simulation needs, as frozen dataclasses. Nothing else parses rig YAML.

Names and units are those of ``config/rig.example.yaml``: SI, and degrees for the survey's angles only.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import yaml

from slider_drilling.changes import changed
from slider_drilling.effects import Effects
from slider_drilling.errors import InputError
from slider_drilling.files import read_text
from slider_drilling.schema import build, plain, quantity

SCHEMA = "slider_drilling/rig/1"


@dataclass(frozen=True)
class FrictionInterval:
    """Friction is multiplied by factor from the interval above down to this measured depth."""

    to: float = quantity("m", above=0.0)
    factor: float = quantity("-", at_least=0.0)


@dataclass(frozen=True)
class Well:
    """Survey rows are (measured depth m, inclination deg, azimuth deg); name: what pages call the well."""

    survey: tuple[tuple[float, float, float], ...]
    hole_diameter: float = quantity("m", above=0.0)
    friction_intervals: tuple[FrictionInterval, ...] = ()
    name: str = ""


@dataclass(frozen=True)
class Mud:
    density: float = quantity("kg/m3", at_least=0.0, below=4000.0)
    sound_speed: float = quantity("m/s", above=100.0)


@dataclass(frozen=True)
class Section:
    name: str
    length: float = quantity("m", above=0.0)
    outer_diameter: float = quantity("m", above=0.0)
    inner_diameter: float = quantity("m", at_least=0.0)


@dataclass(frozen=True)
class String:
    """Sections from the surface down; their lengths add up to the bit's measured depth."""

    sections: tuple[Section, ...]
    density: float = quantity("kg/m3", above=0.0)
    youngs_modulus: float = quantity("Pa", above=0.0)
    shear_modulus: float = quantity("Pa", above=0.0)
    axial_damping: float = quantity("1/s", at_least=0.0)
    torsional_damping: float = quantity("1/s", at_least=0.0)

    @property
    def length(self) -> float:
        """Measured depth of the bit, m."""
        return math.fsum(section.length for section in self.sections)


@dataclass(frozen=True)
class Asperity:
    """The ellipsoid of paper eq. 6; orientation is the angle of its axis e3 from the hole's axis."""

    height: float = quantity("m", above=0.0)
    minor_axis: float = quantity("m", above=0.0)
    major_axis: float = quantity("m", above=0.0)
    shape_factor: float = quantity("-", above=0.0)
    orientation: float = quantity("rad", 0.0)


@dataclass(frozen=True)
class Contact:
    """shear_factor is f of paper eq. 1-5; stiffness is kt at the normal force reference_load."""

    asperity: Asperity
    shear_factor: float = quantity("-", at_least=0.0, below=1.0)
    stiffness: float = quantity("N/m", above=0.0)
    reference_load: float = quantity("N", above=0.0)
    dahl_exponent: float = quantity("-", 1.0, above=0.0)


@dataclass(frozen=True)
class Bit:
    """aggressiveness relates torque to weight; depth_of_cut_stiffness is N per m of depth of cut."""

    diameter: float = quantity("m", above=0.0)
    aggressiveness: float = quantity("-", at_least=0.0, at_most=3.0)
    depth_of_cut_stiffness: float = quantity("N/m", above=0.0)


@dataclass(frozen=True)
class Motor:
    torque_per_pressure: float = quantity("N m/Pa", above=0.0)
    displacement: float = quantity("m3/rev", above=0.0)
    leak: float = quantity("-", at_least=0.0, below=1.0)
    max_pressure: float = quantity("Pa", above=0.0)


@dataclass(frozen=True)
class MudPump:
    displacement: float = quantity("m3/rad", above=0.0)


@dataclass(frozen=True)
class Hydraulics:
    reference_pressure: float = quantity("Pa", at_least=0.0)
    reference_flow: float = quantity("m3/s", above=0.0)
    reference_density: float = quantity("kg/m3", above=0.0)
    lag: float = quantity("s", at_least=0.0)


@dataclass(frozen=True)
class TopDrive:
    max_speed: float = quantity("rad/s", above=0.0)
    max_acceleration: float = quantity("rad/s2", above=0.0)
    max_torque: float = quantity("N m", above=0.0)


@dataclass(frozen=True)
class Sensor:
    """Noise (one standard deviation), first-order lag in s and resolution, in the channel's own unit."""

    noise: float = quantity("-", at_least=0.0)
    lag: float = quantity("s", at_least=0.0)
    resolution: float = quantity("-", at_least=0.0)


@dataclass(frozen=True)
class Mwd:
    period: float = quantity("s", above=0.0)
    latency: float = quantity("s", at_least=0.0)
    noise: float = quantity("rad", at_least=0.0)
    resolution: float = quantity("rad", at_least=0.0)


@dataclass(frozen=True)
class Sensors:
    surface_torque: Sensor
    hook_load: Sensor
    standpipe_pressure: Sensor
    mwd: Mwd
    rate: float = quantity("Hz", above=0.0, at_most=1000.0)


@dataclass(frozen=True)
class Rig:
    """One rig file, see `load_rig`."""

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
    effects: Effects = Effects()

    def with_(self, changes: Mapping[str, Any] | None = None, /, **blocks: Any) -> Rig:
        """This rig with some values changed, checked as a rig file is.

        changes: path -> value, such as ``{"mud.density": 1100.0, "string.sections[0].length": 3900.0}``; blocks: the
        same as nested mappings, such as ``mud={"density": 1100.0}``. Raises InputError naming key, value and range.
        """
        return rig_of_tree(changed(plain(self), {**(changes or {}), **blocks}, "rig"))

    def __repr__(self) -> str:
        on = [field.name for field in fields(Effects) if getattr(self.effects, field.name) != field.default]
        return (
            f"Rig({self.string.length:g} m of string in a {self.well.hole_diameter:g} m hole, "
            f"effects: {', '.join(on) or 'none'})"
        )


def load_rig(path: str | os.PathLike[str]) -> Rig:
    """Read a rig file. Raises InputError naming file, key and value for anything that cannot be used."""
    return parse_rig(read_text(path, "rig file"), str(path))


def parse_rig(text: str, source: str = "rig") -> Rig:
    """A rig from YAML text; ``source`` names it in errors. Raises InputError."""
    try:
        raw = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise InputError(f"{source}: not YAML: {' '.join(str(error).split())}") from None
    return rig_of_tree(raw, source)


def rig_of_tree(tree: Any, source: str = "rig") -> Rig:
    """A rig from keys and values as YAML gives them; ``source`` names it in errors. Raises InputError."""
    rig = build(Rig, tree, source)
    _check_schema(rig, source)
    _check_well(rig, source)
    _check_string(rig, source)
    _check_asperity(rig, source)
    _check_effects(rig, source)
    return rig


def dump_rig(rig: Rig) -> str:
    """The rig as YAML that `parse_rig` takes back unchanged; effects that are all neutral are left out."""
    tree = plain(rig)
    effects = {name: block for name, block in tree.pop("effects").items() if block != plain(getattr(Effects(), name))}
    if effects:
        tree["effects"] = effects
    if not rig.well.name:
        del tree["well"]["name"]
    return yaml.safe_dump({"schema": tree.pop("schema"), **tree}, sort_keys=False)


def _check_schema(rig: Rig, source: str) -> None:
    if rig.schema != SCHEMA:
        raise InputError(f"{source}: schema = {rig.schema!r}: this version reads {SCHEMA!r}")


def _check_well(rig: Rig, source: str) -> None:
    survey = rig.well.survey
    if len(survey) < 2:
        raise InputError(f"{source}: well.survey: {len(survey)} station(s); give at least two")
    if survey[0][0] != 0.0:
        raise InputError(f"{source}: well.survey[0] = {survey[0][0]}: the first station must be at depth 0 m")
    for index, (depth, inclination, _) in enumerate(survey):
        where = f"{source}: well.survey[{index}]"
        if index and depth <= survey[index - 1][0]:
            raise InputError(f"{where} = {depth}: measured depth must increase from station to station")
        if not 0.0 <= inclination <= 180.0:
            raise InputError(f"{where} = {inclination}: inclination must be within 0 to 180 deg")
    length = rig.string.length
    if survey[-1][0] < length - 1e-6:
        raise InputError(
            f"{source}: well.survey: ends at {survey[-1][0]:g} m, the string reaches {length:g} m; add stations"
        )
    previous = 0.0
    for index, interval in enumerate(rig.well.friction_intervals):
        if interval.to <= previous:
            raise InputError(f"{source}: well.friction_intervals[{index}].to = {interval.to:g}: must increase")
        previous = interval.to
    if rig.well.friction_intervals and previous < length - 1e-6:
        raise InputError(
            f"{source}: well.friction_intervals: the last one ends at {previous:g} m, the string at {length:g} m"
        )


def _check_string(rig: Rig, source: str) -> None:
    if not rig.string.sections:
        raise InputError(f"{source}: string.sections: empty; give at least one section")
    for index, section in enumerate(rig.string.sections):
        where = f"{source}: string.sections[{index}]"
        if section.inner_diameter >= section.outer_diameter:
            raise InputError(
                f"{where}.inner_diameter = {section.inner_diameter:g}: not smaller than the outer diameter "
                f"{section.outer_diameter:g} m"
            )
        if section.outer_diameter >= rig.well.hole_diameter:
            raise InputError(
                f"{where}.outer_diameter = {section.outer_diameter:g}: does not fit the hole of "
                f"{rig.well.hole_diameter:g} m"
            )
    if rig.string.density <= rig.mud.density:
        raise InputError(
            f"{source}: string.density = {rig.string.density:g}: must exceed the mud's {rig.mud.density:g} kg/m3"
        )


def _check_effects(rig: Rig, source: str) -> None:
    """Effects that are switched on act somewhere on this string."""
    length, bed, tool = rig.string.length, rig.effects.cuttings_bed, rig.effects.axial_oscillation_tool
    if bed.factor != 1.0 and bed.bottom <= bed.top:
        raise InputError(
            f"{source}: effects.cuttings_bed.factor = {bed.factor:g}: lies nowhere, from top = {bed.top:g} to bottom = "
            f"{bed.bottom:g} m; give both in m of measured depth, bottom below top"
        )
    if bed.factor != 1.0 and bed.top >= length:
        raise InputError(f"{source}: effects.cuttings_bed.top = {bed.top:g}: below the string's end at {length:g} m")
    if tool.force > 0.0 and not 0.0 < tool.depth <= length:
        raise InputError(
            f"{source}: effects.axial_oscillation_tool.depth = {tool.depth:g}: give where in the string it sits, "
            f"above 0 and at most {length:g} m of measured depth"
        )


def _check_asperity(rig: Rig, source: str) -> None:
    asperity = rig.contact.asperity
    if asperity.minor_axis > asperity.major_axis:
        raise InputError(
            f"{source}: contact.asperity.minor_axis = {asperity.minor_axis:g}: larger than the major axis "
            f"{asperity.major_axis:g} m"
        )
