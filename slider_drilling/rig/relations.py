"""Checks between the numbers of a rig file: conditions that the range of a single number cannot express.

Every check takes the blocks it compares and the source (file name) that starts its message, and raises InputError
naming source, key and value of the first number that does not fit.
"""

from __future__ import annotations

import math

import numpy as np

from slider_drilling.asperity_friction import WearMode, wear_mode
from slider_drilling.effects import Effects
from slider_drilling.errors import InputError
from slider_drilling.rig.parts import Bit, Contact, Motor, Mud, String, StringSection, Well

_LENGTH_TOLERANCE = 1e-6  # m, between lengths that should be equal
_MIN_STATION_SPACING = 0.01  # m; two nearer stations are one station written twice
_MAX_CURVATURE = 0.2  # rad/m; the tightest short-radius wells turn by 0.17 (3 degrees a foot)
_MAX_TURN = 150.0  # deg between two stations: an arc through opposite directions has no plane
_MIN_WALL = 1e-3  # m, of pipe
_MAX_EFFICIENCY = 1.2  # of a motor; above 1 because published figures do not quite agree with each other
_MIN_STIFFNESS_PER_LOAD, _MAX_STIFFNESS_PER_LOAD = 0.1, 6000.0  # 1/m; the paper identifies 22.6
_MAX_SECTIONS = 500
_ATTACK_ANGLES = 257  # that are checked, as many as a friction table has


def check_survey(well: Well, string: String, source: str) -> None:
    """Stations start at 0 m, go down, bend no tighter than a well can, and reach the end of the string."""
    survey = well.survey
    if len(survey) < 2:
        raise InputError(f"{source}: well.survey: {len(survey)} station(s); give at least two")
    if survey[0][0] != 0.0:
        raise InputError(f"{source}: well.survey[0] = {survey[0][0]}: the first station must be at depth 0 m")
    for index in range(1, len(survey)):
        _check_leg(survey[index - 1], survey[index], f"{source}: well.survey[{index}]")
    if survey[-1][0] < string.length - _LENGTH_TOLERANCE:
        raise InputError(
            f"{source}: well.survey: ends at {survey[-1][0]:.10g} m, the string reaches {string.length:.10g} m; "
            "add stations"
        )


def _check_leg(above: tuple[float, float, float], here: tuple[float, float, float], where: str) -> None:
    if here[0] < above[0] + _MIN_STATION_SPACING:
        raise InputError(
            f"{where} = {here[0]}: measured depth must increase from station to station, by "
            f"{_MIN_STATION_SPACING:g} m at least"
        )
    turn, spacing = _turn(above, here), here[0] - above[0]
    if turn > math.radians(_MAX_TURN):
        raise InputError(
            f"{where}: turns by {math.degrees(turn):.0f} deg from the station above, more than {_MAX_TURN:g} deg; "
            "add stations between"
        )
    if turn > _MAX_CURVATURE * spacing:
        raise InputError(
            f"{where}: turns by {math.degrees(turn):.3g} deg in {spacing:.3g} m, a radius of "
            f"{spacing / turn:.2g} m; no pipe goes round less than {1.0 / _MAX_CURVATURE:g} m"
        )


def _turn(above: tuple[float, float, float], here: tuple[float, float, float]) -> float:
    """Angle (rad) between the directions of two stations; the haversine form is accurate for small angles too."""
    (i, a), (j, b) = ([math.radians(angle) for angle in station[1:]] for station in (above, here))
    half = math.sin(0.5 * (j - i)) ** 2 + math.sin(i) * math.sin(j) * math.sin(0.5 * (b - a)) ** 2
    return 2.0 * math.asin(min(math.sqrt(half), 1.0))


def check_friction_intervals(well: Well, string: String, source: str) -> None:
    """Friction intervals go down and reach the end of the string."""
    length, previous = string.length, 0.0
    for index, interval in enumerate(well.friction_intervals):
        if interval.to < previous + _LENGTH_TOLERANCE:
            raise InputError(f"{source}: well.friction_intervals[{index}].to = {interval.to:g}: must increase")
        previous = interval.to
    if well.friction_intervals and previous < length - _LENGTH_TOLERANCE:
        raise InputError(
            f"{source}: well.friction_intervals: the last one ends at {previous:.10g} m, the string at {length:.10g} m"
        )


def check_sections(string: String, well: Well, source: str) -> None:
    """Every section of the string is a pipe with a wall that fits the hole."""
    sections = string.sections
    if not 0 < len(sections) <= _MAX_SECTIONS:
        raise InputError(f"{source}: string.sections: {len(sections)} of them; give 1 to {_MAX_SECTIONS}")
    for index, section in enumerate(sections):
        where = f"{source}: string.sections[{index}]"
        if section.inner_diameter >= section.outer_diameter:
            raise InputError(
                f"{where}.inner_diameter = {section.inner_diameter:g}: not smaller than the outer diameter "
                f"{section.outer_diameter:g} m"
            )
        if section.outer_diameter - section.inner_diameter < 2.0 * _MIN_WALL:
            raise InputError(
                f"{where}.inner_diameter = {section.inner_diameter:g}: leaves a wall of less than {_MIN_WALL:g} m "
                f"within the outer diameter {section.outer_diameter:g} m"
            )
        if section.outer_diameter >= well.hole_diameter:
            raise InputError(
                f"{where}.outer_diameter = {section.outer_diameter:g}: does not fit the hole of "
                f"{well.hole_diameter:g} m"
            )
        _check_tool_joints(section, well, where)


