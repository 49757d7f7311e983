"""Everything that a simulation needs, as frozen dataclasses; each number with its unit, its range and what that is of.

Names and units are those of ``config/rig.example.yaml``: SI, and degrees for the survey's angles only.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from slider_drilling.effects import Effects
from slider_drilling.schema.changes import apply_changes
from slider_drilling.schema.fields import Range, nested, quantity, table, to_tree

SCHEMA = "slider_drilling/rig/1"
DEEPEST = 20_000.0
"""m; the longest wells have 15 km."""


def _depth(why: str = "the longest wells have 15 km") -> Range:
    return Range("m", at_least=0.0, at_most=DEEPEST, why=why)


def _reading(unit: str, most: float, what: str) -> dict[str, Range]:
    """Ranges of a `Sensor` whose channel has this unit and never reads more than ``most``."""
    amount = Range(unit, at_least=0.0, at_most=most, why=f"in {unit}, as the channel: a share of {what}")
    return {"noise": amount, "resolution": amount}


@dataclass(frozen=True)
class FrictionInterval:
    """Friction is multiplied by factor from the interval above down to this measured depth."""

    to: float = quantity("m", above=0.0, at_most=DEEPEST, why="measured depth; the longest wells have 15 km")
    factor: float = quantity("-", at_least=0.0, at_most=20.0, why="a multiple of the contact's own friction")


@dataclass(frozen=True)
class Well:
    """Survey rows are (measured depth m, inclination deg, azimuth deg); name: what pages call the well."""

    survey: tuple[tuple[float, float, float], ...] = table(
        **{
            "measured depth": _depth(),
            "inclination": Range("deg", at_least=0.0, at_most=180.0, why="0 is straight down, 90 horizontal"),
            "azimuth": Range("deg", at_least=-360.0, at_most=720.0, why="clockwise from north"),
        }
    )
    hole_diameter: float = quantity("m", at_least=0.05, at_most=1.5, why="bits of 2 to 60 in; 8 1/2 in is 0.2159 m")
    friction_intervals: tuple[FrictionInterval, ...] = ()
    name: str = ""


@dataclass(frozen=True)
class Mud:
    density: float = quantity("kg/m3", at_least=1.0, at_most=3000.0, why="air to the heaviest kill mud; 10 ppg is 1198")
    sound_speed: float = quantity("m/s", at_least=100.0, at_most=3000.0, why="gas-cut mud to brine; water has 1480")


@dataclass(frozen=True)
class StringSection:
    name: str
    length: float = quantity("m", at_least=0.3, at_most=DEEPEST, why="from the shortest sub to the longest well")
    outer_diameter: float = quantity("m", at_least=0.02, at_most=1.2, why="tubing to casing; 5 in is 0.127")
    inner_diameter: float = quantity("m", at_least=0.0, at_most=1.2, why="0 is a solid bar")


@dataclass(frozen=True)
class String:
    """Sections from the surface down; their lengths add up to the bit's measured depth."""

    sections: tuple[StringSection, ...]
    density: float = quantity("kg/m3", at_least=1500.0, at_most=20_000.0, why="carbon fibre to tungsten; steel 7850")
    youngs_modulus: float = quantity("Pa", at_least=1e10, at_most=5e11, why="in Pa, not GPa; steel 2.06e+11")
    shear_modulus: float = quantity("Pa", at_least=2e9, at_most=3e11, why="in Pa, not GPa; steel 7.92e+10")
    axial_damping: float = quantity("1/s", at_least=0.0, at_most=100.0, why="mud gives 0.1 to 1")
    torsional_damping: float = quantity("1/s", at_least=0.0, at_most=100.0, why="mud gives 0.1 to 1")

    @property
    def length(self) -> float:
        """Measured depth of the bit, m."""
        return math.fsum(section.length for section in self.sections)

    @property
    def axial_stiffness(self) -> float:
        """Of the whole string between block and bit, N/m."""
        compliance = sum(section.length / (math.pi / 4.0 * (section.outer_diameter**2 - section.inner_diameter**2))
                         for section in self.sections)  # fmt: skip
        return self.youngs_modulus / compliance

    @property
    def twist_speed(self) -> float:
        """At which a twist runs along it, m/s."""
        return math.sqrt(self.shear_modulus / self.density)


@dataclass(frozen=True)
class Asperity:
    """The ellipsoid of paper eq. 6; orientation is the angle of its axis e3 from the hole's axis."""

    height: float = quantity("m", at_least=1e-9, at_most=1e-2, why="roughness of steel and rock: um")
    minor_axis: float = quantity("m", at_least=1e-9, at_most=1e-1, why="roughness of steel and rock: um")
    major_axis: float = quantity("m", at_least=1e-9, at_most=1e-1, why="roughness of steel and rock: um")
    shape_factor: float = quantity("-", at_least=0.01, at_most=100.0, why="chi of eq. 6; an ellipse has pi")
    orientation: float = quantity("rad", 0.0, at_least=-6.2832, at_most=6.2832, why="one turn either way; in rad")


@dataclass(frozen=True)
class Contact:
    """shear_factor is f of paper eq. 1-5; stiffness is kt at the normal force reference_load."""

    asperity: Asperity
    shear_factor: float = quantity("-", at_least=0.0, below=1.0, why="shear strength of the film over that of the wall")
    stiffness: float = quantity("N/m", at_least=1.0, at_most=1e9, why="of one contact; the paper identifies 42700")
    reference_load: float = quantity("N", at_least=1.0, at_most=1e7, why="that stiffness was identified at")
    dahl_exponent: float = quantity("-", 1.0, at_least=0.25, at_most=4.0, why="1 is the usual one")


