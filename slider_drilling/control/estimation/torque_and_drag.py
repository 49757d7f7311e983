"""Torque-and-drag model of rocking in closed form: how deep it reaches and which torque it takes.

Along a string that turns against friction the torque falls by ``mu w_n R`` per metre (Johancsik's soft string, with
`w_n` from the buoyed weight and the tension). Rocking of half-amplitude A frees the string down to the reach s_r where,
with ``Q(s) = int_0^s mu w_n R ds`` and the compliance ``C(s) = int_0^s ds / GJ``,

    A = Q(s_r) C(s_r) - int_0^s_r Q dC,        breakover torque M = Q(s_r).

Below the reach nothing turns. From the bit up, friction takes the reactive torque T over the length where ``int mu
w_n R ds = T``. Between the two lies the static zone. Inertia is left out on purpose: the friction `scale`, which the
breakover test measures at surface, absorbs its effect.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from slider_drilling.wellbore.mesh import build_mesh, torsional_compliances, torsional_impedance
from slider_drilling.wellbore.static_loads import static_loads
from slider_drilling.wellbore.zones import Zones, zones_in_closed_form

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

Array = NDArray[np.float64]
_SPACING = 10.0  # m between the depths of the model
_MIN_SCALE, _MAX_SCALE = 0.1, 10.0
_BISECTIONS = 40


class TorqueAndDrag:
    """Torque and drag of one string in one well.

    The methods take `scale`: friction over `friction_factor`.

    Args:
        rig: Rig file.
        friction_factor: Coulomb friction factor where the rig file's interval factor is 1.
        weight_on_bit: For the tension, N.

    Attributes:
        compliance: Torsional compliance of the whole string, rad/(N m).
        bit_depth: Measured depth of the bit, m.
        travel_time: Time of a torsional wave from top to bit, s.
        impedance: Torsional wave impedance of the uppermost pipe, N m s/rad.
    """

    def __init__(self, rig: Rig, friction_factor: float, weight_on_bit: float):
        mesh = build_mesh(rig, max(round(rig.string.length / _SPACING), 2))
        loads = static_loads(rig, rotation_speed=1.0, weight_on_bit=weight_on_bit,
                             friction_coefficient=friction_factor, mesh=mesh)
        self._depth = loads.measured_depth
        self._torque = loads.torque[0] - loads.torque   # Q at each depth
        compliance = np.concatenate([[0.0], np.cumsum(torsional_compliances(rig, mesh))])
        integral = 0.5 * (self._torque[1:] + self._torque[:-1]) * np.diff(compliance)
        self._twist = self._torque * compliance - np.concatenate([[0.0], np.cumsum(integral)])   # A at each reach
        self._compliance = compliance
        self.compliance = float(compliance[-1])
        self.bit_depth = float(self._depth[-1])
        self.travel_time = self.bit_depth / rig.string.twist_speed
        self.impedance = torsional_impedance(rig, mesh)

    def full_amplitude(self, scale: float) -> float:
        """Half-amplitude (rad) at which rocking just reaches the bit."""
        return scale * float(self._twist[-1])

    def breakover_torque(self, amplitude: float, scale: float) -> float:
        """Torque (N m) at the end of a stroke of this half-amplitude (rad)."""
        return scale * float(np.interp(amplitude / scale, self._twist, self._torque))

    def reach(self, amplitude: float, scale: float) -> float:
        """Measured depth (m) down to which rocking of this half-amplitude (rad) turns the string."""
        return float(np.interp(amplitude / scale, self._twist, self._depth))

    def compliance_at(self, depth: float) -> float:
        """Torsional compliance (rad/(N m)) of the string above this measured depth (m)."""
        return float(np.interp(depth, self._depth, self._compliance))

    def zones(self, amplitude: float, reactive_torque: float, scale: float) -> Zones:
        """The three zones at this half-amplitude (rad) and reactive torque (N m)."""
        breakover_torque = self.breakover_torque(amplitude, scale) / scale
        return zones_in_closed_form(np.diff(self._depth), np.diff(self._torque), breakover_torque,
                                    max(reactive_torque, 0.0) / scale)

    def rotation_along(
        self, depth: Array, amplitude: float, reactive_torque: float, scale: float
    ) -> tuple[Array, Array]:
        """Rotation of the string along the hole.

        Args:
            depth: Measured depths (n,), m.
            amplitude: Half-amplitude of rocking at the top drive, rad.
            reactive_torque: Of the motor, N m.
            scale: Friction over the friction factor.

        Returns:
            Half-amplitude of rocking (n,), rad, and how far the mean of rocking lags behind that of the top drive
            because of the reactive torque (n,), rad.
        """
        reach = self.reach(amplitude, scale)
        torque, compliance = self._torque_at(depth), np.interp(depth, self._depth, self._compliance)
        twist_above = torque * compliance - np.interp(depth, self._depth, self._twist)   # int Q dC from the top
        breakover_torque = self._torque_at(reach)
        swing = np.maximum(amplitude / scale - (breakover_torque * compliance - twist_above), 0.0)
        torque_left = np.maximum(max(reactive_torque, 0.0) / scale - (self._torque[-1] - self._torque), 0.0)
        steps = 0.5 * (torque_left[1:] + torque_left[:-1]) * np.diff(self._compliance)
        lag = np.interp(depth, self._depth, np.concatenate([[0.0], np.cumsum(steps)]))
        return scale * np.where(depth <= reach, swing, 0.0), scale * lag

    def _torque_at(self, depth: Array | float) -> Array:
        return np.asarray(np.interp(depth, self._depth, self._torque), dtype=np.float64)

    def scale_from(self, amplitude: float, breakover_torque: float) -> float:
        """Friction scale from a stroke, by bisection.

        Args:
            amplitude: Half-amplitude of the stroke, rad.
            breakover_torque: Torque at its end, N m.

        Returns:
            Friction over the friction factor, within 0.1 to 10.
        """
        low, high = _MIN_SCALE, _MAX_SCALE
        for _ in range(_BISECTIONS):
            middle = math.sqrt(low * high)
            if self.breakover_torque(amplitude, middle) < breakover_torque:
                low = middle
            else:
                high = middle
        return math.sqrt(low * high)