def _check_tool_joints(section: StringSection, well: Well, where: str) -> None:
    """Tool joints are as wide as the body, fit the hole, and have a wall."""
    outer, inner = section.tool_joint_outer_diameter, section.tool_joint_inner_diameter
    if outer is None:
        if section.tool_joint_fraction or inner is not None:
            raise InputError(f"{where}.tool_joint_outer_diameter: missing beside the others of a tool joint; add it")
        return
    if outer < section.outer_diameter:
        raise InputError(
            f"{where}.tool_joint_outer_diameter = {outer:g}: smaller than the body, {section.outer_diameter:g} m"
        )
    if outer >= well.hole_diameter:
        raise InputError(
            f"{where}.tool_joint_outer_diameter = {outer:g}: does not fit the hole of {well.hole_diameter:g} m"
        )
    if inner is not None and outer - inner < 2.0 * _MIN_WALL:
        raise InputError(
            f"{where}.tool_joint_inner_diameter = {inner:g}: leaves a wall of less than {_MIN_WALL:g} m within the "
            f"outer diameter {outer:g} m"
        )


def check_material(string: String, mud: Mud, source: str) -> None:
    """The pipe sinks in the mud, and its moduli are those of one material."""
    if string.density <= mud.density:
        raise InputError(f"{source}: string.density = {string.density:g}: must exceed the mud's {mud.density:g} kg/m3")
    if string.shear_modulus >= string.youngs_modulus:
        raise InputError(
            f"{source}: string.shear_modulus = {string.shear_modulus:g}: not below youngs_modulus "
            f"{string.youngs_modulus:g} Pa, which no material has; are they swapped?"
        )


def check_contact(contact: Contact, source: str) -> None:
    """The contact deforms by a plausible length, and its asperity slides steadily in every direction."""
    asperity, stiffness_per_load = contact.asperity, contact.stiffness / contact.reference_load
    if not _MIN_STIFFNESS_PER_LOAD <= stiffness_per_load <= _MAX_STIFFNESS_PER_LOAD:
        raise InputError(
            f"{source}: contact.stiffness = {contact.stiffness:g}: at a reference_load of "
            f"{contact.reference_load:g} N contacts stretch by {1.0 / stiffness_per_load:.2g} m under their own load; "
            f"{1.0 / _MAX_STIFFNESS_PER_LOAD:g} to {1.0 / _MIN_STIFFNESS_PER_LOAD:g} m is possible"
        )
    if asperity.minor_axis > asperity.major_axis:
        raise InputError(
            f"{source}: contact.asperity.minor_axis = {asperity.minor_axis:g}: larger than the major axis "
            f"{asperity.major_axis:g} m"
        )
    # Equation 6 along either axis gives the smallest and the largest attack angle of a slip.
    least, most = (math.atan(2.0 * asperity.height / (asperity.shape_factor * axis))
                   for axis in (asperity.major_axis, asperity.minor_axis))  # fmt: skip
    angles = np.linspace(least, most, _ATTACK_ANGLES)
    stuck = wear_mode(contact.shear_factor, angles) == WearMode.NO_STEADY_SOLUTION
    if stuck.any():
        raise InputError(
            f"{source}: contact.shear_factor = {contact.shear_factor:g}: with attack angles up to "
            f"{math.degrees(most):.3g} deg, of contact.asperity.height over its axes, the wedge before an asperity "
            "never slides steadily; lower one of the two"
        )


def check_bit_and_motor(bit: Bit, motor: Motor, well: Well, source: str) -> None:
    """The bit fits the hole, and the motor gives no more torque than its displacement allows."""
    if bit.diameter > well.hole_diameter + _LENGTH_TOLERANCE:
        raise InputError(
            f"{source}: bit.diameter = {bit.diameter:g}: larger than the hole of {well.hole_diameter:g} m"
        )
    if motor.pressure_at_stall < motor.max_pressure:
        raise InputError(
            f"{source}: motor.stall_pressure = {motor.pressure_at_stall:g}: below max_pressure = "
            f"{motor.max_pressure:g} Pa; are they swapped?"
        )
    if motor.leak_at_stall >= 1.0:
        raise InputError(
            f"{source}: motor.leak = {motor.leak:g}: passes all flow below stall_pressure, where it is "
            f"{motor.leak_at_stall:.3g}; lower one of them"
        )
    # A motor without losses turns the hydraulic work of a revolution, pressure times displacement, into torque.
    ideal = motor.displacement / (2.0 * math.pi)
    if motor.torque_per_pressure > _MAX_EFFICIENCY * ideal:
        raise InputError(
            f"{source}: motor.torque_per_pressure = {motor.torque_per_pressure:g}: a motor without losses gives "
            f"displacement / (2 pi) = {ideal:.3g} N m/Pa"
        )


def check_effects(effects: Effects, string: String, source: str) -> None:
    """Effects that are switched on lie within the string."""
    length = string.length
    bed, tool = effects.cuttings_bed, effects.axial_oscillation_tool
    if bed.factor != 1.0 and bed.bottom <= bed.top:
        raise InputError(
            f"{source}: effects.cuttings_bed.factor = {bed.factor:g}: has no extent, top = {bed.top:g} and bottom = "
            f"{bed.bottom:g} m; give both in m of measured depth, bottom below top"
        )
    if bed.factor != 1.0 and bed.top >= length:
        raise InputError(f"{source}: effects.cuttings_bed.top = {bed.top:g}: below the string's end at {length:g} m")
    if tool.force > 0.0 and not 0.0 < tool.depth <= length:
        raise InputError(
            f"{source}: effects.axial_oscillation_tool.depth = {tool.depth:g}: give where in the string it sits, "
            f"above 0 and at most {length:g} m of measured depth"
        )
