"""From rig files to the flat arrays of the compiled step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from slider_drilling.contact import friction_table
from slider_drilling.drillstring.kernel_arrays import Array, Curve, Elements, Lanes, padded
from slider_drilling.drillstring.observer import Observer
from slider_drilling.errors import InputError
from slider_drilling.rig import Contact, Rig
from slider_drilling.wellbore.mesh import (
    GRAVITY,
    Mesh,
    build_mesh,
    friction_factors,
    open_hole_share,
    torsional_compliances,
)

_POLYNOMIAL_DEGREE = 7
_POLYNOMIAL_ERROR = 1e-5  # of 1 / mu, relative; beyond it (a kink between two wear modes) the kernel reads the table
_LEAST_FACTOR = 1e-9  # of friction: one of zero leaves no length over which the strain of a contact decays
_STEP_SHARE = 0.95  # of the longest stable step


@dataclass(frozen=True)
class Modifiers:
    """What a user's own effect adds to the elements, each (n,) or a number.

    friction_factor: multiplies friction; extra_curvature: rad/m, side force ``|T| curvature``; axial_force: N.
    """

    friction_factor: Array | float = 1.0
    extra_curvature: Array | float = 0.0
    axial_force: Array | float = 0.0


@dataclass(frozen=True)
class Springs:
    """Stiffness (n + 1,) between elements, top spring first and a zero below the bit; mass and inertia (n,)."""

    axial: Array
    torsional: Array
    mass: Array
    inertia: Array


def springs(rig: Rig, mesh: Mesh) -> Springs:
    """Half-element springs in series: masses sit at element middles, the top spring is half an element."""
    axial_half = 2.0 * rig.string.youngs_modulus * mesh.area / mesh.length
    torsional_half = 2.0 / torsional_compliances(rig, mesh)
    return Springs(
        axial=_in_series(axial_half),
        torsional=_in_series(torsional_half),
        mass=rig.string.density * mesh.area * mesh.length,
        inertia=rig.string.density * mesh.polar_moment * mesh.length,
    )


def longest_step(rig: Rig, mesh: Mesh) -> float:
    """Time step (s) that keeps the fastest mode stable: 2 / omega, omega bounded by Gershgorin's circles.

    The contact's own stiffness is left out: it is 1e-3 of an element's for any load that a string carries.
    """
    s = springs(rig, mesh)
    fastest = max(
        float(np.max(2.0 * (s.axial[:-1] + s.axial[1:]) / s.mass)),
        float(np.max(2.0 * (s.torsional[:-1] + s.torsional[1:]) / s.inertia)),
    )
    return _STEP_SHARE * 2.0 / math.sqrt(fastest)


@lru_cache(maxsize=16)
def friction_curve(contact: Contact) -> Curve:
    """The inverse of the contact's friction as a polynomial where it is smooth enough, and as a table."""
    table = 1.0 / friction_table(contact.shear_factor, contact.asperity)
    q = np.linspace(0.0, 1.0, len(table))
    fit = np.polynomial.Polynomial.fit(q, table, _POLYNOMIAL_DEGREE).convert()
    coefficients = np.zeros(_POLYNOMIAL_DEGREE + 1)
    coefficients[: len(fit.coef)] = fit.coef
    smooth = bool(np.max(np.abs(fit(q) / table - 1.0)) < _POLYNOMIAL_ERROR)
    orientation = contact.asperity.orientation
    return Curve(
        polynomial=coefficients if smooth else np.empty(0),
        table=np.ascontiguousarray(table),
        axial=math.cos(orientation),
        tangential=math.sin(orientation),
        exponent=contact.dahl_exponent,
        grip=_grip(contact),
    )


def elements(rigs: Sequence[Rig], mesh: Mesh, dt: float, modifiers: Sequence[Modifiers]) -> Elements:
    """Constants of every element of every lane."""
    columns = [_elements_of_one(rig, mesh, dt, extra) for rig, extra in zip(rigs, modifiers, strict=True)]
    return Elements(
        *(
            padded(np.stack([getattr(column, name) for column in columns], axis=1), mesh.count)
            for name in Elements._fields
        )
    )


def lanes(rigs: Sequence[Rig], mesh: Mesh, dt: float, observer: Observer | None = None) -> Lanes:
    """Constants of every lane."""
    rows = [_lane_of_one(rig, mesh, dt) | _observed(rig, mesh, observer) for rig in rigs]
    return Lanes(*(np.array([row[name] for row in rows], dtype=float) for name in Lanes._fields))


def common_mesh(rigs: Sequence[Rig], count: int) -> Mesh:
    """The one mesh of a batch. Raises InputError where the rigs differ in what lanes share."""
    first = rigs[0]
    for rig in rigs[1:]:
        for what in ("well.survey", "string.sections", "contact", "mud.sound_speed"):
            block, name = what.split(".") if "." in what else (what, "")
            mine, theirs = getattr(first, block), getattr(rig, block)
            if name:
                mine, theirs = getattr(mine, name), getattr(theirs, name)
            if mine != theirs:
                raise InputError(f"batch: {what} differs between its rigs; simulate them one by one")
    return build_mesh(first, count)


