"""The arrays that the compiled step reads and writes: many runs ("lanes") side by side in flat arrays.

Per-element arrays have n rows of ``lanes`` values: element i of lane k is at ``i * lanes + k``. Neighbours along the
string are ``lanes`` apart, so one loop is vectorised across elements for one run, and across runs for many.

Positions and rotations have one row before the elements (block and top drive) and a ghost row behind them. Springs
have the ghost row too; its stiffness is zero. Zeros at the end fill the loops up to whole vectors: left-over elements
would run as scalar code, whose last bit may differ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slider_drilling.process.jit_cache import vector_bits

Array = NDArray[np.float64]
_VECTOR = 4 * vector_bits() // 64  # doubles that the widest vectorised loop takes per pass: four vectors of them
_CACHE_LINE = 64  # bytes


def padded(rows: Array, elements: int, above: int = 0) -> Array:
    """Rows (n or more, lanes) as the kernel reads them: flat, aligned, filled up to whole vectors.

    above: Rows before that of the first element.
    """
    filling = -elements * rows.shape[1] % _VECTOR
    return aligned(np.concatenate([rows.ravel(), np.zeros(filling)]), above * rows.shape[1])


def aligned(values: Array, first: int = 0) -> Array:
    """A copy in which the value at index `first` begins a cache line.

    A vector across two lines takes twice as long to load, which would cost a tenth of a step.
    """
    line = _CACHE_LINE // values.itemsize
    room = np.empty(values.size + line, values.dtype)
    skipped = -(room.ctypes.data // room.itemsize + first) % line
    copy = room[skipped : skipped + values.size]
    copy[:] = values
    return copy


def to_single_precision(elements: Elements, state: KernelState, lanes: int) -> tuple[Elements, KernelState]:
    """Constants and state in single precision, with twice the filling, since vectors then hold twice as many values.

    Positions and rotations stay double: their differences would be lost. So do the values of whole runs.
    """
    filling = np.zeros(-elements.radius.size % (2 * _VECTOR))

    def single(values: Array) -> Array:
        return aligned(np.concatenate([values, filling]).astype(np.float32))

    double = {
        name: aligned(np.concatenate([getattr(state, name), filling]), lanes) for name in ("position", "rotation")
    }
    narrow = {name: single(getattr(state, name)) for name in _SINGLE_PRECISION_FIELDS}
    return Elements(*map(single, elements)), state._replace(**double, **narrow)


class Elements(NamedTuple):
    """Constants of the elements, each (n * lanes + filling,), springs a row longer.

    ``load stiffness`` below is the contact's stiffness per normal force, 1/m (`FrictionCurve.stiffness_per_load`): with
    it the kernel computes contact stiffnesses directly, without normal forces.
    """

    axial_spring: Array  # N/m, to the element above; zero in the ghost row
    torsional_spring: Array  # N m/rad, likewise
    axial_push: Array  # s/kg, time step per mass, damping included
    torsional_push: Array  # s/(kg m2)
    axial_decay: Array  # -, fraction of the speed left after a step's damping
    torsional_decay: Array
    axial_force: Array  # N, buoyed weight along the hole, plus Modifiers.axial_force
    side_weight: Array  # N/m, buoyed weight across the hole, times the load stiffness
    vertical_bend: Array  # 1/m, change of inclination over the element, times the load stiffness
    lateral_bend: Array  # 1/m, sin(inclination) times change of azimuth, times the load stiffness
    extra_bend: Array  # 1/m, of tortuosity, times the load stiffness
    buckling: Array  # 1/(N m), side force per squared compression, times the load stiffness
    radius: Array  # m
    per_sliding_length: Array  # 1/m, load stiffness per friction factor: 1 / z_ss where the contact's mu is 1
    stribeck_drop: Array  # -
    per_stribeck_speed: Array  # s/m
    aging_growth: Array  # -
    per_aging_time: Array  # 1/s
    rest_speed: Array  # m/s
    per_slip_distance: Array  # 1/m
    drift_rate: Array  # 1/s
    turning_difference: Array  # -, share by which friction is larger while the element turns right
    elastic_share: Array  # -, of the slip that Dahl's law has before the contact breaks away
    vector_share: Array  # -, by which a contact slips by Dahl's law for one vector


class FrictionCurve(NamedTuple):
    """The contact's friction over q = cos^2(beta_v), as 1 / mu; the same for all lanes."""

    polynomial: Array  # (8,), 1 / mu = sum polynomial[k] q^k; empty where the table is needed
    table: Array  # (size,), 1 / mu at q = k / (size - 1)
    axial: float  # component of the asperity axis e3 along the hole
    tangential: float
    exponent: float  # Dahl's i
    stiffness_per_load: float  # 1/m, contact stiffness per normal force


