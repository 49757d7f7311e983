"""What a run starts from: a string that hangs at rest, or one that was at work already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring.depth_profile import contact_stiffness, per_friction
from slider_drilling.drillstring.kernel_arrays import Array, Curve, Elements, KernelState, Lanes, aligned, padded
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import Mesh

# Of the torque at which a whole string turns: its friction is known no better.
_WHOLE = 0.8
# What presses an element on the wall, in the order in which `contact_stiffness` takes it.
_PRESSING = ("side_weight", "vertical_bend", "lateral_bend", "extra_bend", "buckling")


@dataclass(frozen=True)
class InitialState:
    """How a run begins: by default at rest, hanging without friction, the bit just on bottom.

    twist: rad, of the bit ahead of the top drive, spread over the string as one constant torque would; offset: rad,
    added to the toolface of an untwisted string, whose bend need not point where the top drive's zero is.

    Of a string that was at work already: weight: N on the bit, whose torque the string holds; drag: share (-1 to 1) of
    the friction that acts along the hole, positive where the string was lowered last; hold: share (-1 to 1) of that
    which acts around the string below what the drive turns, positive where it holds more than the bit's torque;
    torque: N m at the top drive, which friction takes up from there down.
    """

    twist: float = 0.0
    tool_face_offset: float = 0.0
    weight_on_bit: float = 0.0
    axial_friction_share: float = 0.0
    tangential_friction_share: float = 0.0
    surface_torque: float | None = None

    @property
    def loaded(self) -> bool:
        """Whether anything but the weight of the string and a constant torque acts."""
        return (
            self.weight_on_bit != 0.0
            or self.axial_friction_share != 0.0
            or self.tangential_friction_share != 0.0
            or self.surface_torque is not None
        )


@dataclass(frozen=True)
class _Forces:
    """Of the springs (n, lanes), surface first, N and N m; strains of the contacts (n, lanes) m that go with them;
    turning: (n, lanes) how fast elements turn, of the top drive's speed.
    """

    tension: Array
    torque: Array
    axial: Array
    tangential: Array
    turning: Array


def initial_kernel_state(
    rigs: Sequence[Rig], mesh: Mesh, e: Elements, c: Lanes, curve: Curve, dt: float, drive: Array,
    starts: Sequence[InitialState], lowered: Array | float = 0.0,
) -> KernelState:  # fmt: skip
    """The state in which each run begins, see `Start`.

    drive: (5,) top-drive angle rad and speed, block position m and speed, pump speed rad/s at the start; lowered:
    (lanes,) m that the blocks are lower.
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
        forces = _at_work(starts, bit_torque - np.array([s.twist for s in starts]) / compliance[-1], weight, e, curve)
        carried, twists = forces.tension, -np.cumsum(forces.torque / torsional_spring, axis=0)
        strain_axial[: count * width] = forces.axial.ravel()
        strain_tangential[: count * width] = forces.tangential.ravel()
        turning[: count * width] = drive[1] * np.where(drive[1] * forces.tangential > 0.0, forces.turning, 0.0).ravel()
    position = np.zeros((count + 2, width))
    # The string hangs from where the heave has the block at the start: a jump there would ring through the log.
    position[0] = drive[2] + lowered + c.heave_amplitude * np.sin(c.heave_phase)
    position[1:-1] = position[0] + np.cumsum(carried / spring, axis=0)
    rotation = np.full((count + 2, width), drive[0])
    rotation[1:-1] += twists
    torque = c.torque_scale * torsional_spring[0] * (rotation[0] - rotation[1])
    flow = np.maximum(drive[4] * c.pump_displacement, 0.0) / c.reference_flow
    circulation = c.circulating_pressure * flow**1.8
    delay = round(rigs[0].string.length / rigs[0].mud.sound_speed / dt)
    zero, lane = (lambda: aligned(np.zeros_like(e.radius))), (lambda: np.zeros(width))
    return KernelState(
        position=padded(position, count, 1), stretch=aligned(np.zeros_like(e.axial_spring)), speed=zero(),
        rotation=padded(rotation, count, 1), twist=aligned(np.zeros_like(e.axial_spring)), rotation_speed=turning,
        strain_axial=strain_axial, strain_tangential=strain_tangential, yielding=aligned(e.yielding), rest=zero(),
        bottom=position[-2].copy(), depth_offset=rigs[0].string.length - position[-2],
        tool_face_offset=np.array([s.tool_face_offset for s in starts], dtype=float), weight_on_bit=on_bit,
        bit_torque=bit_torque, motor_pressure=motor, stalled=lane(), circulation=circulation,
        standpipe=circulation + motor, sensed_torque=torque, pulled=lane(),
        pulses=np.tile(motor, delay), clock=np.zeros(2),
    )  # fmt: skip


def _at_work(starts: Sequence[InitialState], at_bit: Array, weight: Array, e: Elements, curve: Curve) -> _Forces:
    """What acts along strings that were at work; at_bit: (lanes,) N m.

    From the bit up friction holds a share of what it can; from the top drive down it takes up all that the drive's
    torque differs from that by, or a share where that is about enough for the whole string, which then turns.
    """
    count, width = weight.shape
    row = {name: getattr(e, name)[: count * width].reshape(count, width) for name in ("yielding", "radius", *_PRESSING)}
    along, around = (1.0 / (row["yielding"] * per_friction(curve, part)) for part in (curve.axial, curve.tangential))
    drag = np.array([start.axial_friction_share for start in starts])
    tension, axial, normal = np.zeros((count, width)), np.zeros((count, width)), np.zeros((count, width))
    below = -np.array([start.weight_on_bit for start in starts])
    for j in range(count - 1, -1, -1):
        normal[j] = contact_stiffness(below + 0.5 * weight[j], *(row[name][j] for name in _PRESSING))
        axial[j] = drag * along[j]
        tension[j] = below + weight[j] - normal[j] * axial[j]
        below = tension[j]
    torque, tangential = np.empty((count, width)), np.zeros((count, width))
    most = row["radius"] * normal * around
    held = np.array([start.tangential_friction_share for start in starts]) * most
    deep = at_bit + np.concatenate([np.cumsum(held[::-1], axis=0)[::-1], np.zeros((1, width))])
    at_top = (start.surface_torque for start in starts)
    above = np.array([now if own is None else own for own, now in zip(at_top, deep[0], strict=True)])
    slides = np.zeros((count, width))
    share = (above - at_bit) / np.maximum(most.sum(axis=0), 1e-300)
    whole = np.abs(share) >= _WHOLE
    for j in range(count):
        torque[j] = above
        taken = np.clip(np.where(whole, share * most[j], above - deep[j + 1]), -most[j], most[j])
        tangential[j] = np.where(most[j] > 0.0, taken / np.maximum(most[j], 1e-300), 0.0) * around[j]
        slides[j] = np.abs(taken) >= most[j]
        above = above - taken
    # Where friction is all that holds back, torque rises alike along the string: its speed falls in a straight line.
    reach = np.maximum(slides.sum(axis=0), 1.0)
    turning = np.where(whole, 1.0, slides * (1.0 - (np.arange(count)[:, None] + 0.5) / reach))
    return _Forces(tension, torque, axial, tangential, turning)
