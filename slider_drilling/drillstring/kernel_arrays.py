"""What the compiled step reads and writes: flat arrays, many runs ("lanes") side by side.

Per-element arrays have n rows of ``lanes`` values, runs innermost: element i of lane k is at ``i * lanes + k``.
Neighbours along the string are ``lanes`` apart, so one loop is vectorised across elements for one run and across runs
for many. Positions and rotations have a row before them, the block and the top drive, and a ghost row behind; springs
have the ghost's, which is zero. Zeros behind the rows fill the loops up to whole vectors: no element is left to scalar
code, whose last bit may differ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slider_drilling.process.jit_cache import vector_bits

Array = NDArray[np.float64]
_VECTOR = 4 * vector_bits() // 64  # values that the widest packed loop takes at a time: four vectors of them
_LINE = 64  # bytes in a line of the processor's cache


def padded(rows: Array, elements: int, above: int = 0) -> Array:
    """Rows (n or more, lanes) as the kernel reads them: flat, with the filling behind them.

    above: rows before that of the first element.
    """
    filling = -elements * rows.shape[1] % _VECTOR
    return aligned(np.concatenate([rows.ravel(), np.zeros(filling)]), above * rows.shape[1])


def aligned(values: Array, first: int = 0) -> Array:
    """A copy whose value at `first` begins a line of the cache: a vector across two lines takes twice as long to load,
    a tenth of a step in all.
    """
    line = _LINE // values.itemsize
    room = np.empty(values.size + line, values.dtype)
    skipped = -(room.ctypes.data // room.itemsize + first) % line
    copy = room[skipped : skipped + values.size]
    copy[:] = values
    return copy


def in_single(elements: Elements, state: KernelState, lanes: int) -> tuple[Elements, KernelState]:
    """The same in single precision but for positions and rotations, whose differences would be lost in it, and what is
    a run's; more filling, for vectors hold twice as many such values.
    """
    filling = np.zeros(-elements.radius.size % (2 * _VECTOR))

    def single(values: Array) -> Array:
        return aligned(np.concatenate([values, filling]).astype(np.float32))

    moved = {name: aligned(np.concatenate([getattr(state, name), filling]), lanes) for name in ("position", "rotation")}
    narrow = {name: single(getattr(state, name)) for name in _NARROW}
    return Elements(*map(single, elements)), state._replace(**moved, **narrow)


class Elements(NamedTuple):
    """Constants of the elements, each (n * lanes + filling,), springs a row longer."""

    axial_spring: Array  # N/m, to the element above; zero in the ghost row
    torsional_spring: Array  # N m/rad, likewise
    axial_push: Array  # s/kg, time step per mass, damping included
    torsional_push: Array  # s/(kg m2)
    axial_decay: Array  # -, speed left after a step's damping
    torsional_decay: Array
    axial_force: Array  # N, buoyed weight along the hole and what a user adds
    side_weight: Array  # N/m, buoyed weight across the hole times the contact's stiffness per normal force (1/m),
    vertical_bend: Array  # 1/m, change of inclination over the element, times the same
    lateral_bend: Array  # 1/m, sin(inclination) times change of azimuth, times the same
    extra_bend: Array  # 1/m, of tortuosity, times the same
    buckling: Array  # 1/(N m), side force per squared compression, times the same
    radius: Array  # m
    yielding: Array  # 1/m, that stiffness per friction factor: 1 / z_ss where the contact model's friction is 1
    stribeck_drop: Array  # -
    per_stribeck_speed: Array  # s/m
    aging_growth: Array  # -
    per_aging_time: Array  # 1/s
    rest_speed: Array  # m/s
    per_slip_distance: Array  # 1/m
    drift_rate: Array  # 1/s


class Curve(NamedTuple):
    """The contact's friction over q = cos^2(beta_v), as 1 / mu, the same for all lanes."""

    polynomial: Array  # (8,), 1 / mu = sum polynomial[k] q^k; empty where the table is needed
    table: Array  # (size,), 1 / mu at q = k / (size - 1)
    axial: float  # component of the asperity axis e3 along the hole
    tangential: float
    exponent: float  # Dahl's i
    grip: float  # 1/m, contact stiffness per normal force


class Lanes(NamedTuple):
    """Constants of each run, each (lanes,)."""

    cutting_stiffness: Array  # N per m of depth of cut
    formation_factor: Array  # -, on the cutting stiffness from formation_time on
    formation_time: Array  # s
    bit_lever: Array  # m, bit torque per weight on bit
    torque_per_pressure: Array  # N m/Pa, of the motor as worn as it is
    motor_displacement: Array  # m3/rev
    leak: Array  # -
    stall_pressure: Array  # Pa
    pump_displacement: Array  # m3/rad
    circulating_pressure: Array  # Pa at reference_flow, with this mud
    reference_flow: Array  # m3/s
    pressure_gain: Array  # -, 1 - exp(-dt / lag)
    torque_scale: Array  # -, reading over torque
    torque_gain: Array  # -, of the torque sensor's lag effect
    torque_bias: Array  # N m
    motor_inertia: Array  # kg m2 in a torque that is read at the motor
    motor_friction: Array  # N m
    backlash: Array  # rad, half the dead zone
    heave_amplitude: Array  # m
    heave_frequency: Array  # rad/s
    heave_phase: Array  # rad
    tool_force: Array  # N
    tool_frequency: Array  # rad/s
    tool_row: Array  # index of the element that carries the tool
    pull: Array  # rad/(N m s), gain of the observer over the string's wave impedance
    pull_leak: Array  # 1/s, at which the observer forgets


class KernelState(NamedTuple):
    """All that changes: per element (n * lanes + filling,), positions two rows longer, per run (lanes,)."""

    position: Array  # m, along the hole, from the unstretched string
    stretch: Array  # m, from the element above in this step, a row longer
    speed: Array  # m/s
    rotation: Array  # rad
    twist: Array  # rad, likewise
    rotation_speed: Array  # rad/s
    strain_axial: Array  # m, deformation of the contact's asperity
    strain_tangential: Array  # m
    yielding: Array  # 1/m, as Elements.yielding, with the effects that vary in time
    rest: Array  # s, for which the contact has rested
    bottom: Array  # m, the hole's bottom on the scale of position
    depth_offset: Array  # m, measured depth minus position of the bit
    tool_face_offset: Array  # rad, toolface minus rotation of the lowest element
    weight_on_bit: Array  # N
    bit_torque: Array  # N m
    motor_pressure: Array  # Pa
    stalled: Array  # 1 while the motor is stalled, else 0
    circulation: Array  # Pa at the standpipe that the flow needs without the motor
    standpipe: Array  # Pa
    sensed_torque: Array  # N m
    pulled: Array  # rad, by which the observer has turned the drive
    pulses: Array  # (delay steps * lanes,) Pa, motor pressures on their way up
    clock: Array  # (2,): time s, steps taken


# Of the state, what the passes over elements work on besides positions and rotations.
_NARROW = ("stretch", "twist", "speed", "rotation_speed", "strain_axial", "strain_tangential", "yielding", "rest")
CHANNELS = (
    "surface_torque",
    "hook_load",
    "standpipe_pressure",
    "tool_face",
    "tool_face_rate",
    "bit_torque",
    "weight_on_bit",
    "differential_pressure",
    "bit_depth",
    "rate_of_penetration",
)
