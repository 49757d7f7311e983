"""Numbers that no paper tells: usual values, how far such rigs lie from them, and why."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.contact import PAPER, friction_coefficient_of_direction
from slider_drilling.rig_papers import equipment


@dataclass(frozen=True)
class Default:
    """A usual value of a rig file's key, its spread (one standard deviation) in the key's unit, and why."""

    key: str
    value: float
    spread: float
    why: str


@dataclass(frozen=True)
class FrictionOfMud:
    """Usual friction coefficients of pipe on casing and on rock, and half their published ranges."""

    cased: float
    cased_spread: float
    open_hole: float
    open_hole_spread: float


FRICTION = {
    "oil": FrictionOfMud(0.18, 0.03, 0.21, 0.04),
    "synthetic": FrictionOfMud(0.15, 0.03, 0.20, 0.05),
    "water": FrictionOfMud(0.27, 0.05, 0.32, 0.07),
    "": FrictionOfMud(0.22, 0.06, 0.27, 0.07),
}
_FRICTION_SOURCE = "Samuel, J. Pet. Sci. Eng. 73 (2010); calibrate it with driller's weights"
_SOUND_SPEED = {"oil": 1250.0, "synthetic": 1250.0, "water": 1450.0, "": 1350.0}
_CONTACT = "of the paper's pair of steel and rock; friction factors scale it"
_RECORDERS = "usual of recorders; a log shows its own"


def mean_friction() -> float:
    """Friction of the contact model, mean of axial and tangential slip, which friction factors multiply."""
    along, around = friction_coefficient_of_direction(PAPER, np.array([0.0, 0.5 * np.pi]))
    return float(np.sqrt(along * around))


def friction_defaults(base: str, cased: bool) -> list[Default]:
    """Friction factors of cased and open hole, or of the whole hole, by what the mud is made of."""
    usual, unit = FRICTION[base], mean_friction()
    mud = f"{base}-based mud" if base else "mud of unknown kind"
    key = "well.friction_intervals[{}].factor"
    open_hole = Default(key.format(1 if cased else 0), round(usual.open_hole / unit, 2), usual.open_hole_spread / unit,
                        f"open hole, {mud}: friction {usual.open_hole:g}; {_FRICTION_SOURCE}")  # fmt: skip
    if not cased:
        return [open_hole]
    return [Default(key.format(0), round(usual.cased / unit, 2), usual.cased_spread / unit,
                    f"cased hole, {mud}: friction {usual.cased:g}; {_FRICTION_SOURCE}"), open_hole]  # fmt: skip


def common_defaults(base: str) -> list[Default]:
    """Numbers that no paper of any rig tells."""
    asperity = PAPER.asperity
    return [
        Default("mud.sound_speed", _SOUND_SPEED[base], 100.0, "base oil 1250, water 1480; solids and gas slow it"),
        Default("string.weight_factor", 1.0, 0.03, "wear, coating and tolerance of adjusted weights"),
        Default("string.axial_damping", 0.15, 0.1, "mud gives 0.05 to 0.5"),
        Default("string.torsional_damping", 0.15, 0.1, "mud gives 0.05 to 0.5"),
        Default("contact.shear_factor", PAPER.shear_factor, 0.05, _CONTACT),
        Default("contact.asperity.height", asperity.height, 0.3 * asperity.height, _CONTACT),
        Default("contact.asperity.minor_axis", asperity.minor_axis, 0.3 * asperity.minor_axis, _CONTACT),
        Default("contact.asperity.major_axis", asperity.major_axis, 0.3 * asperity.major_axis, _CONTACT),
        Default("contact.stiffness", PAPER.stiffness, 0.5 * PAPER.stiffness, _CONTACT),
        Default("hydraulics.lag", 1.5, 1.0, "compressibility of the mud in the string, pulsation dampener"),
        Default("top_drive.max_acceleration", 10.0, 5.0, "full speed in 1 to 4 s; asked of the drive's maker"),
        Default("sensors.surface_torque.noise", 150.0, 100.0, _RECORDERS),
        Default("sensors.surface_torque.lag", 0.0, 0.3, _RECORDERS),
        Default("sensors.hook_load.noise", 4000.0, 2500.0, _RECORDERS),
        Default("sensors.hook_load.lag", 0.0, 0.3, _RECORDERS),
        Default("sensors.standpipe_pressure.noise", 4.0e4, 2.5e4, _RECORDERS),
        Default("sensors.standpipe_pressure.lag", 0.0, 0.3, _RECORDERS),
        Default("sensors.mwd.period", 12.0, 6.0, "mud pulse: a toolface every 6 to 25 s"),
        Default("sensors.mwd.latency", 6.0, 3.0, "half an interval and the way up through the mud"),
        Default("sensors.mwd.noise", 0.017, 0.01, "1 deg, of tools at rest"),
        Default("sensors.mwd.resolution", 0.0349, 0.017, "2 deg: 6 to 8 bits a turn"),
    ]  # fmt: skip


def sample_rate_default() -> Default:
    """Rate of the surface channels where no paper tells."""
    return Default("sensors.rate", 10.0, 5.0, "of drives and controllers; exports of recorders have 1")


def bit_defaults(description: str, diameter: float) -> list[Default]:
    """Aggressiveness and depth-of-cut stiffness of a bit.

    Args:
        description: As a tally names it.
        diameter: m.
    """
    cone = any(word in description.lower() for word in ("cone", "tci", "tricone", "insert", "tooth"))
    kind = "roller cone bit" if cone else "PDC bit"
    value, spread = (0.2, 0.07) if cone else (0.6, 0.15)
    stiffness = 6.0e7 * diameter / 0.2159
    return [
        Default("bit.aggressiveness", value, spread, f"{kind}: {'0.1 to 0.3' if cone else '0.4 to 0.9'}"),
        Default("bit.depth_of_cut_stiffness", stiffness, 0.5 * stiffness, "rock, soft to hard: 20 to 200 MN/m"),
    ]


def motor_leak() -> Default:
    """Leak of a motor whose sheet does not tell."""
    return Default("motor.leak", equipment.LEAK, equipment.LEAK_SPREAD, "slip past the rotor at full load: 5 to 30 %")


def motor_torque(ideal: float) -> Default:
    """Torque per pressure of a motor known by its size; ideal: without losses, N m/Pa."""
    value, spread = equipment.TORQUE_EFFICIENCY * ideal, equipment.TORQUE_EFFICIENCY_SPREAD * ideal
    return Default("motor.torque_per_pressure", value, spread, "0.5 to 0.8 of a motor without losses; see its sheet")


def motor_full_load(pressure: float) -> Default:
    """Differential pressure at full load of a motor known by its stages, Pa."""
    return Default("motor.max_pressure", pressure, 0.2 * pressure, "225 psi a stage; see its sheet")


def motor_stall(full_load: float) -> Default:
    """Differential pressure at stall; full_load: Pa."""
    return Default("motor.stall_pressure", equipment.STALL_OVER_FULL_LOAD * full_load,
                   equipment.STALL_SPREAD * full_load, "1.3 to 1.8 times full load; see its sheet")  # fmt: skip


def pump_displacement(value: float) -> Default:
    """Displacement of a pump by liner and stroke, m3/rad."""
    spread = equipment.PUMP_EFFICIENCY_SPREAD * value
    return Default("mud_pump.displacement", value, spread, "triplex of 96 % volumetric efficiency: 93 to 98")
