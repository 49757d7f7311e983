"""The state in which a run begins: a string that hangs at rest, or one that is loaded already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring.depth_profile import contact_stiffness, inverse_friction
from slider_drilling.drillstring.kernel_arrays import (
    Array,
    Elements,
    FrictionCurve,
    KernelState,
    Lanes,
    aligned,
    padded,
)
from slider_drilling.rig import FLOW_EXPONENT, Rig
from slider_drilling.wellbore.mesh import Mesh

_TURNS_AS_A_WHOLE = 0.8  # of the friction torque of the whole string, which is known no better
# Causes of side force, in the order in which `contact_stiffness` takes them.
_SIDE_FORCE_FIELDS = ("side_weight", "vertical_bend", "lateral_bend", "extra_bend", "buckling")


@dataclass(frozen=True)
class InitialState:
    """The state in which a run begins: by default a string at rest without friction, the bit just on bottom.

    Attributes:
        twist: rad, of the bit ahead of the top drive; one constant torque spreads it over the string.
        tool_face_offset: rad, added to the toolface, whose zero (the motor's bend) need not be the top drive's.
        weight_on_bit: N; the string holds its bit torque.
        axial_friction_share: Fraction (-1 to 1) of the friction along the hole that acts; positive where the string
            was lowered last.
        tangential_friction_share: Fraction (-1 to 1) of the friction around the string that acts below what the top
            drive turns; positive where friction holds more than the bit's torque.
        surface_torque: N m at the top drive, which friction takes up from there down; None for the torque below.
    """

    twist: float = 0.0
    tool_face_offset: float = 0.0
    weight_on_bit: float = 0.0
    axial_friction_share: float = 0.0
    tangential_friction_share: float = 0.0
    surface_torque: float | None = None

    @property
    def loaded(self) -> bool:
        """Whether anything acts on the string but its weight and a constant torque."""
        return (
            self.weight_on_bit != 0.0
            or self.axial_friction_share != 0.0
            or self.tangential_friction_share != 0.0
            or self.surface_torque is not None
        )


@dataclass(frozen=True)
class _Forces:
    """Loads along strings that were loaded before, each (n, lanes), surface first.

    Attributes:
        tension, torque: Of the springs above the elements, N and N m.
        axial, tangential: Strains of the contacts that go with them, m.
        turning: Rotation speed of the elements over that of the top drive.
    """

    tension: Array
    torque: Array
    axial: Array
    tangential: Array
    turning: Array


def initial_kernel_state(
    rigs: Sequence[Rig], mesh: Mesh, e: Elements, c: Lanes, curve: FrictionCurve, dt: float, drive: Array,
    starts: Sequence[InitialState], block_offset: Array | float = 0.0,
) -> KernelState:  # fmt: skip
    """The kernel's arrays for the initial state of each run.

    Args:
        drive: (5,) top-drive angle rad and speed rad/s, block position m and speed m/s, pump speed rad/s.
        block_offset: (lanes,) m that the blocks are lower than in ``drive``.
    """
    count, width = mesh.count, len(rigs)
    weight, spring, torsional_spring = (
        array[: count * width].reshape(count, width) for array in (e.axial_force, e.axial_spring, e.torsional_spring)
    )
    on_bit = np.array([start.weight_on_bit for start in starts])
    bit_torque = np.minimum(c.bit_lever * on_bit, c.torque_per_pressure * c.stall_pressure)
    motor = bit_torque / c.torque_per_pressure
    carried = np.cumsum(weight[::-1], axis=0)[::-1]
    compliance = np.cumsum(1.0 / torsional_spring, axis=0)
    twists = compliance / compliance[-1] * np.array([start.twist for start in starts])
    strain_axial, strain_tangential, turning = (aligned(np.zeros_like(e.radius)) for _ in range(3))
    if any(start.loaded for start in starts):
        torque_at_bit = bit_torque - np.array([s.twist for s in starts]) / compliance[-1]
        forces = _loaded_forces(starts, torque_at_bit, weight, e, curve)
        carried, twists = forces.tension, -np.cumsum(forces.torque / torsional_spring, axis=0)
        strain_axial[: count * width] = forces.axial.ravel()
        strain_tangential[: count * width] = forces.tangential.ravel()
        turning[: count * width] = drive[1] * np.where(drive[1] * forces.tangential > 0.0, forces.turning, 0.0).ravel()
    position = np.zeros((count + 2, width))
    # The string hangs from the heaving block: a jump there would ring through the whole run.
    position[0] = drive[2] + block_offset + c.heave_amplitude * np.sin(c.heave_phase)
    position[1:-1] = position[0] + np.cumsum(carried / spring, axis=0)
    rotation = np.full((count + 2, width), drive[0])
    rotation[1:-1] += twists
    torque = c.torque_scale * torsional_spring[0] * (rotation[0] - rotation[1])
    flow = np.maximum(drive[4] * c.pump_displacement, 0.0) / c.reference_flow
    circulation = c.circulating_pressure * flow**FLOW_EXPONENT
    delay = round(rigs[0].string.length / rigs[0].mud.sound_speed / dt)
    zero, lane = (lambda: aligned(np.zeros_like(e.radius))), (lambda: np.zeros(width))
    return KernelState(
        position=padded(position, count, 1), stretch=aligned(np.zeros_like(e.axial_spring)), speed=zero(),
        rotation=padded(rotation, count, 1), twist=aligned(np.zeros_like(e.axial_spring)), rotation_speed=turning,
        strain_axial=strain_axial, strain_tangential=strain_tangential,
        per_sliding_length=aligned(e.per_sliding_length), rest_time=zero(),
        hole_bottom=position[-2].copy(), depth_offset=rigs[0].string.length - position[-2],
        tool_face_offset=np.array([s.tool_face_offset for s in starts], dtype=float), weight_on_bit=on_bit,
        bit_torque=bit_torque, motor_pressure=motor, stalled=lane(), circulating_pressure=circulation,
        standpipe_pressure=circulation + motor, sensed_torque=torque, observer_angle=lane(), observer_error=lane(),
        pressure_pulses=np.tile(motor, delay), clock=np.zeros(2),
    )  # fmt: skip


def _loaded_forces(
    starts: Sequence[InitialState], at_bit: Array, weight: Array, e: Elements, curve: FrictionCurve
) -> _Forces:
    """Loads along strings that were loaded before.

    Args:
        at_bit: Torque at the lower end, N m, (lanes,).
        weight: Buoyed weight of the elements along the hole, N, (n, lanes).
    """
    count, width = weight.shape
    names = ("per_sliding_length", "radius", *_SIDE_FORCE_FIELDS)
    row = {name: getattr(e, name)[: count * width].reshape(count, width) for name in names}
    # Strains at which contacts slide along the hole, and around it.
    along, around = (
        1.0 / (row["per_sliding_length"] * inverse_friction(curve, part)) for part in (curve.axial, curve.tangential)
    )
    tension, axial, normal = _tension_from_bit_up(starts, weight, row, along)
    torque, tangential, turning = _torque_from_top_down(starts, at_bit, row["radius"] * normal * around)
    return _Forces(tension, torque, axial, tangential * around, turning)


def _tension_from_bit_up(
    starts: Sequence[InitialState], weight: Array, row: dict[str, Array], sliding_strain: Array
) -> tuple[Array, Array, Array]:
    """Tension N, axial strain m and contact stiffness N/m of the elements, each (n, lanes).

    Friction along the hole acts with the start's share of its limit.
    """
    count, width = weight.shape
    share = np.array([start.axial_friction_share for start in starts])
    tension, axial, normal = np.zeros((count, width)), np.zeros((count, width)), np.zeros((count, width))
    below = -np.array([start.weight_on_bit for start in starts])
    for j in range(count - 1, -1, -1):
        normal[j] = contact_stiffness(below + 0.5 * weight[j], *(row[name][j] for name in _SIDE_FORCE_FIELDS))
        axial[j] = share * sliding_strain[j]
        tension[j] = below + weight[j] - normal[j] * axial[j]
        below = tension[j]
    return tension, axial, normal


def _torque_from_top_down(
    starts: Sequence[InitialState], at_bit: Array, limit: Array
) -> tuple[Array, Array, Array]:
    """Torque N m, tangential strain over its sliding value, and rotation speed over the drive's, each (n, lanes).

    From the bit up friction holds the start's share of its limit. From the top drive down it takes up all of the
    difference between the drive's torque and that; or an even share along the string, where the difference is enough
    to turn the whole string.

    Args:
        at_bit: Torque at the lower end, N m, (lanes,).
        limit: Torque at which each element slides, N m, (n, lanes).
    """
    count, width = limit.shape
    torque, tangential = np.empty((count, width)), np.zeros((count, width))
    held = np.array([start.tangential_friction_share for start in starts]) * limit
    from_below = at_bit + np.concatenate([np.cumsum(held[::-1], axis=0)[::-1], np.zeros((1, width))])
    at_top = (start.surface_torque for start in starts)
    above = np.array([now if given is None else given for given, now in zip(at_top, from_below[0], strict=True)])
    slides = np.zeros((count, width))
    share = (above - at_bit) / np.maximum(limit.sum(axis=0), 1e-300)
    whole = np.abs(share) >= _TURNS_AS_A_WHOLE
    for j in range(count):
        torque[j] = above
        taken = np.clip(np.where(whole, share * limit[j], above - from_below[j + 1]), -limit[j], limit[j])
        tangential[j] = np.where(limit[j] > 0.0, taken / np.maximum(limit[j], 1e-300), 0.0)
        slides[j] = np.abs(taken) >= limit[j]
        above = above - taken
    # Where only friction resists, all of the pipe that slides accelerates alike: its speed falls linearly with depth.
    reach = np.maximum(slides.sum(axis=0), 1.0)
    turning = np.where(whole, 1.0, slides * (1.0 - (np.arange(count)[:, None] + 0.5) / reach))
    return torque, tangential, turning
