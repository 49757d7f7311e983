"""The blocks of a rig file as frozen dataclasses; each number declares its unit, its range and why that range.

Names and units are those of ``config/rig.example.yaml``: SI, and degrees for the survey's angles only.
"""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass
from typing import Any

from slider_drilling.schema.fields import Range, nested, quantity, table

GRAVITY = 9.81  # m/s2, not 9.80665: the hanging weight of the reference logs shows the difference
MAX_DEPTH = 20_000.0
"""m; the longest wells have 15 km."""
_LONGEST_WELLS = "the longest wells have 15 km"
_MUD_DENSITY: dict[str, Any] = {
    "at_least": 1.0, "at_most": 3000.0, "usual": (300.0, 3000.0), "mistaken_for": ("lb/gal", "g/cm3", "lb/ft3"),
}  # fmt: skip


def _sensor_ranges(unit: str, most: float, what: str) -> dict[str, Range]:
    """Ranges of a `Sensor` whose channel has this unit and never reads more than ``most``."""
    limits = Range(unit, at_least=0.0, at_most=most, why=f"in {unit}, as the channel: a fraction of {what}")
    return {"noise": limits, "resolution": limits}


@dataclass(frozen=True)
class FrictionInterval:
    """The contact's friction is multiplied by ``factor`` from the end of the interval above down to ``to``."""

    to: float = quantity("m", above=0.0, at_most=MAX_DEPTH, why="measured depth; the longest wells have 15 km")
    factor: float = quantity("-", at_least=0.0, at_most=20.0, why="a multiple of the contact's own friction")


@dataclass(frozen=True)
class Well:
    """The hole.

    Attributes:
        survey: Rows of (measured depth m, inclination deg, azimuth deg), depth increasing.
        hole_diameter: m.
        friction_intervals: What multiplies the contact's friction, from the surface down; empty means 1 everywhere.
        name: What pages call the well.
    """

    survey: tuple[tuple[float, float, float], ...] = table(
        **{
            "measured depth": Range("m", at_least=0.0, at_most=MAX_DEPTH, why=_LONGEST_WELLS),
            "inclination": Range("deg", at_least=0.0, at_most=180.0, why="0 is straight down, 90 horizontal"),
            "azimuth": Range("deg", at_least=-360.0, at_most=720.0, why="clockwise from north"),
        }
    )
    hole_diameter: float = quantity("m", at_least=0.05, at_most=1.5, why="bits of 2 to 60 in; 8 1/2 in is 0.2159 m")
    friction_intervals: tuple[FrictionInterval, ...] = ()
    name: str = ""


@dataclass(frozen=True)
class Mud:
    """The drilling fluid."""

    density: float = quantity("kg/m3", why="air to the heaviest kill mud; 10 ppg is 1198", **_MUD_DENSITY)
    sound_speed: float = quantity("m/s", at_least=100.0, at_most=3000.0, why="gas-cut mud to brine; water has 1480")


