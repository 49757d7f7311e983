"""Feeds the load check from the state of the slide, and reports it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slider_drilling.control.block.block_control import BlockControl
from slider_drilling.control.estimation.cycle_average import CycleAverage
from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
from slider_drilling.control.estimation.load_evidence import LoadEvidence, LoadSample
from slider_drilling.control.estimation.slide_state import SlideState
from slider_drilling.control.estimation.torque_jump import TorqueJump
from slider_drilling.control.interface import Level, Status
from slider_drilling.control.interlocks.load_check import LoadCheck, LoadConditions, LoadFault, LoadTrip
from slider_drilling.control.slide_settings import SlideSettings

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

_RATE_TIME = 40.0         # s, average of the rate at which the toolface turns
_AFTER_BOTTOM = 60.0      # s after the bit is back on bottom before channels are compared
_BELIEVED_TIME = 30.0     # s
_SLOWED_SHARE = 0.95      # of the target pressure; where drag leaves less, lowering is slower for it
_DRAG_CHANGE = (0.3, 12e3)   # that is reported: share of the drag of a string that does not rotate, and N besides
CHANNEL_FAULTS = (LoadFault.TORQUE, LoadFault.HOOK_LOAD)


class LoadSupervision:
    """Load check of a slide.

    Args:
        rig: Rig with its worn motor.
        settings: Settings of the slide.
        block: Block control.
        pressure: Across the motor.

    Attributes:
        check: The load check.
    """

    def __init__(self, rig: Rig, settings: SlideSettings, block: BlockControl, pressure: DifferentialPressure):
        self._rig = rig
        driller = block.auto_driller
        self._drill_off_time = driller.weight_per_pressure / driller.speed_per_pressure / rig.string.axial_stiffness
        self._believed = 0.0   # Pa, average before a sudden change
        self._pressure = pressure
        self.check = self._make_check(block)
        self._off_bottom_pressure = settings.off_bottom_pressure
        self._tool_face = math.nan   # rad, at the last cycle
        self._rate = 0.0             # rad/s of the toolface
        self._last_cycle = math.nan  # s
        self._on_bottom_for = 0.0    # s
        self._offset = 0.0           # N m of mean torque that is none of the motor's; stays once that is learnt
        self._reference_drag = math.nan              # N
        self._torque_jump = TorqueJump()
        self._drag_change, self._tolerated_drag = 0.0, math.inf   # N, since the reference
        self._first_twist = math.nan # rad, top drive less toolface at the first cycle
        self._unloaded_torque = 0.0  # N m, mean of a cycle of the breakover test

    def _make_check(self, block: BlockControl) -> LoadCheck:
        evidence = LoadEvidence(self._rig.bit.lever, self._rig.string.axial_stiffness)
        torque = self._rig.motor.torque_per_pressure * block.target_pressure
        return LoadCheck(evidence, block.target_weight_on_bit, torque, block.weight_limit)

    def configure(self, settings: SlideSettings, block: BlockControl) -> None:
        """Use other settings; another off-bottom pressure starts the check anew and so releases it."""
        if settings.off_bottom_pressure != self._off_bottom_pressure:
            self._off_bottom_pressure = settings.off_bottom_pressure
            self._reference_drag = math.nan
            self.check = self._make_check(block)
            return
        check = self.check
        check.target_weight = block.target_weight_on_bit
        check.target_torque = self._rig.motor.torque_per_pressure * block.target_pressure
        check.limit = block.weight_limit

    @property
    def stops(self) -> bool:
        """Whether the block must not be lowered."""
        return self.check.stops or self._pressure.tare_too_low

    def take_unloaded(self, cycle: CycleAverage) -> None:
        """Take a cycle of the breakover test: its mean torque is that of sensor, friction by direction, and twist."""
        self._unloaded_torque = cycle.torque

    def torque_jump(self, cycle: CycleAverage, compliance: float, off_bottom: bool) -> float:
        """Return the jump (N m) of the torque sensor that a cycle shows, 0 for none; it stops lowering.

        Args:
            cycle: That has just ended.
            compliance: Of the string, rad/(N m).
            off_bottom: Whether the bit is on its way back to bottom, where the string turns freely.
        """
        jump = self._torque_jump
        if off_bottom:
            jump.forget()
            return 0.0
        jump.update(cycle, compliance, self.check.target_torque)
        if jump.size and self.check.trip is None:
            figures = f"its mean jumped by {jump.size / 1e3:+.1f} kN m, which neither top drive nor motor show"
            self.check.trip = LoadTrip(LoadFault.TORQUE, figures)
        return jump.size

    def _torque_offset(self, estimated: float, sigma: float) -> float:
        """Mean torque (N m) that is none of the motor's: sensor bias, and friction larger to one side.

        The filter distinguishes it from twist that was left in the string, but not from a loss of pressure. So the
        offset is limited to the torque of the unloaded string plus the filter's initial standard deviation.

        Args:
            estimated: By the filter of toolface and string, N m.
            sigma: Standard deviation that the filter began with, N m.
        """
        return min(estimated, max(self._unloaded_torque, 0.0) + sigma)

    def update(
        self, state: SlideState, block: BlockControl, cycle: CycleAverage | None, error: float, lead: float,
    ) -> None:  # fmt: skip
        """Take one sample of a slide after the breakover test.

        Args:
            state: Channels, pressure and toolface.
            block: Block control.
            cycle: The rocking cycle that has just ended, or None.
            error: Target minus toolface, rad.
            lead: Of the centre of rocking, rad.
        """
        check, step = self.check, state.monitor.step
        if block.return_to_bottom.under_way:
            self._on_bottom_for = 0.0
            check.forget_averages()
            return
        self._on_bottom_for += step
        weight = block.auto_driller.weight_per_pressure * state.pressure.quick
        deficit = block.drag.deficit(state.monitor.fresh("hook_load"))
        check.update_sample(weight, deficit, block.drag.smooth_deficit, step)
        self._assume_pressure(state.pressure, step)
        if cycle is not None:
            self._take_cycle(state, block, cycle, error, lead)

    def _assume_pressure(self, pressure: DifferentialPressure, step: float) -> None:
        """While the pressure cannot be believed, steer by the one before, which the bit drills off."""
        check = self.check
        believed = not check.holds and (check.trip is None or check.trip.fault in CHANNEL_FAULTS)
        if believed:
            weight = 1.0 - math.exp(-step / _BELIEVED_TIME)
            self._believed += weight * (pressure.smooth - self._believed)
            pressure.assumed = None
            return
        before = self._believed if pressure.assumed is None else pressure.assumed
        pressure.assumed = before * math.exp(-step / self._drill_off_time)

    def _take_cycle(
        self, state: SlideState, block: BlockControl, cycle: CycleAverage, error: float, lead: float
    ) -> None:
        time, string = state.monitor.time, state.tool_face.filter
        elapsed = time - self._last_cycle
        self._last_cycle = time
        tool_face, self._tool_face = self._tool_face, state.tool_face.tool_face
        if not (0.0 < elapsed < 10.0 * cycle.duration and math.isfinite(tool_face)):
            return
        rate = (self._tool_face - tool_face) / elapsed
        self._rate += (1.0 - math.exp(-elapsed / _RATE_TIME)) * (rate - self._rate)
        conditions = LoadConditions(
            loaded=block.loaded(state.pressure.smooth),
            checked=state.tool_face.known and self._on_bottom_for >= _AFTER_BOTTOM,
            error=error, lead_torque=lead / string.compliance,
            turning_torque=string.estimate.response_time * self._rate / string.compliance,
            full_drag=block.drag.full_drag, held=state.tool_face.follow.held,
            slowed=block.drag_limit_share < _SLOWED_SHARE)
        if not self.check.evidence.learning:
            self._offset = self._torque_offset(string.estimate.bias, string.bias_sigma)
        self.check.update_cycle(
            LoadSample(time, elapsed, cycle.torque - self._offset, cycle.reactive_torque, block.drag.smooth_deficit,
                       state.monitor.value["block_position"], self._twist_torque(cycle, string.compliance)), conditions)
        self._watch_drag(block.drag.full_drag)

    def _twist_torque(self, cycle: CycleAverage, compliance: float) -> float:
        """Torque (N m) by which the string is twisted more than at the first cycle; compliance: rad/(N m)."""
        twist = cycle.angle - self._tool_face
        if math.isnan(self._first_twist):
            self._first_twist = twist
        return (twist - self._first_twist) / compliance

    def _watch_drag(self, full_drag: float) -> None:
        """Compare the learnt drag with that at the end of the reference period."""
        evidence = self.check.evidence
        if evidence.known and math.isnan(self._reference_drag):
            self._reference_drag = evidence.drag
        self._tolerated_drag = _DRAG_CHANGE[0] * full_drag + _DRAG_CHANGE[1]
        self._drag_change = 0.0 if math.isnan(self._reference_drag) else evidence.drag - self._reference_drag

    def statuses(self) -> tuple[Status, Status, Status]:
        """Weight on bit against its limit, the off-bottom pressure over time, and the channels of the load."""
        return self._weight_status(), self._pressure_status(), self._channel_status()

    def _weight_status(self) -> Status:
        check = self.check
        values = (("by_hook_load_n", f"{check.weight:.0f}"), ("limit_n", f"{check.limit:.0f}"),
                  ("drag_n", f"{check.evidence.drag:.0f}"))
        if check.over_limit:
            return Status(Level.ERROR, "weight_on_bit", "weight on bit by hook load or torque is at its limit of "
                          f"{check.limit / 1e3:.0f} kN: lowering stopped", values)
        return Status(Level.OK, "weight_on_bit", "within its limit by hook load and torque", values)

    def _pressure_status(self) -> Status:
        check, evidence = self.check, self.check.evidence
        change = evidence.pressure_change / self._rig.motor.torque_per_pressure / 1e5
        values = (("change_bar", f"{change:+.1f}"), ("torque_over_pressure", f"{evidence.scale:.2f}"))
        if check.trip is not None and check.trip.fault not in CHANNEL_FAULTS:
            return Status(Level.ERROR, "off_bottom_pressure", _latched(check.trip), values)
        if self._pressure.tare_too_low:
            low = -100.0 * self._pressure.tare_error
            return Status(Level.ERROR, "off_bottom_pressure", f"off bottom {low:.0f} % below the rig file's: lowering "
                          "stays stopped; check pump, leak and transmitter, or give the setting off_bottom_pressure",
                          values)
        if check.holds:
            return Status(Level.WARN, "off_bottom_pressure", "pressure changed at once and the hook load did not "
                          "follow: lowering waits to see if it stays", values)
        return Status(Level.OK, "off_bottom_pressure", f"{change:+.1f} bar since the reference, by torque", values)

    def _channel_status(self) -> Status:
        check = self.check
        values = (("difference_n_m", f"{check.evidence.difference:.0f}"), ("tolerance_n_m", f"{check.tolerance:.0f}"))
        if check.trip is not None and check.trip.fault in CHANNEL_FAULTS:
            return Status(Level.ERROR, "load_channels", _latched(check.trip), values)
        if abs(self._drag_change) > self._tolerated_drag:
            return Status(Level.WARN, "load_channels", f"drag by hook load has changed by "
                          f"{self._drag_change / 1e3:+.0f} kN since the reference: other friction along the hole, or a "
                          "hook-load sensor that drifts", values)
        known = "agree" if check.evidence.known else "are being compared for the first time"
        return Status(Level.OK, "load_channels", f"pressure, torque and hook load {known}", values)


def _latched(trip: LoadTrip) -> str:
    return (f"latched: {trip.fault.value} ({trip.message}): lowering stays stopped; a new off_bottom_pressure or a "
            "reset releases it")
