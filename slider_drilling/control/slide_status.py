"""What SlideController says of itself in `diagnostics`."""

from __future__ import annotations

import math

from slider_drilling.control.block.block_control import BlockControl
from slider_drilling.control.block.heave_compensation import HeaveCompensator
from slider_drilling.control.estimation.breakover_test import BreakoverTest
from slider_drilling.control.estimation.drag_monitor import DragMonitor
from slider_drilling.control.estimation.tool_face_estimator import ToolFaceEstimator
from slider_drilling.control.interface import Level, Status
from slider_drilling.control.interlocks.block_slip import BlockSlipInterlock
from slider_drilling.control.interlocks.lock_up import LockUpInterlock, LockUpState
from slider_drilling.control.top_drive.amplitude_adaptation import AmplitudeAdaptation
from slider_drilling.wellbore.zones import Zones


def of_tool_face(estimator: ToolFaceEstimator, target: float, centre: float, reactive_torque: float) -> Status:
    """target, centre: rad; reactive_torque: N m, as pressure shows it."""
    if not estimator.known:
        return Status(Level.WARN, "tool_face", "no MWD toolface has come yet: rocking about the start")
    values = (("estimate_deg", f"{math.degrees(estimator.tool_face):.1f}"),
              ("one_sigma_deg", f"{math.degrees(estimator.sigma):.1f}"),
              ("target_deg", f"{math.degrees(target):.1f}"), ("centre_rad", f"{centre:.2f}"),
              ("offset_rad", f"{estimator.offset:.2f}"),
              ("pull_rad", f"{estimator.pull:.2f}"),
              ("reactive_torque_n_m", f"{reactive_torque:.0f}"),
              ("mwd_rejected", str(estimator.rejections)))
    return Status(Level.OK, "tool_face", f"{math.degrees(estimator.tool_face - target):+.1f} deg off target", values)


def of_string(estimator: ToolFaceEstimator) -> Status:
    """What was learnt beyond the rig file, each with its one-sigma."""
    learnt = estimator.filter.estimate
    values = (("compliance_over_rig_file", f"{1.0 + learnt.compliance:.3f}"),
              ("compliance_one_sigma", f"{learnt.compliance_sigma:.3f}"),
              ("motor_torque_over_rig_file", f"{1.0 + learnt.motor:.3f}"),
              ("motor_torque_one_sigma", f"{learnt.motor_sigma:.3f}"),
              ("torque_bias_n_m", f"{learnt.bias:.0f}"), ("torque_bias_one_sigma_n_m", f"{learnt.bias_sigma:.0f}"),
              ("response_time_s", f"{learnt.response_time:.0f}"))
    than = "softer" if learnt.compliance >= 0.0 else "stiffer"
    message = (f"string {100.0 * abs(learnt.compliance):.1f} % {than} than the rig file's, motor "
               f"{100.0 * learnt.motor:+.1f} %, torque sensor {learnt.bias:+.0f} N m")
    return Status(Level.OK, "string", message, values)


def of_reach(
    zones: Zones, bit_depth: float, amplitude: float, period: float, finder: BreakoverTest,
    reach: AmplitudeAdaptation, estimator: ToolFaceEstimator, lowering: BlockControl,
) -> Status:  # fmt: skip
    """bit_depth: m; amplitude: rad; period: s."""
    drag = lowering.drag
    values = (("rocking_m", f"{zones.rocked_to:.0f}"), ("static_m", f"{zones.static_length:.0f}"),
              ("reactive_from_m", f"{zones.reactive_from:.0f}"), ("amplitude_rad", f"{amplitude:.2f}"),
              ("amplitude_over_test", f"{reach.factor:.2f}"), ("period_s", f"{period:.1f}"),
              ("friction_over_assumed", f"{finder.friction_scale:.2f}"),
              ("friction_one_sigma", f"{finder.log_sigma:.2f}"),
              ("breakover_torque_n_m", f"{finder.breakover_torque:.0f}"),
              ("swing_deg", f"{math.degrees(estimator.filter.swing):.1f}"),
              ("swing_one_sigma_deg", f"{math.degrees(estimator.filter.swing_sigma):.1f}"),
              ("drag_n", f"{drag.drag:.0f}"), ("drag_share", f"{drag.share:.2f}"),
              ("share_of_pressure_wanted", f"{lowering.asked / lowering.wanted:.2f}"),
              ("load_put_on_share", f"{lowering.following:.2f}"))
    if lowering.lock_up.stops:
        return Status(Level.ERROR, "reach", f"rocking frees the string down to {drag.held_below:.0f} m of "
                      f"{bit_depth:.0f} m only, by its drag", values)
    waits = "; the load waits until the toolface has followed" if lowering.following <= 0.0 else ""
    if reach.bit_stuck:
        return Status(Level.WARN, "reach", f"what pulls does not turn the bit: rocking reaches {zones.rocked_to:.0f} m "
                      f"of {bit_depth:.0f} m as believed{waits}", values)
    return Status(Level.OK, "reach", f"rocking reaches {zones.rocked_to:.0f} m of {bit_depth:.0f} m{waits}", values)


def of_heave(heave: HeaveCompensator) -> Status:
    """The wave that the hook load shows, and what the block does against it."""
    if math.isnan(heave.period):
        return Status(Level.OK, "heave", "no wave in the hook load")
    values = (("period_s", f"{heave.period:.1f}"), ("compensated_m", f"{heave.amplitude:.3f}"))
    if heave.fastest <= 0.0 or heave.short:
        return Status(Level.WARN, "heave", f"a wave of {heave.period:.1f} s is more than the block may follow", values)
    return Status(Level.OK, "heave", f"a wave of {heave.period:.1f} s: the block moves {heave.amplitude:.2f} m against "
                  "it", values)


def of_slip(slip: BlockSlipInterlock) -> Status:
    """The interlock: whether the block came down by itself and is being lifted back."""
    values = (("below_m", f"{slip.below:.2f}"), ("slips", str(slip.slips)))
    if slip.lifting:
        return Status(Level.ERROR, "draw_works", f"the block is {slip.below:.2f} m lower than it was told to be: "
                      "lifted back; see to the brake", values)
    return Status(Level.OK, "draw_works", "the block is where it was told to be", values)


def of_lock_up(lock: LockUpInterlock, drag: DragMonitor) -> Status:
    """The interlock: whether lowering is stopped as weight no longer arrives, where it hangs, what to do."""
    values = (("trips", str(lock.trips)), ("share_of_weight_left", f"{lock.share_left:.2f}"),
              ("drag_n", f"{drag.drag:.0f}"), ("held_below_m", f"{drag.held_below:.0f}"))
    if lock.state is LockUpState.FREE:
        return Status(Level.OK, "lock_up", lock.state.value, values)
    hangs = f"{drag.drag / 1e3:.0f} kN hang on pipe below {drag.held_below:.0f} m"
    if lock.state is LockUpState.LESS:
        return Status(Level.WARN, "lock_up", f"the string has locked up: {100.0 * lock.share_left:.0f} % of the weight "
                      f"is asked for now, {hangs}", values)
    if lock.state is LockUpState.HELD:
        return Status(Level.ERROR, "lock_up", f"weight no longer arrives: {hangs} and pressure does not rise: "
                      "lowering stopped until rocking has freed them", values)
    why = "rocking does not free it" if lock.never_freed else f"locked up {lock.trips} times, with ever less weight"
    return Status(Level.ERROR, "lock_up", f"latched: {why}; {hangs}: lowering stays stopped; pick up, ream or ask for "
                  "less pressure; another target or setting releases it", values)