@dataclass(frozen=True)
class StringSection:
    """A length of pipe with one cross-section, and its tool joints.

    Without the keys that may be left out a section is plain pipe of the string's steel.

    Attributes:
        name: For the reader.
        length, outer_diameter, inner_diameter: Of the pipe's body.
        weight_per_length: In air, averaged over joints; replaces the weight that diameters and density give.
        tool_joint_outer_diameter: Touches the wall instead of the body: lever of friction, clearance.
        tool_joint_inner_diameter: Bore of the tool joint; that of the body if it is left out.
        tool_joint_fraction: Share of the length that is tool joint: stiffer, heavier, of more inertia.
        stiffness_factor: Multiplies axial, torsional and bending stiffness, such as 0.34 for aluminium pipe.
        make_up_torque, torsional_yield: Limits of the connections and of the body in torsion.
    """

    name: str
    length: float = quantity("m", at_least=0.3, at_most=MAX_DEPTH, why="from the shortest sub to the longest well")
    outer_diameter: float = quantity("m", at_least=0.02, at_most=1.2, why="tubing to casing; 5 in is 0.127")
    inner_diameter: float = quantity("m", at_least=0.0, at_most=1.2, why="0 is a solid bar")
    weight_per_length: float | None = quantity(
        "N/m", None, at_least=5.0, at_most=2e4, why="in N/m, in air: 5 in pipe of 19.5 lb/ft has 305 to 345"
    )
    tool_joint_outer_diameter: float | None = quantity(
        "m", None, at_least=0.02, at_most=1.2, why="as wide as the body or wider; NC50 has 0.162 to 0.168"
    )
    tool_joint_inner_diameter: float | None = quantity(
        "m", None, at_least=0.0, at_most=1.2, why="NC50 has 0.070 to 0.095"
    )
    tool_joint_fraction: float | None = quantity(
        "-", None, at_least=0.0, at_most=1.0, why="a pin and a box of 0.53 m on a joint of 9.6 m are 0.055"
    )
    stiffness_factor: float | None = quantity(
        "-", None, at_least=0.05, at_most=3.0, why="over the string's own moduli; aluminium 0.34, titanium 0.55"
    )
    make_up_torque: float | None = quantity(
        "N m", None, at_least=100.0, at_most=5e5, why="in N m, not kN m; NC50 takes 31000 to 52000"
    )
    torsional_yield: float | None = quantity(
        "N m", None, at_least=100.0, at_most=5e6, why="in N m, not kN m; 5 in S-135 has 100500"
    )

    @property
    def contact_diameter(self) -> float:
        """Diameter that touches the wall, m."""
        return self.tool_joint_outer_diameter or self.outer_diameter

    def stiffness_over_body(self, power: int) -> float:
        """Stiffness over that of the body alone: in tension (power 2), in bending and torsion (power 4).

        Tool joints and body are springs in series.
        """
        fraction, wider = self._tool_joints(power)
        return (self.stiffness_factor or 1.0) / ((1.0 - fraction) + fraction / wider)

    def steel_over_body(self, power: int) -> float:
        """Mass (power 2) and inertia about the axis (power 4) over those of the body alone, by the diameters."""
        fraction, wider = self._tool_joints(power)
        return (1.0 - fraction) + fraction * wider

    def _tool_joints(self, power: int) -> tuple[float, float]:
        """Their share of the length, and their section property over the body's."""
        if not self.tool_joint_fraction:
            return 0.0, 1.0
        inner = self.tool_joint_inner_diameter
        bore = self.inner_diameter if inner is None else inner
        body = self.outer_diameter**power - self.inner_diameter**power
        return self.tool_joint_fraction, (self.contact_diameter**power - bore**power) / body


@dataclass(frozen=True)
class String:
    """The drill string: sections from the surface down, whose lengths add up to the bit's measured depth.

    The two dampings are rates at which the mud slows a free motion down. weight_factor multiplies weight and inertia
    of every section: what a hook load calibrates. contact_radius_factor multiplies the radius at which friction acts:
    tool joints, protectors and their wear.
    """

    sections: tuple[StringSection, ...]
    density: float = quantity("kg/m3", at_least=1500.0, at_most=20_000.0, why="carbon fibre to tungsten; steel 7850")
    youngs_modulus: float = quantity("Pa", at_least=1e10, at_most=5e11, why="in Pa, not GPa; steel 2.06e+11")
    shear_modulus: float = quantity("Pa", at_least=2e9, at_most=3e11, why="in Pa, not GPa; steel 7.92e+10")
    axial_damping: float = quantity("1/s", at_least=0.0, at_most=100.0, why="mud gives 0.1 to 1")
    torsional_damping: float = quantity("1/s", at_least=0.0, at_most=100.0, why="mud gives 0.1 to 1")
    weight_factor: float = quantity("-", 1.0, at_least=0.5, at_most=2.0, why="worn pipe 0.9, coated or new pipe 1.05")
    contact_radius_factor: float = quantity("-", 1.0, at_least=0.5, at_most=2.0, why="pipe to its tool joint 1.3")

    @property
    def length(self) -> float:
        """Measured depth of the bit, m."""
        return math.fsum(section.length for section in self.sections)

    @property
    def weakest_make_up_torque(self) -> float | None:
        """Smallest make-up torque of its connections, N m; None if no section tells one."""
        return min((each.make_up_torque for each in self.sections if each.make_up_torque is not None), default=None)

    @property
    def axial_stiffness(self) -> float:
        """Stiffness of the whole string between block and bit, N/m."""
        compliance = sum(section.length / (math.pi / 4.0 * (section.outer_diameter**2 - section.inner_diameter**2)
                                           * section.stiffness_over_body(2)) for section in self.sections)  # fmt: skip
        return self.youngs_modulus / compliance

    def weight_over_plain(self, section: StringSection) -> float:
        """Weight of a section over that which its diameters and the string's density give."""
        if section.weight_per_length is None:
            return self.weight_factor
        area = math.pi / 4.0 * (section.outer_diameter**2 - section.inner_diameter**2) * section.steel_over_body(2)
        return self.weight_factor * (section.weight_per_length / (GRAVITY * self.density * area))

    @property
    def twist_speed(self) -> float:
        """Mean speed of torsional waves along the string, m/s."""
        plain = math.sqrt(self.shear_modulus / self.density)
        slowness = [math.sqrt(section.steel_over_body(4) * self.weight_over_plain(section)
                              / section.stiffness_over_body(4)) for section in self.sections]  # fmt: skip
        if all(value == 1.0 for value in slowness):
            return plain
        lengths = [section.length for section in self.sections]
        mean = math.fsum(map(operator.mul, lengths, slowness)) / math.fsum(lengths)
        return plain / mean


