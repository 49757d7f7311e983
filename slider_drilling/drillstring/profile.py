"""The string along its length at one instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring.layout import Array, Curve, Elements, State
from slider_drilling.drillstring.mesh import Mesh


@dataclass(frozen=True)
class Profile:
    """The string as it is now, each (n,), surface first.

    measured_depth: m, of element middles; tension: N, mean over the element; torque: N m, at its top; rotation: rad;
    rotation_speed: rad/s; axial_speed: m/s; normal_force: N/m; friction_coefficient: -, with all factors; beta_v: rad
    in [0, pi/2], direction of slip from the asperity's axis; axial_friction and tangential_friction: N, on the pipe.
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


def profile_of(mesh: Mesh, e: Elements, curve: Curve, s: State) -> Profile:
    """The profile of a single run (one lane), by the formulas of the kernel's `push`."""
    middle = slice(1, -1)
    spring_pull = e.axial_spring[1:] * np.diff(s.position)
    spring_twist = -e.torsional_spring[1:] * np.diff(s.rotation)
    tension = 0.5 * (spring_pull[:-1] + spring_pull[1:])
    vertical = e.side_weight[middle] - tension * e.vertical_bend[middle]
    lateral = tension * e.lateral_bend[middle]
    load = np.hypot(vertical, lateral) + np.abs(tension) * e.extra_bend[middle]
    load += e.buckling[middle] * np.minimum(tension, 0.0) ** 2
    along, across = s.strain_axial[middle], s.strain_tangential[middle]
    onto_axis = curve.axial * along + curve.tangential * across
    size = np.hypot(along, across)
    return Profile(
        measured_depth=mesh.middle,
        length=mesh.length,
        tension=tension,
        torque=spring_twist[:-1],
        rotation=s.rotation[middle].copy(),
        rotation_speed=s.rotation_speed[middle].copy(),
        axial_speed=s.speed[middle].copy(),
        normal_force=load / mesh.length,
        friction_coefficient=s.friction[middle].copy(),
        beta_v=np.arccos(np.clip(np.abs(onto_axis) / np.maximum(size, 1e-15), 0.0, 1.0)),
        axial_friction=-e.grip[middle] * load * along,
        tangential_friction=-e.grip[middle] * load * across,
    )