def _in_series(half: Array) -> Array:
    between = 1.0 / (1.0 / half[:-1] + 1.0 / half[1:])
    return np.concatenate([half[:1], between, [0.0]])


def _grip(contact: Contact) -> float:
    """Contact stiffness per normal force, 1/m: asperities touch in proportion to their load (`model.md` section 2)."""
    return contact.stiffness / contact.reference_load


def _elements_of_one(rig: Rig, mesh: Mesh, dt: float, extra: Modifiers) -> Elements:
    """The arrays of one rig, (n,) each, springs with the ghost's below the bit."""
    s = springs(rig, mesh)
    effects = rig.effects
    weight = GRAVITY * (rig.string.density - rig.mud.density) * mesh.area * mesh.length
    drag = effects.viscous_drag.coefficient * mesh.length
    axial_decay = 1.0 / (1.0 + dt * (rig.string.axial_damping + drag / s.mass))
    turning = drag * mesh.outer_radius**2 / s.inertia
    torsional_decay = 1.0 / (1.0 + dt * (rig.string.torsional_damping + turning))
    tortuous = effects.tortuosity.curvature * open_hole_share(rig, mesh) + extra.extra_curvature
    bending = 4.0 * rig.string.youngs_modulus * mesh.second_moment
    factor = friction_factors(rig, mesh) * extra.friction_factor
    grip = _grip(rig.contact)
    return Elements(
        axial_spring=s.axial,
        torsional_spring=s.torsional,
        axial_push=dt / s.mass * axial_decay,
        torsional_push=dt / s.inertia * torsional_decay,
        axial_decay=axial_decay,
        torsional_decay=torsional_decay,
        axial_force=weight * mesh.cosine + extra.axial_force,
        side_weight=grip * weight * mesh.sine,
        vertical_bend=grip * mesh.vertical_curvature * mesh.length,
        lateral_bend=grip * mesh.lateral_curvature * mesh.length,
        extra_bend=grip * tortuous * mesh.length,
        buckling=grip * effects.buckling_contact.factor * mesh.clearance / bending * mesh.length,
        radius=mesh.outer_radius,
        yielding=grip / np.maximum(factor, _LEAST_FACTOR),
        stribeck_drop=np.full(mesh.count, effects.stribeck.drop),
        per_stribeck_speed=np.full(mesh.count, 1.0 / effects.stribeck.speed),
        aging_growth=np.full(mesh.count, effects.static_aging.growth),
        per_aging_time=np.full(mesh.count, 1.0 / effects.static_aging.time),
        rest_speed=np.full(mesh.count, effects.static_aging.rest_speed),
        per_slip_distance=np.full(mesh.count, 1.0 / effects.static_aging.slip_distance),
        drift_rate=np.full(mesh.count, effects.friction_drift.rate),
    )


def _lane_of_one(rig: Rig, mesh: Mesh, dt: float) -> dict[str, float]:
    effects, bit, motor, hydraulics = rig.effects, rig.bit, rig.motor, rig.hydraulics
    tool_element = int(np.argmin(np.abs(mesh.middle - effects.axial_oscillation_tool.depth)))
    return {
        "cutting_stiffness": bit.depth_of_cut_stiffness,
        "formation_factor": effects.formation_change.factor,
        "formation_time": effects.formation_change.time,
        "bit_lever": bit.lever,
        "torque_per_pressure": motor.torque_per_pressure * (1.0 - effects.motor_wear.torque_loss),
        "motor_displacement": motor.displacement,
        "leak": motor.leak + effects.motor_wear.extra_leak,
        "stall_pressure": motor.max_pressure,
        "pump_displacement": rig.mud_pump.displacement,
        "circulating_pressure": rig.circulating_pressure,
        "reference_flow": hydraulics.reference_flow,
        "pressure_gain": _gain(dt, hydraulics.lag),
        "torque_scale": 1.0 + effects.torque_sensor_gain.gain,
        "torque_gain": _gain(dt, effects.torque_sensor_lag.lag),
        "torque_bias": effects.torque_sensor_bias.bias,
        "motor_inertia": effects.torque_at_motor.inertia,
        "motor_friction": effects.torque_at_motor.friction,
        "backlash": 0.5 * effects.top_drive_backlash.angle,
        "heave_amplitude": effects.heave.amplitude,
        "heave_frequency": 2.0 * math.pi / effects.heave.period,
        "heave_phase": effects.heave.phase,
        "tool_force": effects.axial_oscillation_tool.force,
        "tool_frequency": 2.0 * math.pi * effects.axial_oscillation_tool.frequency,
        "tool_row": tool_element,
    }


def _observed(rig: Rig, mesh: Mesh, observer: Observer | None) -> dict[str, float]:
    if observer is None:
        return {"pull": 0.0, "pull_leak": 0.0}
    impedance = math.sqrt(rig.string.shear_modulus * rig.string.density) * float(mesh.polar_moment[0])
    return {"pull": observer.gain / impedance, "pull_leak": 1.0 / observer.memory}


def _gain(dt: float, lag: float) -> float:
    """Share of the way to its target that a first-order lag goes in one step."""
    return 1.0 - math.exp(-dt / lag) if lag > 0.0 else 1.0
