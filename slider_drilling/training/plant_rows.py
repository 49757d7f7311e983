"""One rig's rows of arrays that hold many rigs, as the compiled steps of the plants take them."""

from __future__ import annotations

from typing import Any

from slider_drilling.blind.foreign.constants import ElementConstants, RunConstants
from slider_drilling.drillstring.kernel_arrays import Elements, FrictionCurve, KernelState, Lanes
from slider_drilling.process.jit_cache import INLINED_JIT_OPTIONS, njit

EXACT: dict[str, Any] = {**INLINED_JIT_OPTIONS, "fastmath": False}
"""For compiled code that must round as Python does."""


@njit(**EXACT)
def copy_values(source, target):
    """Copy as many values as the target has; an assignment of arrays would allocate."""
    for index in range(len(target)):
        target[index] = source[index]


@njit(**EXACT)
def elements_of(e, k):
    """`Elements` of rig k from arrays (rigs, elements)."""
    return Elements(
        e.axial_spring[k], e.torsional_spring[k], e.axial_push[k], e.torsional_push[k], e.axial_decay[k],
        e.torsional_decay[k], e.axial_force[k], e.side_weight[k], e.vertical_bend[k], e.lateral_bend[k],
        e.extra_bend[k], e.buckling[k], e.radius[k], e.per_sliding_length[k], e.stribeck_drop[k],
        e.per_stribeck_speed[k], e.aging_growth[k], e.per_aging_time[k], e.rest_speed[k],
        e.per_slip_distance[k], e.drift_rate[k], e.turning_difference[k], e.elastic_share[k],
        e.vector_share[k],
    )  # fmt: skip


@njit(**EXACT)
def lanes_of(c, k):
    """`Lanes` of rig k from arrays (rigs, 1)."""
    return Lanes(
        c.cutting_stiffness[k], c.formation_factor[k], c.formation_time[k], c.bit_lever[k],
        c.torque_per_pressure[k], c.motor_displacement[k], c.leak[k], c.stall_pressure[k],
        c.pump_displacement[k], c.circulating_pressure[k], c.reference_flow[k], c.pressure_gain[k],
        c.torque_scale[k], c.torque_gain[k], c.torque_bias[k], c.motor_inertia[k], c.motor_friction[k],
        c.backlash[k], c.heave_amplitude[k], c.heave_frequency[k], c.heave_phase[k], c.tool_force[k],
        c.tool_frequency[k], c.tool_row[k], c.observer_gain[k], c.observer_leak[k], c.observer_response[k],
    )  # fmt: skip


@njit(**EXACT)
def curve_of(c, k):
    """`FrictionCurve` of rig k from a tuple of coefficients (rigs, 8), tables (rigs, size) and numbers (rigs, 5).

    The last of the numbers is how many coefficients count: 8, or 0 where the table is needed.
    """
    coefficients, tables, numbers = c
    return FrictionCurve(
        coefficients[k, : int(numbers[k, 4])], tables[k], numbers[k, 0], numbers[k, 1], numbers[k, 2], numbers[k, 3]
    )


@njit(**EXACT)
def state_of(s, i, pulses):
    """`KernelState` of slot i from arrays (slots, elements or 1); pulses: how many pressure pulses are on their way."""
    return KernelState(
        s.position[i], s.stretch[i], s.speed[i], s.rotation[i], s.twist[i], s.rotation_speed[i],
        s.strain_axial[i], s.strain_tangential[i], s.per_sliding_length[i], s.rest_time[i], s.hole_bottom[i],
        s.depth_offset[i], s.tool_face_offset[i], s.weight_on_bit[i], s.bit_torque[i], s.motor_pressure[i],
        s.stalled[i], s.circulating_pressure[i], s.standpipe_pressure[i], s.sensed_torque[i],
        s.observer_angle[i], s.observer_error[i], s.pressure_pulses[i, :pulses], s.clock[i],
    )  # fmt: skip


@njit(**EXACT)
def foreign_elements_of(e, k):
    """`ElementConstants` of foreign rig k from arrays (rigs, elements)."""
    return ElementConstants(
        e.mass[k], e.inertia[k], e.axial_spring[k], e.torsional_spring[k], e.axial_load[k], e.side_weight[k],
        e.vertical_turn[k], e.lateral_turn[k], e.extra_turn[k], e.buckling[k], e.beam_force[k], e.radius[k],
        e.friction_factor[k], e.viscous_drag[k],
    )  # fmt: skip


@njit(**EXACT)
def foreign_run_of(c, k):
    """`RunConstants` of foreign rig k from an array (rigs, constants)."""
    r = c[k]
    return RunConstants(
        r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8], r[9], r[10], r[11], r[12], r[13], r[14], r[15],
        r[16], r[17], r[18], r[19], r[20], r[21], r[22], r[23], r[24], r[25], r[26], r[27], r[28], r[29], r[30],
        r[31], r[32], r[33], r[34], r[35], r[36], r[37], r[38], r[39], r[40], r[41], r[42], r[43], r[44], r[45],
        r[46], r[47],
    )  # fmt: skip
