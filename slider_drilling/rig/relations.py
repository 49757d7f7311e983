"""What one number of a rig file says about another: relations that no range of a single number can hold."""

from __future__ import annotations

import math

import numpy as np

from slider_drilling.asperity_friction.wear_regimes import WearMode, wear_mode
from slider_drilling.errors import InputError
from slider_drilling.rig.parts import SCHEMA, Rig

_CLOSE = 1e-6  # m, by which lengths that should meet may miss
_NEAREST = 0.01  # m, between two stations: nearer ones are one, written twice
_SHARPEST = 0.2  # rad/m; the tightest short-radius wells turn by 0.17 (3 degrees a foot)
_WIDEST = 150.0  # deg between two stations: an arc through opposite directions has no plane
_THINNEST = 1e-3  # m of pipe wall
_EFFICIENCY = 1.2  # of a motor, with room for published figures that do not quite agree
_LEAST_GRIP, _MOST_GRIP = 0.1, 6000.0  # 1/m, stiffness over load; the paper identifies 22.6
_MOST_SECTIONS = 500
_ATTACK_ANGLES = 257  # looked at, as many as a friction table has


def check_relations(rig: Rig, source: str) -> None:
    """Raises InputError naming source, key and value of the first number that does not go with another."""
    if rig.schema != SCHEMA:
        raise InputError(f"{source}: schema = {rig.schema[:60]!r}: this version reads {SCHEMA!r}")
    _check_sections(rig, source)
    _check_survey(rig, source)
    _check_intervals(rig, source)
    _check_material(rig, source)
    _check_wedge(rig, source)
    _check_bit_and_motor(rig, source)
    _check_effects(rig, source)


def check_duration(rig: Rig, duration: float, source: str) -> None:
    """Raises InputError where a run of ``duration`` s would outlast an effect that changes with time."""
    rate = rig.effects.friction_drift.rate
    if not math.isfinite(duration):
        raise InputError(f"{source}: a run of {duration} s: give a finite duration")
    if 1.0 + rate * duration <= 0.0:
        raise InputError(
            f"{source}: effects.friction_drift.rate = {rate:g}: leaves no friction after {-1.0 / rate:.0f} s, and the "
            f"run takes {duration:.0f} s; give a slower drift"
        )


def _check_survey(rig: Rig, source: str) -> None:
    survey = rig.well.survey
    if len(survey) < 2:
        raise InputError(f"{source}: well.survey: {len(survey)} station(s); give at least two")
    if survey[0][0] != 0.0:
        raise InputError(f"{source}: well.survey[0] = {survey[0][0]}: the first station must be at depth 0 m")
    for index in range(1, len(survey)):
        above, here = survey[index - 1], survey[index]
        where = f"{source}: well.survey[{index}]"
        if here[0] < above[0] + _NEAREST:
            raise InputError(
                f"{where} = {here[0]}: measured depth must increase from station to station, by {_NEAREST:g} m at least"
            )
        turn, spacing = _turn(above, here), here[0] - above[0]
        if turn > math.radians(_WIDEST):
            raise InputError(
                f"{where}: turns by {math.degrees(turn):.0f} deg from the station above, more than {_WIDEST:g} deg; "
                "add stations between"
            )
        if turn > _SHARPEST * spacing:
            raise InputError(
                f"{where}: turns by {math.degrees(turn):.3g} deg in {spacing:.3g} m, a radius of "
                f"{spacing / turn:.2g} m; no pipe goes round less than {1.0 / _SHARPEST:g} m"
            )
    length = rig.string.length
    if survey[-1][0] < length - _CLOSE:
        raise InputError(
            f"{source}: well.survey: ends at {survey[-1][0]:g} m, the string reaches {length:g} m; add stations"
        )


def _turn(above: tuple[float, float, float], here: tuple[float, float, float]) -> float:
    """Angle (rad) between the directions of two stations, accurate for small ones too."""
    (i, a), (j, b) = ([math.radians(angle) for angle in station[1:]] for station in (above, here))
    half = math.sin(0.5 * (j - i)) ** 2 + math.sin(i) * math.sin(j) * math.sin(0.5 * (b - a)) ** 2
    return 2.0 * math.asin(min(math.sqrt(half), 1.0))


