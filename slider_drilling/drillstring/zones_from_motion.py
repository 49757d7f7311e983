"""The three zones of a simulated string: friction torque along it, and the zones that its motion shows."""

from __future__ import annotations

import numpy as np

from slider_drilling.contact import friction_coefficient_of_direction
from slider_drilling.drillstring.depth_profile import DepthProfile
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.simulate import Plant
from slider_drilling.wellbore.mesh import contact_radius, friction_factors
from slider_drilling.wellbore.zones import Zones

SLIP_SWING = 0.16
"""rad by which 5 in pipe turns over the contact's pre-sliding length of 10 mm (`model.md` section 2)."""


def friction_torque(plant: Plant, profile: DepthProfile) -> Array:
    """Torque (n,) N m that turns each element against friction at its present side force, with little axial slip."""
    across = np.pi / 2.0 - plant.rig.contact.asperity.orientation
    friction = float(friction_coefficient_of_direction(plant.rig.contact, across))
    side_force = profile.normal_force * profile.length
    lever = contact_radius(plant.rig, plant.mesh)
    return friction * friction_factors(plant.rig, plant.mesh) * side_force * lever


def zones_from_motion(
    measured_depth: Array,
    rotation: Array,
    torque: Array,
    reactive_torque: float,
) -> Zones:
    """The zones that one full simulated rocking cycle shows: rocking reaches to where contacts slip.

    Args:
        measured_depth: m, (n,).
        rotation, torque: rad and N m over the cycle, (m, n).
        reactive_torque: N m; it reaches up to where the cycle's mean torque still holds a twentieth of it.
    """
    swing = np.ptp(rotation, axis=0)
    rocked = np.flatnonzero(swing < SLIP_SWING)
    rocked_to = _crossing(measured_depth, swing, SLIP_SWING, int(rocked[0])) if len(rocked) else measured_depth[-1]
    held = np.mean(torque, axis=0)
    faded = np.flatnonzero(np.abs(held) < 0.05 * reactive_torque)
    reactive_from = measured_depth[faded[-1]] if len(faded) else measured_depth[0]
    return Zones(float(rocked_to), float(reactive_from))


def _crossing(depth: Array, value: Array, level: float, first_below: int) -> float:
    """Depth at which a falling value crosses a level, interpolated between two elements."""
    if first_below == 0:
        return float(depth[0])
    above, below = first_below - 1, first_below
    fraction = (value[above] - level) / (value[above] - value[below])
    return float(depth[above] + fraction * (depth[below] - depth[above]))
