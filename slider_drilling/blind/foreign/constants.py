"""The constants of a foreign plant's step, from a rig and a structure."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from slider_drilling.blind.foreign.structure import Structure
from slider_drilling.contact import friction_table
from slider_drilling.drillstring import Modifiers
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import (
    GRAVITY,
    Mesh,
    friction_factors,
    open_hole_fraction,
    steel_area,
    steel_polar_moment,
)

_STEP_SHARE = 0.85  # of the longest stable step
# Stretch per load of the rig file's contact at which `Structure.presliding` is meant, 1/m (`model.md` section 2).
_NOMINAL_GRIP = 42700.0 / 1887.0


class ElementConstants(NamedTuple):
    """Of each element, (n,)."""

    mass: Array  # kg
    inertia: Array  # kg m2
    axial_spring: Array  # N/m, above the element's middle
    torsional_spring: Array  # N m/rad, likewise
    axial_load: Array  # N, buoyed weight along the hole and other pushes
    side_weight: Array  # N, buoyed weight across it
    vertical_turn: Array  # rad, change of inclination over the element
    lateral_turn: Array  # rad, change of azimuth, times sin(inclination)
    extra_turn: Array  # rad, of tortuosity
    buckling: Array  # 1/N, side force per compression squared
    beam_force: Array  # N, side force of the bent pipe itself
    radius: Array  # m, at which friction acts
    friction_factor: Array  # -
    viscous_drag: Array  # N s/m


class RunConstants(NamedTuple):
    """Of the run; shares are 1 - exp(-dt / lag)."""

    axial_damping: float
    torsional_damping: float
    presliding: float
    break_away: float
    creep_speed: float
    friction_state: float
    axis: float
    axis_across: float
    cutting_stiffness: float
    bit_lever: float
    torque_per_pressure: float
    motor_displacement: float
    leak: float
    stall_pressure: float
    pump_displacement: float
    circulating_pressure: float
    reference_flow: float
    pressure_share: float
    torque_gain: float
    torque_share: float
    torque_bias: float
    motor_inertia: float
    motor_friction: float
    half_backlash: float
    heave_amplitude: float
    heave_frequency: float
    heave_phase: float
    tool_force: float
    tool_frequency: float
    tool_element: float
    stribeck_drop: float
    stribeck_speed: float
    aging_growth: float
    aging_time: float
    rest_speed: float
    slip_distance: float
    drift_rate: float
    formation_factor: float
    formation_time: float
    drive_lag: float
    drive_droop: float
    ripple: float
    filter_share: float
    warming: float
    warming_time: float
    pump_ripple: float
    depth_offset: float
    tool_face_offset: float


def element_constants(rig: Rig, mesh: Mesh, modifiers: Modifiers, structure: Structure) -> ElementConstants:
    """Constants of the elements; tool joints are on all pipe but the widest section, the bottom-hole assembly."""
    effects, steel, length = rig.effects, rig.string, mesh.length
    jointed = np.where(mesh.outer_radius < np.max(mesh.outer_radius) - 1e-9, 1.0, 0.0)
    heavier = 1.0 + structure.joint_weight * jointed
    weight = GRAVITY * (steel.density - rig.mud.density) * steel_area(rig, mesh) * length * heavier
    displaced = rig.mud.density * math.pi * mesh.outer_radius**2 * length
    axial = 2.0 * steel.youngs_modulus * mesh.area / length
    torsion = 2.0 * steel.shear_modulus * mesh.polar_moment / length
    torsion = torsion * (1.0 + structure.joint_stiffness * jointed) / (1.0 + effects.torsional_compliance.extra)
    vertical, lateral, beam = _stiffened(rig, mesh, structure)
    bending = 4.0 * steel.youngs_modulus * mesh.second_moment
    return ElementConstants(
        mass=steel.density * steel_area(rig, mesh) * length * heavier + structure.added_mass * displaced,
        # Joints are wider than the pipe: what they add to its inertia counts about twice what it adds to its mass.
        inertia=steel.density * steel_polar_moment(rig, mesh) * length * (2.0 * heavier - 1.0),
        axial_spring=_in_series(axial),
        torsional_spring=_in_series(torsion),
        axial_load=weight * mesh.cosine + modifiers.axial_force,
        side_weight=weight * mesh.sine,
        vertical_turn=vertical * length,
        lateral_turn=lateral * length,
        extra_turn=(effects.tortuosity.curvature * open_hole_fraction(rig, mesh) + modifiers.extra_curvature) * length,
        buckling=effects.buckling_contact.factor * mesh.clearance * length / bending,
        beam_force=beam,
        radius=mesh.outer_radius * (1.0 + structure.joint_radius * jointed),
        friction_factor=friction_factors(rig, mesh) * modifiers.friction_factor,
        viscous_drag=effects.viscous_drag.coefficient * length,
    )


def _stiffened(rig: Rig, mesh: Mesh, structure: Structure) -> tuple[Array, Array, Array]:
    """Curvatures (n,) that the pipe's bending stiffness has spread, rad/m, and the beam's side force (n,), N."""
    if structure.bending_length <= 0.0:
        return mesh.vertical_curvature, mesh.lateral_curvature, np.zeros(mesh.count)
    away = (mesh.middle[:, None] - mesh.middle[None, :]) / structure.bending_length
    weights = np.exp(-0.5 * away**2) * mesh.length[None, :]
    weights /= weights.sum(axis=1, keepdims=True)
    vertical, lateral = weights @ mesh.vertical_curvature, weights @ mesh.lateral_curvature
    second = np.gradient(np.gradient(vertical, mesh.middle), mesh.middle)
    stiffness = rig.string.youngs_modulus * mesh.second_moment
    return vertical, lateral, structure.bending_force * stiffness * second * mesh.length


def _in_series(half: Array) -> Array:
    """(n,) spring above each element's middle; the first is the half element below the drive."""
    return np.concatenate([half[:1], 1.0 / (1.0 / half[:-1] + 1.0 / half[1:])])


