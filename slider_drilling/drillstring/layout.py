"""What the compiled step reads and writes: flat arrays, many runs ("lanes") side by side.

Per-element arrays have (n + 2) rows of ``lanes`` values, runs innermost: element i of lane k is at
``(i + 1) * lanes + k``. Row 0 is the top drive and the block, row n + 1 a ghost below the bit. Neighbours along the
string are ``lanes`` apart, so one loop is vectorised across elements for one run and across runs for many.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Elements(NamedTuple):
    """Constants of the elements, each ((n + 2) * lanes,)."""

    axial_spring: Array  # N/m, to the element above; zero in the ghost row
    torsional_spring: Array  # N m/rad, likewise
    axial_push: Array  # s/kg, time step per mass, damping included
    torsional_push: Array  # s/(kg m2)
    axial_decay: Array  # -, speed left after a step's damping
    torsional_decay: Array
    axial_force: Array  # N, buoyed weight along the hole and what a user adds
    side_weight: Array  # N, buoyed weight across the hole
    vertical_bend: Array  # rad, change of inclination over the element
    lateral_bend: Array  # rad, sin(inclination) times change of azimuth
    extra_bend: Array  # rad, of tortuosity
    buckling: Array  # 1/N, side force per squared compression
    radius: Array  # m
    friction_factor: Array  # -, multiplies the contact model's friction
    grip: Array  # 1/m, contact stiffness per normal force


class Curve(NamedTuple):
    """The contact's friction over q = cos^2(beta_v), the same for all lanes."""

    polynomial: Array  # (7,), mu = sum polynomial[k] q^k; empty where the table is needed
    table: Array  # (size,), mu at q = k / (size - 1)
    axial: float  # component of the asperity axis e3 along the hole
    tangential: float
    exponent: float  # Dahl's i


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
    torque_gain: Array  # -, of the torque sensor's lag effect
    torque_bias: Array  # N m
    backlash: Array  # rad, half the dead zone
    heave_amplitude: Array  # m
    heave_frequency: Array  # rad/s
    heave_phase: Array  # rad
    tool_force: Array  # N
    tool_frequency: Array  # rad/s
    tool_row: Array  # row of the element that carries the tool
    stribeck_drop: Array  # -
    stribeck_speed: Array  # m/s
    aging_growth: Array  # -
    aging_time: Array  # s
    rest_speed: Array  # m/s
    slip_distance: Array  # m
    drift_rate: Array  # 1/s


class State(NamedTuple):
    """All that changes: per element ((n + 2) * lanes,), per run (lanes,)."""

    position: Array  # m, along the hole, from the unstretched string
    speed: Array  # m/s
    rotation: Array  # rad
    rotation_speed: Array  # rad/s
    strain_axial: Array  # m, deformation of the contact's asperity
    strain_tangential: Array  # m
    friction: Array  # -, mu times all factors, at the last step
    factor: Array  # -, friction factor with the effects that vary in time
    rest: Array  # s, for which the contact has rested
    bottom: Array  # m, the hole's bottom on the scale of position
    depth_offset: Array  # m, measured depth minus position of the bit
    weight_on_bit: Array  # N
    bit_torque: Array  # N m
    motor_pressure: Array  # Pa
    stalled: Array  # 1 while the motor is stalled, else 0
    standpipe: Array  # Pa
    sensed_torque: Array  # N m
    pulses: Array  # (delay steps * lanes,) Pa, motor pressures on their way up
    clock: Array  # (2,): time s, steps taken


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
