"""Static torque and drag: the loads of a string that is raised, lowered or rotated steadily.

The soft string of `model.md` section 3 without inertia. Going up from the bit, with T the tension, M the torque, w_b
the buoyed weight per metre, w_n the side force and mu the friction of a slip in this direction,

    dT = (w_b cos t + mu w_n v_down / v) ds   (lowering takes tension away: v_down is minus the axial speed)
    dM = mu w_n R v_around / v ds
    w_n = sqrt((w_b sin t - T dt/ds)^2 + (T sin t da/ds)^2) + |T| k_t + k_b min(T, 0)^2,

where k_t is tortuosity and k_b buckled pipe, if the rig file has these effects.

Each element is integrated by the implicit midpoint rule, of second order in its length: with 200 elements the
exponential growth of tension around a quarter turn comes out within 1e-5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.contact import friction_coefficient_of_direction
from slider_drilling.errors import InputError
from slider_drilling.process.jit_cache import JIT_OPTIONS, njit
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import (
    Mesh,
    build_mesh,
    buoyed_weight,
    contact_radius,
    friction_factors,
    open_hole_fraction,
)
from slider_drilling.wellbore.well_path import Array

_MAX_ITERATIONS = 50
_TOLERANCE = 1e-12  # relative; the midpoint's tension converges by a factor of mu * bend / 2 an iteration


@dataclass(frozen=True)
class StaticLoads:
    """Loads along a string: depth m, tension N and torque N m at element ends (n + 1,), side_force N/m (n,)."""

    measured_depth: Array
    tension: Array
    torque: Array
    side_force: Array

    @property
    def hook_load(self) -> float:
        """Hook load of the string alone, N."""
        return float(self.tension[0])

    @property
    def surface_torque(self) -> float:
        """Torque of the top drive, N m."""
        return float(self.torque[0])


def static_loads(
    rig: Rig,
    axial_speed: float = 0.0,
    rotation_speed: float = 0.0,
    weight_on_bit: float = 0.0,
    bit_torque: float = 0.0,
    friction_coefficient: float | None = None,
    elements: int = 200,
    mesh: Mesh | None = None,
) -> StaticLoads:
    """Loads along a string that moves steadily, or hangs without friction where both speeds are zero.

    Args:
        rig: The rig.
        axial_speed: m/s, positive lowers. Only the ratio of the two speeds matters.
        rotation_speed: rad/s, positive clockwise.
        weight_on_bit, bit_torque: N and N m.
        friction_coefficient: One for every slip, times the well's friction intervals; None for that of the rig's
            contact in the direction of slip.
        elements: Of the mesh.
        mesh: `build_mesh(rig, elements)`, if it exists already.

    Raises:
        InputError: For a number that is not finite and for a friction coefficient below zero.
    """
    for name, value in (("axial_speed", axial_speed), ("rotation_speed", rotation_speed),
                        ("weight_on_bit", weight_on_bit), ("bit_torque", bit_torque),
                        ("friction_coefficient", friction_coefficient or 0.0)):  # fmt: skip
        if not math.isfinite(value):
            raise InputError(f"static_loads: {name} = {value}: must be a finite number")
    if friction_coefficient is not None and friction_coefficient < 0.0:
        raise InputError(f"static_loads: friction_coefficient = {friction_coefficient}: must not be negative")
    mesh = mesh or build_mesh(rig, elements)
    lever = contact_radius(rig, mesh)
    around = rotation_speed * lever
    speed = np.hypot(axial_speed, around)
    still = speed == 0.0
    speed = np.where(still, 1.0, speed)
    if friction_coefficient is None:
        slip = np.arctan2(around, axial_speed) - rig.contact.asperity.orientation
        coefficient = friction_coefficient_of_direction(rig.contact, slip)
    else:
        coefficient = np.full(mesh.count, friction_coefficient)
    friction = np.where(still, 0.0, coefficient * friction_factors(rig, mesh))
    weight = buoyed_weight(rig, mesh)
    tension, torque, side = _integrate(
        weight * mesh.cosine, weight * mesh.sine, mesh.vertical_curvature * mesh.length,
        mesh.lateral_curvature * mesh.length, *_extra_side_force(rig, mesh), friction * axial_speed / speed,
        friction * around / speed * lever, -weight_on_bit, bit_torque,
    )  # fmt: skip
    return StaticLoads(np.append(mesh.top, mesh.bottom[-1]), tension, torque, side / mesh.length)


def _extra_side_force(rig: Rig, mesh: Mesh) -> tuple[Array, Array]:
    """Side force of tortuosity per tension (n,), and of buckled pipe per squared compression (n,) 1/N, per element."""
    bending = 4.0 * rig.string.youngs_modulus * mesh.second_moment
    return (rig.effects.tortuosity.curvature * open_hole_fraction(rig, mesh) * mesh.length,
            rig.effects.buckling_contact.factor * mesh.clearance / bending * mesh.length)


@njit(**JIT_OPTIONS | {"_nrt": True})
def _integrate(
    weight, side_weight, vertical_bend, lateral_bend, tortuous_bend, buckling, drag, lever, tension_at_bit,
    torque_at_bit,
):
    """Tension and torque (n + 1,) and side force of each element (n,) N, from the bit up.

    drag, lever: Drag (N) and torque (N m) per side force.
    """
    n = len(weight)
    tension, torque, side = np.empty(n + 1), np.empty(n + 1), np.empty(n)
    tension[n], torque[n] = tension_at_bit, torque_at_bit
    for i in range(n - 1, -1, -1):
        top = tension[i + 1] + weight[i]
        for _ in range(_MAX_ITERATIONS):
            middle = 0.5 * (tension[i + 1] + top)
            vertical = side_weight[i] - middle * vertical_bend[i]
            lateral = middle * lateral_bend[i]
            compression = min(middle, 0.0)
            side[i] = math.sqrt(vertical * vertical + lateral * lateral)
            side[i] += abs(middle) * tortuous_bend[i] + buckling[i] * compression * compression
            before, top = top, tension[i + 1] + weight[i] - drag[i] * side[i]
            if abs(top - before) <= _TOLERANCE * (abs(top) + side[i]):
                break
        tension[i] = top
        torque[i] = torque[i + 1] + lever[i] * side[i]
    return tension, torque, side