@dataclass(frozen=True)
class Asperity:
    """The ellipsoidal asperity of paper eq. 6; orientation is the angle from the hole's axis to its axis e3."""

    height: float = quantity("m", at_least=1e-9, at_most=1e-2, why="roughness of steel and rock: um")
    minor_axis: float = quantity("m", at_least=1e-9, at_most=1e-1, why="roughness of steel and rock: um")
    major_axis: float = quantity("m", at_least=1e-9, at_most=1e-1, why="roughness of steel and rock: um")
    shape_factor: float = quantity("-", at_least=0.01, at_most=100.0, why="chi of eq. 6; an ellipse has pi")
    orientation: float = quantity("rad", 0.0, at_least=-6.2832, at_most=6.2832, why="one turn either way; in rad")


@dataclass(frozen=True)
class Contact:
    """Friction of pipe on the wall: shear_factor is f of paper eq. 1-5, stiffness is kt at the load reference_load.

    elastic_share: how far a contact that relaxes, or is stretched little, does not slip (Dupont et al. 2002).
    vector_share: how far it slips with the pipe's velocity as one vector, and not with its axial and tangential parts.
    """

    asperity: Asperity
    shear_factor: float = quantity("-", at_least=0.0, below=1.0, why="shear strength of the film over that of the wall")
    stiffness: float = quantity("N/m", at_least=1.0, at_most=1e9, why="of one contact; the paper identifies 42700")
    reference_load: float = quantity("N", at_least=1.0, at_most=1e7, why="load at which the stiffness was identified")
    dahl_exponent: float = quantity("-", 1.0, at_least=0.25, at_most=4.0, why="1 is the usual one")
    elastic_share: float = quantity("-", 0.0, at_least=0.0, at_most=1.0, why="0 is Dahl's law, 1 elasto-plastic")
    vector_share: float = quantity("-", 0.0, at_least=0.0, at_most=1.0, why="0 is the paper's law, 1 a vector's")


@dataclass(frozen=True)
class Bit:
    """The bit: aggressiveness relates torque to weight, depth_of_cut_stiffness weight to depth of cut (N/m)."""

    diameter: float = quantity("m", at_least=0.05, at_most=1.5, why="bits of 2 to 60 in; 8 1/2 in is 0.2159 m")
    aggressiveness: float = quantity("-", at_least=0.01, at_most=3.0, why="roller cone 0.2, PDC 0.5 to 1.5")
    depth_of_cut_stiffness: float = quantity("N/m", at_least=1e5, at_most=1e11, why="N a metre of cut: 1e+7 to 1e+9")

    @property
    def lever(self) -> float:
        """Bit torque per weight on bit, m (`model.md` section 4)."""
        return self.aggressiveness * self.diameter / 3.0


@dataclass(frozen=True)
class Motor:
    """The positive-displacement mud motor (`model.md` section 4)."""

    torque_per_pressure: float = quantity("N m/Pa", at_least=1e-6, at_most=0.1, why="N m per Pa: 6 3/4 in motors 2e-3")
    displacement: float = quantity("m3/rev", at_least=1e-4, at_most=1.0, why="m3 per revolution: 6 3/4 in motors 0.02")
    leak: float = quantity("-", at_least=0.0, below=1.0, why="fraction of the flow that bypasses at max_pressure")
    max_pressure: float = quantity("Pa", at_least=1e5, at_most=1e8, why="differential, in Pa: 70 bar is 70.0e+5")
    stall_pressure: float | None = quantity(
        "Pa", None, at_least=1e5, at_most=2e8, why="where the motor stalls, if above max_pressure: 1.3 to 1.8 times"
    )

    @property
    def pressure_at_stall(self) -> float:
        """Differential pressure at which the motor stalls, Pa."""
        return self.max_pressure if self.stall_pressure is None else self.stall_pressure

    def leak_at(self, pressure: float) -> float:
        """Share of the flow that bypasses at a differential pressure, Pa: it grows with its square."""
        return self.leak * (pressure / self.max_pressure) ** 2

    @property
    def leak_at_stall(self) -> float:
        """Share of the flow that bypasses at `pressure_at_stall`."""
        return self.leak_over_stall * self.leak

    @property
    def leak_over_stall(self) -> float:
        """Leak at stall over leak at `max_pressure`."""
        return (self.pressure_at_stall / self.max_pressure) ** 2


