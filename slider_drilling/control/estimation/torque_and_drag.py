"""The torque-and-drag belief: how deep rocking reaches and which torque that takes, in closed form.

Along a string that turns against friction the torque falls by ``mu w_n R`` per metre (Johancsik soft string,
`w_n` of the buoyed weight and the tension). Rocking of half-amplitude A frees the string down to the reach s_r
where, with ``Q(s) = int_0^s mu w_n R ds`` and the compliance ``C(s) = int_0^s ds / GJ``,

    A = Q(s_r) C(s_r) - int_0^s_r Q dC,        breakover torque M = Q(s_r).

Below it nothing turns. From the bit up, the reactive torque T is taken by friction over the length where
``int mu w_n R ds = T``; between the two lies the static zone. Inertia is left out on purpose: what it changes is
absorbed by `scale`, which is corrected from the breakover torque that surface sees.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from slider_drilling.wellbore.mesh import build_mesh, torsional_compliances
from slider_drilling.wellbore.static_loads import static_loads
from slider_drilling.wellbore.zones import Zones, zones_in_closed_form

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

_SPACING = 10.0  # m between the depths at which the belief is held
_SCALES = (0.1, 10.0)


class TorqueAndDrag:
    """Belief about one string in one well. weight_on_bit: N, that the tension is reckoned with.

    friction_factor: the belief of Coulomb friction where the rig file's interval factor is 1; the methods' `scale`
    multiplies it.
    """

    def __init__(self, rig: Rig, friction_factor: float, weight_on_bit: float):
        mesh = build_mesh(rig, max(round(rig.string.length / _SPACING), 2))
        loads = static_loads(rig, rotation_speed=1.0, weight_on_bit=weight_on_bit,
                             friction_coefficient=friction_factor, mesh=mesh)
        self._depth = loads.measured_depth
        self._torque = loads.torque[0] - loads.torque
        compliance = np.concatenate([[0.0], np.cumsum(torsional_compliances(rig, mesh))])
        taken = 0.5 * (self._torque[1:] + self._torque[:-1]) * np.diff(compliance)
        self._twist = self._torque * compliance - np.concatenate([[0.0], np.cumsum(taken)])
        self._compliance = compliance
        self.compliance = float(compliance[-1])
        self.bit_depth = float(self._depth[-1])
        self.travel_time = self.bit_depth / rig.string.twist_speed
        self.impedance = math.sqrt(rig.string.shear_modulus * rig.string.density) * float(mesh.polar_moment[0])

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
        rocked = self.breakover_torque(amplitude, scale) / scale
        return zones_in_closed_form(np.diff(self._depth), np.diff(self._torque), rocked,
                                    max(reactive_torque, 0.0) / scale)

    def rotation_along(
        self, depth: NDArray[np.float64], amplitude: float, reactive_torque: float, scale: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """How the string turns at these measured depths (n,) m, two arrays (n,) of rad.

        The half-amplitude that is left of rocking of this half-amplitude (rad), and by how much the pipe there stays
        behind the middle of rocking because of the reactive torque (N m).
        """
        reach = self.reach(amplitude, scale)
        torque, compliance = self._torque_at(depth), np.interp(depth, self._depth, self._compliance)
        sheared = torque * compliance - np.interp(depth, self._depth, self._twist)   # int Q dC from the top
        freed = self._torque_at(reach)
        swing = np.maximum(amplitude / scale - (freed * compliance - sheared), 0.0)
        left = np.maximum(max(reactive_torque, 0.0) / scale - (self._torque[-1] - self._torque), 0.0)
        steps = 0.5 * (left[1:] + left[:-1]) * np.diff(self._compliance)
        behind = np.interp(depth, self._depth, np.concatenate([[0.0], np.cumsum(steps)]))
        return scale * np.where(depth <= reach, swing, 0.0), scale * behind

    def _torque_at(self, depth: NDArray[np.float64] | float) -> NDArray[np.float64]:
        return np.asarray(np.interp(depth, self._depth, self._torque), dtype=np.float64)

    def scale_from(self, amplitude: float, breakover_torque: float) -> float:
        """The scale at which a stroke of this half-amplitude (rad) ends at this torque (N m), within 0.1 to 10."""
        low, high = _SCALES
        for _ in range(40):
            middle = math.sqrt(low * high)
            if self.breakover_torque(amplitude, middle) < breakover_torque:
                low = middle
            else:
                high = middle
        return math.sqrt(low * high)

