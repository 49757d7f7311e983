"""The three zones of slide drilling (paper 2.2, Fig. 5): rocked from surface, static, turned by the reactive torque.

In closed form a torque T reaches as far as the friction torque of the pipe that it must turn adds up to it,

    integral of mu w_n R ds = T,

from the rig floor down for the surface torque, from the bit up for the reactive torque.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.contact import friction_coefficient_of_direction
from slider_drilling.drillstring.layout import Array
from slider_drilling.drillstring.profile import Profile
from slider_drilling.drillstring.simulate import Plant
from slider_drilling.wellbore.mesh import friction_factors

PRE_SLIDING_SWING = 0.16
"""rad, by which 5 in pipe turns over the contact's pre-sliding length of 10 mm (mu / grip, model.md section 2)."""


@dataclass(frozen=True)
class Zones:
    """Measured depths, m: rocking reaches down to rocked_to, the reactive torque up to reactive_from."""

    rocked_to: float
    reactive_from: float

    @property
    def static_length(self) -> float:
        """Pipe between the two that nothing turns, m; zero where they meet."""
        return max(self.reactive_from - self.rocked_to, 0.0)


def turning_friction(plant: Plant, profile: Profile) -> Array:
    """Torque (n,) N m that turns each element against friction at its present side force, axial slip being slow."""
    across = np.pi / 2.0 - plant.rig.contact.asperity.orientation
    friction = float(friction_coefficient_of_direction(plant.rig.contact, across))
    side_force = profile.normal_force * profile.length
    return friction * friction_factors(plant.rig, plant.mesh) * side_force * plant.mesh.outer_radius


def zones_in_closed_form(
    profile: Profile, turning_torque: Array, surface_torque: float, reactive_torque: float
) -> Zones:
    """Where torques (N m, magnitudes) end along a string whose elements take turning_torque (n,) to turn.

    ``surface_torque`` is half the peak-to-peak of a rocking cycle: at each reversal friction turns round with it, so
    twice the friction opposes twice the torque.
    """
    edges = np.concatenate([[0.0], np.cumsum(profile.length)])
    from_top = np.concatenate([[0.0], np.cumsum(turning_torque)])
    from_bit = from_top[-1] - from_top
    return Zones(
        rocked_to=float(np.interp(surface_torque, from_top, edges)),
        reactive_from=float(np.interp(reactive_torque, from_bit[::-1], edges[::-1])),
    )


def zones_from_motion(
    measured_depth: Array,
    rotation: Array,
    torque: Array,
    reactive_torque: float,
    least_swing: float = PRE_SLIDING_SWING,
) -> Zones:
    """The zones that a simulated cycle shows.

    measured_depth: (n,) m; rotation: (m, n) rad and torque: (m, n) N m over one full rocking cycle. Rocking reaches
    where rotation swings by more than least_swing (rad, peak to peak), less than which the contacts only bend. The
    reactive torque (N m) reaches where the cycle's mean torque still holds a twentieth of it.
    """
    swing = np.ptp(rotation, axis=0)
    rocked = np.flatnonzero(swing < least_swing)
    rocked_to = _crossing(measured_depth, swing, least_swing, int(rocked[0])) if len(rocked) else measured_depth[-1]
    held = np.mean(torque, axis=0)
    faded = np.flatnonzero(np.abs(held) < 0.05 * reactive_torque)
    reactive_from = measured_depth[faded[-1]] if len(faded) else measured_depth[0]
    return Zones(float(rocked_to), float(reactive_from))


def _crossing(depth: Array, value: Array, level: float, first_below: int) -> float:
    """Depth at which a falling value passes a level, between two elements."""
    if first_below == 0:
        return float(depth[0])
    above, below = first_below - 1, first_below
    share = (value[above] - level) / (value[above] - value[below])
    return float(depth[above] + share * (depth[below] - depth[above]))