def longest_step(elements: ElementConstants) -> float:
    """s, of explicit integration, by Gershgorin's circles."""
    fastest = 0.0
    for spring, mass in (
        (elements.axial_spring, elements.mass), (elements.torsional_spring, elements.inertia)
    ):  # fmt: skip
        fastest = max(fastest, float(np.max(2.0 * (spring + np.append(spring[1:], 0.0)) / mass)))
    return _STEP_SHARE * 2.0 / math.sqrt(fastest)


def friction_over_direction(rig: Rig, structure: Structure) -> Array:
    """Friction coefficient over q = cos^2 of the slip's angle to the asperity's axis."""
    table = friction_table(rig.contact.shear_factor, rig.contact.asperity)
    return np.asarray(table + structure.isotropy * (table.mean() - table))


def run_constants(
    rig: Rig, mesh: Mesh, structure: Structure, dt: float, depth_offset: float, tool_face_offset: float
) -> RunConstants:
    """Constants of the run.

    Args:
        rig: as it really is.
        mesh: of its string.
        structure: how the plant differs.
        dt: s, of a step.
        depth_offset: m, measured depth of the bit less its position.
        tool_face_offset: rad, toolface less the rotation of the lowest element.
    """
    effects, bit, motor, hydraulics = rig.effects, rig.bit, rig.motor, rig.hydraulics
    tool, heave, aging = effects.axial_oscillation_tool, effects.heave, effects.static_aging
    orientation = rig.contact.asperity.orientation
    grip = rig.contact.stiffness / rig.contact.reference_load
    return RunConstants(
        axial_damping=rig.string.axial_damping,
        torsional_damping=rig.string.torsional_damping,
        presliding=structure.presliding * _NOMINAL_GRIP / grip,
        break_away=structure.break_away,
        creep_speed=structure.creep_speed,
        friction_state=float(structure.friction_state),
        axis=math.cos(orientation),
        axis_across=math.sin(orientation),
        cutting_stiffness=bit.depth_of_cut_stiffness,
        bit_lever=bit.lever,
        torque_per_pressure=motor.torque_per_pressure * (1.0 - effects.motor_wear.torque_loss),
        motor_displacement=motor.displacement,
        leak=motor.leak + effects.motor_wear.extra_leak,
        stall_pressure=motor.max_pressure,
        pump_displacement=rig.mud_pump.displacement,
        circulating_pressure=rig.circulating_pressure,
        reference_flow=hydraulics.reference_flow,
        pressure_share=_share(dt, hydraulics.lag),
        torque_gain=(1.0 + effects.torque_sensor_gain.gain) * (1.0 + structure.torque_gain),
        torque_share=_share(dt, effects.torque_sensor_lag.lag),
        torque_bias=effects.torque_sensor_bias.bias,
        motor_inertia=effects.torque_at_motor.inertia,
        motor_friction=effects.torque_at_motor.friction,
        half_backlash=0.5 * effects.top_drive_backlash.angle,
        heave_amplitude=heave.amplitude,
        heave_frequency=2.0 * math.pi / heave.period,
        heave_phase=heave.phase,
        tool_force=tool.force,
        tool_frequency=2.0 * math.pi * tool.frequency,
        tool_element=float(np.argmin(np.abs(mesh.middle - tool.depth))),
        stribeck_drop=effects.stribeck.drop,
        stribeck_speed=effects.stribeck.speed,
        aging_growth=aging.growth,
        aging_time=aging.time,
        rest_speed=aging.rest_speed,
        slip_distance=aging.slip_distance,
        drift_rate=effects.friction_drift.rate,
        formation_factor=effects.formation_change.factor,
        formation_time=effects.formation_change.time,
        drive_lag=max(structure.drive_lag, dt),
        drive_droop=structure.drive_droop,
        ripple=structure.ripple,
        filter_share=_share(dt, structure.torque_filter),
        warming=structure.warming,
        warming_time=structure.warming_time,
        pump_ripple=structure.pump_ripple,
        depth_offset=depth_offset,
        tool_face_offset=tool_face_offset,
    )


def _share(dt: float, lag: float) -> float:
    """Share of the way to its target that a first-order lag goes in one step."""
    return 1.0 - math.exp(-dt / lag) if lag > 0.0 else 1.0
