"""Assembly: from rigs and a mesh to the constant arrays of the compiled step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter

import numpy as np

from slider_drilling.contact import friction_table
from slider_drilling.drillstring.kernel_arrays import Array, Elements, FrictionCurve, Lanes, padded
from slider_drilling.drillstring.observer import Observer
from slider_drilling.errors import InputError
from slider_drilling.rig import Asperity, Contact, Rig
from slider_drilling.wellbore.mesh import (
    Mesh,
    build_mesh,
    buoyed_weight,
    contact_radius,
    friction_factors,
    open_hole_fraction,
    steel_area,
    steel_polar_moment,
    torsional_compliances,
    torsional_impedance,
)

_POLYNOMIAL_DEGREE = 7
# Relative error of 1 / mu, beyond which (at a kink between wear modes) a table is used: that takes five times as long,
# and nobody knows the friction of a hole to one part in a thousand.
POLYNOMIAL_TOLERANCE = 5e-4
MIN_FRICTION_FACTOR = 1e-9
"""Smallest factor of friction: at zero the length over which a contact's strain decays would be zero."""
_STEP_MARGIN = 0.95  # of the longest stable step of the springs alone
_STEP_MARGIN_WITH_CONTACT = 0.98
_PUSHED = 2e5  # N, compression that a contact is taken to bear where less hangs below


@dataclass(frozen=True)
class Modifiers:
    """What a user's own effect adds to the elements, each (n,) or one number.

    Attributes:
        friction_factor: Multiplies friction.
        extra_curvature: rad/m; adds the side force ``|T| curvature``.
        axial_force: N, added along the hole, positive downhole.
        turning_difference: Share by which friction is larger while an element turns right, and smaller turning left.
    """

    friction_factor: Array | float = 1.0
    extra_curvature: Array | float = 0.0
    axial_force: Array | float = 0.0
    turning_difference: Array | float = 0.0


@dataclass(frozen=True)
class Springs:
    """Lumped springs and masses of a string.

    Attributes:
        axial, torsional: Stiffness (n + 1,) between elements, N/m and N m/rad; top spring first, zero below the bit.
        mass, inertia: Of the elements (n,), kg and kg m2.
    """

    axial: Array
    torsional: Array
    mass: Array
    inertia: Array


def springs(rig: Rig, mesh: Mesh) -> Springs:
    """Springs and masses of a mesh (`model.md` section 3).

    Masses sit at element middles: the spring between two is half of each element in series, the top spring half an
    element.
    """
    axial_half = 2.0 * rig.string.youngs_modulus * mesh.area / mesh.length
    torsional_half = 2.0 / torsional_compliances(rig, mesh)
    return Springs(
        axial=_in_series(axial_half),
        torsional=_in_series(torsional_half),
        mass=rig.string.density * steel_area(rig, mesh) * mesh.length,
        inertia=rig.string.density * steel_polar_moment(rig, mesh) * mesh.length,
    )


def longest_step(rig: Rig, mesh: Mesh) -> float:
    """Longest stable time step, s: 2 / omega of the fastest mode, bounded by Gershgorin's circles.

    The contact of a usual hole adds next to nothing to the springs. One that hardly gives before it slides does, and
    the more the longer the elements are.
    """
    s, held = springs(rig, mesh), _contact_stiffness(rig, mesh)
    axial = 2.0 * (s.axial[:-1] + s.axial[1:]) / s.mass
    torsional = 2.0 * (s.torsional[:-1] + s.torsional[1:]) / s.inertia
    alone = max(float(np.max(axial)), float(np.max(torsional)))
    held_rotation = held * contact_radius(rig, mesh) ** 2
    together = max(float(np.max(axial + held / s.mass)), float(np.max(torsional + held_rotation / s.inertia)))
    return 2.0 * min(_STEP_MARGIN / math.sqrt(alone), _STEP_MARGIN_WITH_CONTACT / math.sqrt(together))


