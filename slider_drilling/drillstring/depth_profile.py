"""The depth profile: the string along its length at one instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring.kernel_arrays import Array, Elements, FrictionCurve, KernelState
from slider_drilling.wellbore.mesh import Mesh


@dataclass(frozen=True)
class DepthProfile:
    """The string along its length at one instant, each (n,), surface first.

    Attributes:
        measured_depth: m, of the elements' middles.
        length: m, of the elements.
        tension: N, mean over the element.
        torque: N m, at the element's top.
        rotation, rotation_speed: rad and rad/s.
        axial_speed: m/s.
        normal_force: N/m.
        friction_coefficient: With all factors.
        beta_v: rad in [0, pi/2], angle between slip and the asperity's axis.
        axial_friction, tangential_friction: N, on the pipe.
    """

    measured_depth: Array
    length: Array
    tension: Array
    torque: Array
    rotation: Array
    rotation_speed: Array
    axial_speed: Array
    normal_force: Array
    friction_coefficient: Array
    beta_v: Array
    axial_friction: Array
    tangential_friction: Array


def contact_stiffness(
    tension: Array, side_weight: Array, vertical_bend: Array, lateral_bend: Array, extra_bend: Array, buckling: Array
) -> Array:
    """Stiffness (N/m) of contacts whose elements have this mean tension (N), as in `kernel.update_speeds`.

    All arrays have one shape; the others are fields of `kernel_arrays.Elements`.
    """
    stiffness = np.hypot(side_weight - tension * vertical_bend, tension * lateral_bend)
    return stiffness + np.abs(tension) * extra_bend + buckling * np.minimum(tension, 0.0) ** 2


def inverse_friction(curve: FrictionCurve, direction: Array | float) -> Array:
    """1 / mu for slip in a direction, given as the cosine between slip and the asperity's axis."""
    places = np.linspace(0.0, 1.0, len(curve.table))
    return np.asarray(np.interp(np.square(direction), places, curve.table))


def compute_profile(mesh: Mesh, e: Elements, curve: FrictionCurve, s: KernelState) -> DepthProfile:
    """The profile of a single run (one lane), by the equations of `kernel.update_speeds`."""
    n = mesh.count
    spring_pull = e.axial_spring[: n + 1] * np.diff(s.position[: n + 2])
    spring_twist = -e.torsional_spring[: n + 1] * np.diff(s.rotation[: n + 2])
    tension = 0.5 * (spring_pull[:-1] + spring_pull[1:])
    stiffness = contact_stiffness(
        tension, e.side_weight[:n], e.vertical_bend[:n], e.lateral_bend[:n], e.extra_bend[:n], e.buckling[:n]
    )
    along, across = s.strain_axial[:n], s.strain_tangential[:n]
    onto_axis = curve.axial * along + curve.tangential * across
    direction = np.clip(np.abs(onto_axis) / np.maximum(np.hypot(along, across), 1e-15), 0.0, 1.0)
    friction = curve.stiffness_per_load / (s.per_sliding_length[:n] * inverse_friction(curve, direction))
    return DepthProfile(
        measured_depth=mesh.middle,
        length=mesh.length,
        tension=tension,
        torque=spring_twist[:-1],
        rotation=s.rotation[1 : n + 1].copy(),
        rotation_speed=s.rotation_speed[:n].copy(),
        axial_speed=s.speed[:n].copy(),
        normal_force=stiffness / curve.stiffness_per_load / mesh.length,
        friction_coefficient=friction,
        beta_v=np.arccos(direction),
        axial_friction=-stiffness * along,
        tangential_friction=-stiffness * across,
    )
