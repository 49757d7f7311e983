"""The three zones of slide drilling in closed form (paper 2.2, Fig. 5).

From surface down the string is rocked, then static, then turned by the reactive torque. A torque T reaches as far as
the friction torque of the pipe that it turns adds up to it,

    integral of mu w_n R ds = T,

from the rig floor down for the surface torque, from the bit up for the reactive torque.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.wellbore.well_path import Array


@dataclass(frozen=True)
class Zones:
    """Measured depths (m): rocking reaches down to rocked_to, the reactive torque up to reactive_from."""

    rocked_to: float
    reactive_from: float

    @property
    def static_length(self) -> float:
        """Length of the static zone between the two, m; zero where they meet."""
        return max(self.reactive_from - self.rocked_to, 0.0)


def zones_in_closed_form(length: Array, turning_torque: Array, surface_torque: float, reactive_torque: float) -> Zones:
    """Depths at which torques from both ends are used up by friction.

    Args:
        length: Of the elements, m, (n,).
        turning_torque: Torque that turns each element against friction, N m, (n,).
        surface_torque: Half the peak-to-peak of a rocking cycle, N m: at each reversal friction reverses too, so twice
            the friction opposes twice the torque.
        reactive_torque: N m.
    """
    edges = np.concatenate([[0.0], np.cumsum(length)])
    from_top = np.concatenate([[0.0], np.cumsum(turning_torque)])
    from_bit = from_top[-1] - from_top
    return Zones(
        rocked_to=float(np.interp(surface_torque, from_top, edges)),
        reactive_from=float(np.interp(reactive_torque, from_bit[::-1], edges[::-1])),
    )
