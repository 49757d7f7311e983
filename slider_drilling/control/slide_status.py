"""Status lines of SlideController in `diagnostics`."""

from __future__ import annotations

import math

from slider_drilling.control.block.block_control import BlockControl
from slider_drilling.control.block.heave_compensation import HeaveCompensator
from slider_drilling.control.estimation.drag_monitor import DragMonitor
from slider_drilling.control.estimation.string_kalman_filter import StringKalmanFilter
from slider_drilling.control.estimation.tool_face_estimator import ToolFaceEstimator
from slider_drilling.control.interface import Level, Status
from slider_drilling.control.interlocks.block_slip import BlockSlipInterlock
from slider_drilling.control.interlocks.lock_up import LockUpInterlock, LockUpState
from slider_drilling.control.top_drive.amplitude_control import AmplitudeControl
from slider_drilling.wellbore.zones import Zones


def tool_face_status(estimator: ToolFaceEstimator, target: float, centre: float, reactive_torque: float) -> Status:
    """Toolface, its target and the centre of rocking.

    Args:
        estimator: Toolface and string.
        target: rad.
        centre: Of rocking, rad.
        reactive_torque: From pressure, N m.
    """
    if not estimator.known:
        return Status(Level.WARN, "tool_face", "no MWD toolface yet: rocking about the start angle")
    values = (("estimate_deg", f"{math.degrees(estimator.tool_face):.1f}"),
              ("one_sigma_deg", f"{math.degrees(estimator.sigma):.1f}"),
              ("target_deg", f"{math.degrees(target):.1f}"), ("centre_rad", f"{centre:.2f}"),
              ("offset_rad", f"{estimator.offset:.2f}"),
              ("driving_twist_rad", f"{estimator.driving_twist:.2f}"),
              ("reactive_torque_n_m", f"{reactive_torque:.0f}"),
              ("mwd_rejected", str(estimator.rejections)))
    return Status(Level.OK, "tool_face", f"{math.degrees(estimator.tool_face - target):+.1f} deg off target", values)


def string_status(string: StringKalmanFilter) -> Status:
    """How string, motor and torque sensor differ from the rig file, each with one standard deviation."""
    estimate = string.estimate
    values = (("compliance_over_rig_file", f"{1.0 + estimate.compliance:.3f}"),
              ("compliance_one_sigma", f"{estimate.compliance_sigma:.3f}"),
              ("motor_torque_over_rig_file", f"{1.0 + estimate.motor:.3f}"),
              ("motor_torque_one_sigma", f"{estimate.motor_sigma:.3f}"),
              ("torque_bias_n_m", f"{estimate.bias:.0f}"),
              ("torque_bias_one_sigma_n_m", f"{estimate.bias_sigma:.0f}"),
              ("response_time_s", f"{estimate.response_time:.0f}"))
    side = "softer" if estimate.compliance >= 0.0 else "stiffer"
    # Zero added: what rounds to zero has no minus.
    motor, bias = round(100.0 * estimate.motor, 1) + 0.0, round(estimate.bias) + 0.0
    message = (f"string {100.0 * abs(estimate.compliance):.1f} % {side} than the rig file's, motor "
               f"{motor:+.1f} %, torque sensor {bias:+.0f} N m")
    return Status(Level.OK, "string", message, values)