@dataclass(frozen=True)
class Bit:
    """aggressiveness relates torque to weight; depth_of_cut_stiffness is N per m of depth of cut."""

    diameter: float = quantity("m", at_least=0.05, at_most=1.5, why="bits of 2 to 60 in; 8 1/2 in is 0.2159 m")
    aggressiveness: float = quantity("-", at_least=0.01, at_most=3.0, why="roller cone 0.2, PDC 0.5 to 1.5")
    depth_of_cut_stiffness: float = quantity("N/m", at_least=1e5, at_most=1e11, why="N a metre of cut: 1e+7 to 1e+9")

    @property
    def lever(self) -> float:
        """Torque per weight on bit, m (`model.md` section 4)."""
        return self.aggressiveness * self.diameter / 3.0


@dataclass(frozen=True)
class Motor:
    torque_per_pressure: float = quantity("N m/Pa", at_least=1e-6, at_most=0.1, why="N m per Pa: 6 3/4 in motors 2e-3")
    displacement: float = quantity("m3/rev", at_least=1e-4, at_most=1.0, why="m3 per revolution: 6 3/4 in motors 0.02")
    leak: float = quantity("-", at_least=0.0, below=1.0, why="share of the flow that passes by at max_pressure")
    max_pressure: float = quantity("Pa", at_least=1e5, at_most=1e8, why="differential, in Pa: 70 bar is 70.0e+5")


@dataclass(frozen=True)
class MudPump:
    displacement: float = quantity("m3/rad", at_least=1e-6, at_most=0.1, why="m3 per rad of the crank, all cylinders")


@dataclass(frozen=True)
class Hydraulics:
    reference_pressure: float = quantity("Pa", at_least=1e4, at_most=1.5e8, why="in Pa, not bar; pumps end at 700 bar")
    reference_flow: float = quantity("m3/s", at_least=1e-4, at_most=0.5, why="in m3/s: 500 gal/min is 0.0315")
    reference_density: float = quantity("kg/m3", at_least=1.0, at_most=3000.0, why="of the mud at reference_pressure")
    lag: float = quantity("s", at_least=0.0, at_most=120.0, why="first order, of the standpipe: seconds")


@dataclass(frozen=True)
class TopDrive:
    max_speed: float = quantity("rad/s", at_least=0.1, at_most=50.0, why="in rad/s: 120 rpm is 12.6")
    max_acceleration: float = quantity("rad/s2", at_least=0.01, at_most=1000.0, why="full speed in a second is 10")
    max_torque: float = quantity("N m", at_least=100.0, at_most=5e5, why="in N m, not kN m")


@dataclass(frozen=True)
class Sensor:
    """Noise (one standard deviation), first-order lag in s and resolution, in the channel's own unit."""

    noise: float = quantity("-", at_least=0.0)
    lag: float = quantity("s", at_least=0.0, at_most=60.0, why="first order: under a second to some")
    resolution: float = quantity("-", at_least=0.0)


@dataclass(frozen=True)
class Mwd:
    period: float = quantity("s", at_least=0.5, at_most=3600.0, why="between toolfaces: 5 to 60")
    latency: float = quantity("s", at_least=0.0, at_most=3600.0, why="from the tool to the surface: seconds")
    noise: float = quantity("rad", at_least=0.0, at_most=3.2, why="in rad; half a turn knows no direction")
    resolution: float = quantity("rad", at_least=0.0, at_most=3.2, why="in rad; half a turn knows no direction")


@dataclass(frozen=True)
class Sensors:
    mwd: Mwd
    surface_torque: Sensor = nested(**_reading("N m", 1e5, "a top drive's torque"))
    hook_load: Sensor = nested(**_reading("N", 2e6, "the string's weight"))
    standpipe_pressure: Sensor = nested(**_reading("Pa", 2e7, "a pump's pressure"))
    rate: float = quantity("Hz", at_least=0.1, at_most=1000.0, why="of the surface channels: 1 to 100")


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

    @property
    def circulating_pressure(self) -> float:
        """Pa at the standpipe that the reference flow of this mud needs without the motor; other flows by their 1.8th
        power (`model.md` section 4).
        """
        return self.hydraulics.reference_pressure * (self.mud.density / self.hydraulics.reference_density)

    def with_(self, changes: Mapping[str, Any] | None = None, /, **blocks: Any) -> Rig:
        """This rig with some values changed, checked as a rig file is.

        changes: path -> value, such as ``{"mud.density": 1100.0, "string.sections[0].length": 3900.0}``; blocks: the
        same as nested mappings, such as ``mud={"density": 1100.0}``. Raises InputError naming key, value and range.
        """
        from slider_drilling.rig.file import rig_from_tree

        return rig_from_tree(apply_changes(to_tree(self), {**(changes or {}), **blocks}, "rig"))

    def __repr__(self) -> str:
        on = [field.name for field in fields(Effects) if getattr(self.effects, field.name) != field.default]
        return (
            f"Rig({self.string.length:g} m of string in a {self.well.hole_diameter:g} m hole, "
            f"effects: {', '.join(on) or 'none'})"
        )