class Lanes(NamedTuple):
    """Constants of each run, each (lanes,)."""

    cutting_stiffness: Array  # N per m of depth of cut
    formation_factor: Array  # -, multiplies the cutting stiffness from formation_time on
    formation_time: Array  # s
    bit_lever: Array  # m, bit torque per weight on bit
    torque_per_pressure: Array  # N m/Pa, of the worn motor
    motor_displacement: Array  # m3/rev
    leak: Array  # -
    stall_pressure: Array  # Pa
    pump_displacement: Array  # m3/rad
    circulating_pressure: Array  # Pa at reference_flow, with this mud
    reference_flow: Array  # m3/s
    pressure_gain: Array  # -, 1 - exp(-dt / lag)
    torque_scale: Array  # -, reading over torque
    torque_gain: Array  # -, 1 - exp(-dt / lag) of the effect torque_sensor_lag
    torque_bias: Array  # N m
    motor_inertia: Array  # kg m2, for a torque that is read at the drive's motor
    motor_friction: Array  # N m, likewise
    backlash: Array  # rad, half the dead zone
    heave_amplitude: Array  # m
    heave_frequency: Array  # rad/s
    heave_phase: Array  # rad
    tool_force: Array  # N
    tool_frequency: Array  # rad/s
    tool_row: Array  # index of the element that carries the tool
    observer_gain: Array  # rad/(N m s), gain of the observer over the string's wave impedance
    observer_leak: Array  # 1/s, rate at which the observer forgets
    observer_response: Array  # share of the way to the torque's error that its smoothing goes in one step


class KernelState(NamedTuple):
    """All that changes: per element (n * lanes + filling,), positions two rows longer; per run (lanes,)."""

    position: Array  # m along the hole, from the unstretched string
    stretch: Array  # m, of the spring above the element in this step; a row longer
    speed: Array  # m/s
    rotation: Array  # rad
    twist: Array  # rad, of the spring above, as stretch
    rotation_speed: Array  # rad/s
    strain_axial: Array  # m, deformation of the contact's asperity
    strain_tangential: Array  # m
    per_sliding_length: Array  # 1/m, as Elements.per_sliding_length, with the effects that vary in time
    rest_time: Array  # s for which the contact has rested
    hole_bottom: Array  # m, on the scale of position
    depth_offset: Array  # m, measured depth minus position of the bit
    tool_face_offset: Array  # rad, toolface minus rotation of the lowest element
    weight_on_bit: Array  # N
    bit_torque: Array  # N m
    motor_pressure: Array  # Pa
    stalled: Array  # 1 while the motor is stalled, else 0
    circulating_pressure: Array  # Pa, that the flow needs at the standpipe with an idle motor
    standpipe_pressure: Array  # Pa
    sensed_torque: Array  # N m
    observer_angle: Array  # rad, by which the observer has turned the drive
    observer_error: Array  # N m, measured less simulated torque, smoothed
    pressure_pulses: Array  # (delay steps * lanes,) Pa, motor pressures on their way up
    clock: Array  # (2,): time s, steps taken


# Fields of the state that the passes over elements use, besides positions and rotations.
_SINGLE_PRECISION_FIELDS = (
    "stretch",
    "twist",
    "speed",
    "rotation_speed",
    "strain_axial",
    "strain_tangential",
    "per_sliding_length",
    "rest_time",
)
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