def _contact_stiffness(rig: Rig, mesh: Mesh) -> Array:
    """(n,) N/m, the most that a contact may have: pressed by its weight, and by what hangs below or is pushed there."""
    weight = buoyed_weight(rig, mesh)
    below = np.cumsum((weight * mesh.cosine)[::-1])[::-1]
    bend = np.hypot(mesh.vertical_curvature, mesh.lateral_curvature) + rig.effects.tortuosity.curvature
    pressed = np.abs(weight * mesh.sine) + np.maximum(np.abs(below), _PUSHED) * bend * mesh.length
    return np.asarray(_stiffness_per_load(rig.contact) * pressed)


def friction_curve(contact: Contact) -> FrictionCurve:
    """The contact's friction as 1 / mu over cos^2(beta_v): a table, and a polynomial where that is accurate."""
    polynomial, table = _friction_fit(contact.shear_factor, contact.asperity)
    orientation = contact.asperity.orientation
    return FrictionCurve(
        polynomial=polynomial,
        table=table,
        axial=math.cos(orientation),
        tangential=math.sin(orientation),
        exponent=contact.dahl_exponent,
        stiffness_per_load=_stiffness_per_load(contact),
    )


@lru_cache(maxsize=16)
def _friction_fit(shear_factor: float, asperity: Asperity) -> tuple[Array, Array]:
    """Polynomial, empty where it is inaccurate, and table. Fits vary the contact's stiffness, which changes neither."""
    table = 1.0 / friction_table(shear_factor, asperity)
    q = np.linspace(0.0, 1.0, len(table))
    fit = np.polynomial.Polynomial.fit(q, table, _POLYNOMIAL_DEGREE).convert()
    coefficients = np.zeros(_POLYNOMIAL_DEGREE + 1)
    coefficients[: len(fit.coef)] = fit.coef
    smooth = bool(np.max(np.abs(fit(q) / table - 1.0)) < POLYNOMIAL_TOLERANCE)
    return coefficients if smooth else np.empty(0), np.ascontiguousarray(table)


def elements(rigs: Sequence[Rig], mesh: Mesh, dt: float, modifiers: Sequence[Modifiers]) -> Elements:
    """Constants of every element of every lane, one rig and modifier a lane."""
    columns = [_element_column(rig, mesh, dt, extra) for rig, extra in zip(rigs, modifiers, strict=True)]
    return Elements(
        *(
            padded(np.stack([getattr(column, name) for column in columns], axis=1), mesh.count)
            for name in Elements._fields
        )
    )


def lanes(rigs: Sequence[Rig], mesh: Mesh, dt: float, observer: Observer | None = None) -> Lanes:
    """Constants of every run, one rig a lane; observer: of all of them."""
    rows = [_lane_row(rig, mesh, dt) | _observer_row(rig, mesh, dt, observer) for rig in rigs]
    return Lanes(*(np.array([row[name] for row in rows], dtype=float) for name in Lanes._fields))


def common_mesh(rigs: Sequence[Rig], count: int) -> Mesh:
    """The mesh that a batch shares.

    Raises InputError where the rigs differ in what lanes must share: survey, sections, friction law and sound speed.
    """
    first = rigs[0]
    for rig in rigs[1:]:
        for key in _SHARED_BY_LANES:
            value = attrgetter(key)
            if value(first) != value(rig):
                raise InputError(f"batch: {key} differs between its rigs; simulate them one by one")
    return build_mesh(first, count)


# The friction curve is one for all lanes. Stiffness per load is not part of it: it scales every element's constants.
_SHARED_BY_LANES = (
    "well.survey", "string.sections", "contact.shear_factor", "contact.asperity", "contact.dahl_exponent",
    "mud.sound_speed",
)  # fmt: skip


def _in_series(half: Array) -> Array:
    between = 1.0 / (1.0 / half[:-1] + 1.0 / half[1:])
    return np.concatenate([half[:1], between, [0.0]])


def _stiffness_per_load(contact: Contact) -> float:
    """Contact stiffness per normal force, 1/m: contact area is proportional to load (`model.md` section 2)."""
    return contact.stiffness / contact.reference_load