def reach_status(zones: Zones, amplitude: AmplitudeControl, string: StringKalmanFilter, block: BlockControl) -> Status:
    """How deep rocking reaches, with drag, swing and friction; an error while lock-up stops the slide."""
    bit_depth, adaptation, test, drag = amplitude.model.bit_depth, amplitude.adaptation, amplitude.test, block.drag
    values = (("rocking_m", f"{zones.rocked_to:.0f}"), ("static_m", f"{zones.static_length:.0f}"),
              ("reactive_from_m", f"{zones.reactive_from:.0f}"), ("amplitude_rad", f"{amplitude.amplitude:.2f}"),
              ("amplitude_factor", f"{adaptation.factor:.2f}"), ("period_s", f"{amplitude.period:.1f}"),
              ("friction_over_assumed", f"{test.friction_scale:.2f}"),
              ("friction_one_sigma", f"{test.log_sigma:.2f}"),
              ("breakover_torque_n_m", f"{test.breakover_torque:.0f}"),
              ("swing_deg", f"{math.degrees(string.swing):.1f}"),
              ("swing_one_sigma_deg", f"{math.degrees(string.swing_sigma):.1f}"),
              ("drag_n", f"{drag.drag:.0f}"), ("drag_share", f"{drag.share:.2f}"),
              ("share_of_target_pressure", f"{block.allowed_pressure / block.target_pressure:.2f}"),
              ("load_share", f"{block.load_share:.2f}"))
    if block.lock_up.stops:
        return Status(Level.ERROR, "reach", f"rocking frees the string only down to {drag.held_below:.0f} m of "
                      f"{bit_depth:.0f} m, by its drag", values)
    waits = "; more weight on bit waits until the toolface is back" if block.load_share <= 0.0 else ""
    if adaptation.bit_stuck:
        return Status(Level.WARN, "reach", "the twist of the string does not turn the bit: rocking reaches "
                      f"{zones.rocked_to:.0f} m of {bit_depth:.0f} m by the model{waits}", values)
    return Status(Level.OK, "reach", f"rocking reaches {zones.rocked_to:.0f} m of {bit_depth:.0f} m{waits}", values)


def heave_status(heave: HeaveCompensator) -> Status:
    """The wave in the hook load, and the compensation by the block."""
    if math.isnan(heave.period):
        return Status(Level.OK, "heave", "no wave in the hook load")
    values = (("period_s", f"{heave.period:.1f}"), ("compensated_m", f"{heave.amplitude:.3f}"))
    if heave.max_speed <= 0.0 or heave.saturated:
        return Status(Level.WARN, "heave", f"a wave of {heave.period:.1f} s needs more than the compensation "
                      f"speed of {heave.max_speed:g} m/s", values)
    return Status(Level.OK, "heave", f"a wave of {heave.period:.1f} s: the block moves {heave.amplitude:.2f} m against "
                  "it", values)


def slip_status(slip: BlockSlipInterlock) -> Status:
    """The block-slip interlock: whether the block is being lifted back."""
    values = (("below_m", f"{slip.below:.2f}"), ("slips", str(slip.slips)))
    if slip.lifting:
        return Status(Level.ERROR, "draw_works", f"the block is {slip.below:.2f} m below its commanded position: "
                      "lifting it back; check the brake", values)
    return Status(Level.OK, "draw_works", "the block is at its commanded position", values)


def lock_up_status(lock: LockUpInterlock, drag: DragMonitor) -> Status:
    """The lock-up interlock: whether lowering is stopped, where the weight hangs, and what to do."""
    values = (("trips", str(lock.trips)), ("share_of_target_weight", f"{lock.share_left:.2f}"),
              ("drag_n", f"{drag.drag:.0f}"), ("held_below_m", f"{drag.held_below:.0f}"))
    if lock.state is LockUpState.FREE:
        return Status(Level.OK, "lock_up", lock.state.value, values)
    hanging = f"{drag.drag / 1e3:.0f} kN hang on pipe below {drag.held_below:.0f} m"
    if lock.state is LockUpState.LESS:
        return Status(Level.WARN, "lock_up", f"the string has locked up: the slide goes on with "
                      f"{100.0 * lock.share_left:.0f} % of the weight, {hanging}", values)
    if lock.state is LockUpState.HELD:
        return Status(Level.ERROR, "lock_up", f"weight no longer arrives at the bit: {hanging} and pressure does not "
                      "rise: lowering stopped until rocking has freed the string", values)
    reason = ("rocking does not free the string" if lock.never_freed
              else f"the string locked up {lock.trips} times, with less weight each time")
    return Status(Level.ERROR, "lock_up", f"latched: {reason}; {hanging}: lowering stays stopped; pick up, ream or ask "
                  "for less pressure; a new target or setting releases it", values)
