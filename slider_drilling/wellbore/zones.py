"""The three zones of slide drilling (paper 2.2, Fig. 5): rocked from surface, static, turned by the reactive torque.

In closed form a torque T reaches as far as the friction torque of the pipe that it must turn adds up to it,

    integral of mu w_n R ds = T,

from the rig floor down for the surface torque, from the bit up for the reactive torque.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.wellbore.well_path import Array


@dataclass(frozen=True)
class Zones:
    """Measured depths, m: rocking reaches down to rocked_to, the reactive torque up to reactive_from."""

    rocked_to: float
    reactive_from: float

    @property
    def static_length(self) -> float:
        """Pipe between the two that nothing turns, m; zero where they meet."""
        return max(self.reactive_from - self.rocked_to, 0.0)


def zones_in_closed_form(length: Array, turning_torque: Array, surface_torque: float, reactive_torque: float) -> Zones:
    """Where torques (N m, magnitudes) end along a string whose elements, of length (n,) m, take turning_torque (n,)
    N m to turn.

    ``surface_torque`` is half the peak-to-peak of a rocking cycle: at each reversal friction turns round with it, so
    twice the friction opposes twice the torque.
    """
    edges = np.concatenate([[0.0], np.cumsum(length)])
    from_top = np.concatenate([[0.0], np.cumsum(turning_torque)])
    from_bit = from_top[-1] - from_top
    return Zones(
        rocked_to=float(np.interp(surface_torque, from_top, edges)),
        reactive_from=float(np.interp(reactive_torque, from_bit[::-1], edges[::-1])),
    )