def _element_column(rig: Rig, mesh: Mesh, dt: float, extra: Modifiers) -> Elements:
    """Constants of one rig's elements, (n,) each, springs with the ghost row."""
    s = springs(rig, mesh)
    effects = rig.effects
    weight = buoyed_weight(rig, mesh)
    drag = effects.viscous_drag.coefficient * mesh.length
    axial_decay = 1.0 / (1.0 + dt * (rig.string.axial_damping + drag / s.mass))
    rotary_drag = drag * contact_radius(rig, mesh) ** 2 / s.inertia
    torsional_decay = 1.0 / (1.0 + dt * (rig.string.torsional_damping + rotary_drag))
    tortuous = effects.tortuosity.curvature * open_hole_fraction(rig, mesh) + extra.extra_curvature
    bending = 4.0 * rig.string.youngs_modulus * mesh.second_moment
    factor = friction_factors(rig, mesh) * extra.friction_factor
    per_load = _stiffness_per_load(rig.contact)
    return Elements(
        axial_spring=s.axial,
        torsional_spring=s.torsional,
        axial_push=dt / s.mass * axial_decay,
        torsional_push=dt / s.inertia * torsional_decay,
        axial_decay=axial_decay,
        torsional_decay=torsional_decay,
        axial_force=weight * mesh.cosine + extra.axial_force,
        side_weight=per_load * weight * mesh.sine,
        vertical_bend=per_load * mesh.vertical_curvature * mesh.length,
        lateral_bend=per_load * mesh.lateral_curvature * mesh.length,
        extra_bend=per_load * tortuous * mesh.length,
        buckling=per_load * effects.buckling_contact.factor * mesh.clearance / bending * mesh.length,
        radius=contact_radius(rig, mesh),
        per_sliding_length=per_load / np.maximum(factor, MIN_FRICTION_FACTOR),
        stribeck_drop=np.full(mesh.count, effects.stribeck.drop),
        per_stribeck_speed=np.full(mesh.count, 1.0 / effects.stribeck.speed),
        aging_growth=np.full(mesh.count, effects.static_aging.growth),
        per_aging_time=np.full(mesh.count, 1.0 / effects.static_aging.time),
        rest_speed=np.full(mesh.count, effects.static_aging.rest_speed),
        per_slip_distance=np.full(mesh.count, 1.0 / effects.static_aging.slip_distance),
        drift_rate=np.full(mesh.count, effects.friction_drift.rate),
        turning_difference=np.zeros(mesh.count) + extra.turning_difference,
        elastic_share=np.full(mesh.count, rig.contact.elastic_share),
        vector_share=np.full(mesh.count, rig.contact.vector_share),
    )


def _lane_row(rig: Rig, mesh: Mesh, dt: float) -> dict[str, float]:
    effects, bit, motor, hydraulics = rig.effects, rig.bit, rig.motor, rig.hydraulics
    tool_element = int(np.argmin(np.abs(mesh.middle - effects.axial_oscillation_tool.depth)))
    return {
        "cutting_stiffness": bit.depth_of_cut_stiffness,
        "formation_factor": effects.formation_change.factor,
        "formation_time": effects.formation_change.time,
        "bit_lever": bit.lever,
        "torque_per_pressure": motor.torque_per_pressure * (1.0 - effects.motor_wear.torque_loss),
        "motor_displacement": motor.displacement,
        "leak": (motor.leak + effects.motor_wear.extra_leak) * motor.leak_over_stall,
        "stall_pressure": motor.pressure_at_stall,
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


def _observer_row(rig: Rig, mesh: Mesh, dt: float, observer: Observer | None) -> dict[str, float]:
    if observer is None:
        return {"observer_gain": 0.0, "observer_leak": 0.0, "observer_response": 1.0}
    return {
        "observer_gain": observer.gain / torsional_impedance(rig, mesh),
        "observer_leak": 1.0 / observer.memory,
        "observer_response": _gain(dt, observer.smoothing),
    }


def _gain(dt: float, lag: float) -> float:
    """Fraction of the way to its target that a first-order lag goes in one step of dt s."""
    return 1.0 - math.exp(-dt / lag) if lag > 0.0 else 1.0
