"""Closed forms of a rocked slide: load of the bit, offset, weight without rocking, buckling.

While the string slides, friction along the hole uses up the contact: pipe that does not rotate holds no torque for
long. The reactive torque M therefore reaches the top drive undiminished, and turns the string by M times its whole
compliance. That is the offset.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from slider_drilling.contact import friction_coefficient_of_direction
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import Mesh, buoyed_weight
from slider_drilling.wellbore.static_loads import static_loads
from slider_drilling.wellbore.well_path import Array

_ITERATIONS = 50
_VERTICAL_BUCKLING = 2.55  # helical, of a weighted pipe in a vertical hole (Wu and others, 1993)


@dataclass(frozen=True)
class BitLoad:
    """Load of a bit that drills steadily (`model.md` section 4).

    Attributes:
        rate_of_penetration: m/s.
        weight_on_bit: N.
        torque: That the motor's housing takes as reaction, N m.
        differential_pressure: Pa.
    """

    rate_of_penetration: float
    weight_on_bit: float
    torque: float
    differential_pressure: float


def bit_load_of_pressure(rig: Rig, pressure: float) -> BitLoad:
    """The load at a differential pressure (Pa). Raises InputError where the motor would stall."""
    if not 0.0 < pressure < rig.motor.max_pressure:
        raise InputError(
            f"differential pressure = {pressure / 1e5:.4g} bar: must be above 0 and below motor.max_pressure, "
            f"{rig.motor.max_pressure / 1e5:.4g} bar"
        )
    torque = rig.motor.torque_per_pressure * pressure
    weight = torque / rig.bit.lever
    depth_of_cut = weight / rig.bit.depth_of_cut_stiffness
    return BitLoad(depth_of_cut * _motor_speed(rig, pressure) / (2.0 * math.pi), weight, torque, pressure)


def bit_load_of_rate(rig: Rig, rate: float) -> BitLoad:
    """The load at a rate of penetration (m/s). Raises InputError where the motor would stall."""
    highest = 0.999 * rig.motor.max_pressure
    if not 0.0 < rate < bit_load_of_pressure(rig, highest).rate_of_penetration:
        raise InputError(
            f"rate of penetration = {3600.0 * rate:.4g} m/h: must be above 0 and below what stalls the motor, "
            f"{3600.0 * bit_load_of_pressure(rig, highest).rate_of_penetration:.4g} m/h"
        )
    pressure = optimize.brentq(
        lambda p: bit_load_of_pressure(rig, p).rate_of_penetration - rate, 1e-9 * highest, highest, xtol=1.0
    )
    return bit_load_of_pressure(rig, float(pressure))


def _motor_speed(rig: Rig, pressure: float) -> float:
    flow = rig.hydraulics.reference_flow
    return 2.0 * math.pi * flow / rig.motor.displacement * (1.0 - rig.motor.leak_at(pressure))


def friction_around(rig: Rig) -> float:
    """Friction coefficient of slip around the hole, where the interval's factor is 1."""
    return float(friction_coefficient_of_direction(rig.contact, math.pi / 2.0 - rig.contact.asperity.orientation))


def weight_without_rocking(rig: Rig, hook_load: float, mesh: Mesh) -> float:
    """Weight on bit (N) of a string that slides without rocking and shows this hook load (N); 0 where it hangs up.

    Raises:
        InputError: The hook load is beyond that of any weight on bit.
    """

    def excess(weight: float) -> float:
        return static_loads(rig, axial_speed=1.0, weight_on_bit=weight, mesh=mesh).hook_load - hook_load

    if excess(0.0) <= 0.0:
        return 0.0
    heaviest = float(np.sum(buoyed_weight(rig, mesh)))
    if excess(heaviest) > 0.0:
        raise InputError(f"hook load = {hook_load / 1e3:.4g} kN: below that of any weight on bit; check the rig file")
    return float(optimize.brentq(excess, 0.0, heaviest, xtol=1.0))


def critical_compression(rig: Rig, mesh: Mesh, side_force: Array) -> Array:
    """Compression (n,), N, at which each element buckles.

    Pipe that is pressed on the wall with w_n per metre buckles into a sine at 2 sqrt(E I w_n / r), r the radial
    clearance (Dawson and Paslay 1984; in curved holes He and Kyllingstad 1995). Pipe that hangs freely buckles at
    2.55 (E I w^2)^(1/3), w its buoyed weight (Wu and others 1993).

    Args:
        rig: The rig.
        mesh: Of the string.
        side_force: w_n, N/m, (n,).
    """
    bending = rig.string.youngs_modulus * mesh.second_moment
    weight = buoyed_weight(rig, mesh) / mesh.length
    lying = 2.0 * np.sqrt(bending * side_force / np.maximum(mesh.clearance, 1e-6))
    return np.asarray(np.maximum(lying, _VERTICAL_BUCKLING * np.cbrt(bending * weight**2)), dtype=np.float64)