MAX_BLOCK_SPEED = 2.0  # m/s, of a block whose rig file gives no limit: as fast as blocks travel when tripping


@dataclass(frozen=True)
class DrawWorks:
    """Limit of the drawworks: commands for a faster block are refused; without it, at MAX_BLOCK_SPEED."""

    max_speed: float | None = quantity("m/s", None, at_least=0.01, at_most=20.0, why="of the block, either way")


@dataclass(frozen=True)
class MudPump:
    """The mud pump: flow per speed of its crank, and the crank's limit, by default twice the reference flow's speed."""

    displacement: float = quantity("m3/rad", at_least=1e-6, at_most=0.1, why="m3 per rad of the crank, all cylinders")
    max_speed: float | None = quantity("rad/s", None, at_least=0.1, at_most=1e5, why="of the crank: 120 spm is 12.6")


FLOW_EXPONENT = 1.8
"""Pressure of circulation grows with flow to this power: turbulent loss (`model.md` section 4)."""


@dataclass(frozen=True)
class Hydraulics:
    """Standpipe pressure of circulation: reference_pressure at reference_flow with mud of reference_density."""

    reference_pressure: float = quantity("Pa", at_least=1e4, at_most=1.5e8, why="in Pa, not bar; pumps end at 700 bar")
    reference_flow: float = quantity("m3/s", at_least=1e-4, at_most=0.5, why="in m3/s: 500 gal/min is 0.0315")
    reference_density: float = quantity("kg/m3", why="of the mud at reference_pressure", **_MUD_DENSITY)
    lag: float = quantity("s", at_least=0.0, at_most=120.0, why="first order, of the standpipe: seconds")


@dataclass(frozen=True)
class TopDrive:
    """Limits of the top drive."""

    max_speed: float = quantity("rad/s", at_least=0.1, at_most=50.0, why="in rad/s: 120 rpm is 12.6")
    max_acceleration: float = quantity("rad/s2", at_least=0.01, at_most=1000.0, why="full speed in a second is 10")
    max_torque: float = quantity("N m", at_least=100.0, at_most=5e5, why="in N m, not kN m")


@dataclass(frozen=True)
class Sensor:
    """A surface sensor: noise (one standard deviation) and resolution in the channel's unit, first-order lag in s.

    ``model_error`` is no property of the sensor: the share of what its channel moves by which the simulation may be
    wrong, whatever its parameters. A diagnosis names nothing that is smaller.
    """

    noise: float = quantity("-", at_least=0.0)
    lag: float = quantity("s", at_least=0.0, at_most=60.0, why="first order: under a second to some")
    resolution: float = quantity("-", at_least=0.0)
    model_error: float = quantity("-", 0.02, at_least=0.0, at_most=0.5, why="a share: no simulator is exact")


@dataclass(frozen=True)
class Mwd:
    """The toolface measurement: every ``period``, known at surface ``latency`` later."""

    period: float = quantity("s", at_least=0.5, at_most=3600.0, why="between toolfaces: 5 to 60")
    latency: float = quantity("s", at_least=0.0, at_most=3600.0, why="from the tool to the surface: some seconds")
    noise: float = quantity("rad", at_least=0.0, at_most=3.2, why="in rad; half a turn knows no direction")
    resolution: float = quantity("rad", at_least=0.0, at_most=3.2, why="in rad; half a turn knows no direction")


@dataclass(frozen=True)
class Sensors:
    """All sensors; rate is that of the surface channels."""

    mwd: Mwd
    surface_torque: Sensor = nested(**_sensor_ranges("N m", 1e5, "a top drive's torque"))
    hook_load: Sensor = nested(**_sensor_ranges("N", 2e6, "the string's weight"))
    standpipe_pressure: Sensor = nested(**_sensor_ranges("Pa", 2e7, "a pump's pressure"))
    rate: float = quantity("Hz", at_least=0.1, at_most=1000.0, why="of the surface channels: 1 to 100")