def _check_intervals(rig: Rig, source: str) -> None:
    length, previous = rig.string.length, 0.0
    for index, interval in enumerate(rig.well.friction_intervals):
        if interval.to < previous + _CLOSE:
            raise InputError(f"{source}: well.friction_intervals[{index}].to = {interval.to:g}: must increase")
        previous = interval.to
    if rig.well.friction_intervals and previous < length - _CLOSE:
        raise InputError(
            f"{source}: well.friction_intervals: the last one ends at {previous:g} m, the string at {length:g} m"
        )


def _check_sections(rig: Rig, source: str) -> None:
    sections = rig.string.sections
    if not 0 < len(sections) <= _MOST_SECTIONS:
        raise InputError(f"{source}: string.sections: {len(sections)} of them; give 1 to {_MOST_SECTIONS}")
    for index, section in enumerate(sections):
        where = f"{source}: string.sections[{index}]"
        if section.inner_diameter >= section.outer_diameter:
            raise InputError(
                f"{where}.inner_diameter = {section.inner_diameter:g}: not smaller than the outer diameter "
                f"{section.outer_diameter:g} m"
            )
        if section.outer_diameter - section.inner_diameter < 2.0 * _THINNEST:
            raise InputError(
                f"{where}.inner_diameter = {section.inner_diameter:g}: leaves a wall of less than {_THINNEST:g} m "
                f"within the outer diameter {section.outer_diameter:g} m"
            )
        if section.outer_diameter >= rig.well.hole_diameter:
            raise InputError(
                f"{where}.outer_diameter = {section.outer_diameter:g}: does not fit the hole of "
                f"{rig.well.hole_diameter:g} m"
            )


def _check_material(rig: Rig, source: str) -> None:
    string, asperity = rig.string, rig.contact.asperity
    if string.density <= rig.mud.density:
        raise InputError(
            f"{source}: string.density = {string.density:g}: must exceed the mud's {rig.mud.density:g} kg/m3"
        )
    if string.shear_modulus >= string.youngs_modulus:
        raise InputError(
            f"{source}: string.shear_modulus = {string.shear_modulus:g}: not below youngs_modulus "
            f"{string.youngs_modulus:g} Pa, which no material has; are they swapped?"
        )
    grip = rig.contact.stiffness / rig.contact.reference_load
    if not _LEAST_GRIP <= grip <= _MOST_GRIP:
        raise InputError(
            f"{source}: contact.stiffness = {rig.contact.stiffness:g}: at a reference_load of "
            f"{rig.contact.reference_load:g} N contacts stretch by {1.0 / grip:.2g} m under their own load; "
            f"{1.0 / _MOST_GRIP:g} to {1.0 / _LEAST_GRIP:g} m is possible"
        )
    if asperity.minor_axis > asperity.major_axis:
        raise InputError(
            f"{source}: contact.asperity.minor_axis = {asperity.minor_axis:g}: larger than the major axis "
            f"{asperity.major_axis:g} m"
        )


def _check_wedge(rig: Rig, source: str) -> None:
    """Between the smallest and the largest attack angle (eq. 6 along either axis) the asperity slides at all."""
    contact, asperity = rig.contact, rig.contact.asperity
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


def _check_bit_and_motor(rig: Rig, source: str) -> None:
    if rig.bit.diameter > rig.well.hole_diameter + _CLOSE:
        raise InputError(
            f"{source}: bit.diameter = {rig.bit.diameter:g}: larger than the hole of {rig.well.hole_diameter:g} m"
        )
    motor = rig.motor
    ideal = motor.displacement / (2.0 * math.pi)
    if motor.torque_per_pressure > _EFFICIENCY * ideal:
        raise InputError(
            f"{source}: motor.torque_per_pressure = {motor.torque_per_pressure:g}: a motor without losses gives "
            f"displacement / (2 pi) = {ideal:.3g} N m/Pa"
        )


def _check_effects(rig: Rig, source: str) -> None:
    effects, length = rig.effects, rig.string.length
    bed, tool = effects.cuttings_bed, effects.axial_oscillation_tool
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
