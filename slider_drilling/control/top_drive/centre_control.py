"""Centre of rocking: feed-forward of the reactive twist, a lead for the toolface error, and a slow trim.

The centre is ``target - b + lead(error) + trim + S T``, with b the toolface offset and S T the twist that the reactive
torque needs.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.control.top_drive.amplitude_control import HOLDING_ERROR
from slider_drilling.control.top_drive.centre_lead import ToolFaceResponse, centre_lead

if TYPE_CHECKING:
    from slider_drilling.control.block.block_control import BlockControl
    from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
    from slider_drilling.control.estimation.tool_face_estimator import ToolFaceEstimator
    from slider_drilling.control.top_drive.amplitude_control import AmplitudeControl
    from slider_drilling.rig import Rig

_FILTER_PERIODS = 1.0   # rocking periods, time constant of the centre
_MAX_TRIM = 1.0         # rad


class CentreControl:
    """Moves the centre of rocking.

    Args:
        rig: Rig with its worn motor.
        settings: Settings of the slide.

    Attributes:
        settings: Settings in use.
        centre: rad.
    """

    def __init__(self, rig: Rig, settings: SlideSettings):
        self._rig = rig
        self.settings = settings
        self.centre = 0.0
        self._base = 0.0   # rad, the centre without the reactive twist
        self._trim = 0.0   # rad

    def start(self, angle: float) -> None:
        """Start from the angle of the top drive (rad)."""
        self.centre = self._base = angle

    def update(
        self, target: float, estimator: ToolFaceEstimator, amplitude: AmplitudeControl, block: BlockControl,
        pressure: DifferentialPressure, may_lower: bool, step: float,
    ) -> None:  # fmt: skip
        """Move the centre for one sample: the reactive twist immediately, the rest within a period of rocking.

        Args:
            target: Toolface target on the turn nearest to the toolface, rad.
            estimator: Toolface and string.
            amplitude: Amplitude and period of rocking.
            block: Block control.
            pressure: Across the motor.
            may_lower: Whether the interlocks permit lowering.
            step: Time since the last sample, s.
        """
        base = self._base
        if estimator.known:
            error = target - estimator.tool_face
            self._update_trim(error, may_lower, step)
            lead = 0.0
            # A string that slides fast turns freely, and averages over a cycle say little of it.
            if not block.return_to_bottom.fast:
                lead = self.lead(error, estimator, amplitude)
            base = target - estimator.offset + lead + self._trim
        weight = 1.0 - math.exp(-step / (_FILTER_PERIODS * amplitude.period))
        self._base += weight * (base - self._base)
        string = estimator.filter
        twist = string.compliance * string.motor_gain * self._expected_torque(block, pressure)
        self.centre = self._base + self.settings.feed_forward * twist

    def lead(self, error: float, estimator: ToolFaceEstimator, amplitude: AmplitudeControl) -> float:
        """Lead of the centre (rad) for a toolface error (rad); twice as much where the bit is stuck."""
        settings, mwd = self.settings, self._rig.sensors.mwd
        response = ToolFaceResponse(
            estimator.filter.estimate.response_time, amplitude.period, mwd.period + mwd.latency, estimator.sigma,
            amplitude.amplitude_for(1.0))  # fmt: skip
        return centre_lead(error, (1.0 + amplitude.adaptation.gain_boost) * settings.gain, settings.max_lead, response)

    def _update_trim(self, error: float, may_lower: bool, step: float) -> None:
        """Integrate a small error: friction can hold a toolface near its target against the lead."""
        if abs(error) < HOLDING_ERROR and may_lower:
            self._trim += self.settings.trim_rate * error * step
            self._trim = min(max(self._trim, -_MAX_TRIM), _MAX_TRIM)

    def _expected_torque(self, block: BlockControl, pressure: DifferentialPressure) -> float:
        """Reactive torque to compensate, N m: the measured one, or halfway to that of a higher pressure setpoint."""
        if block.return_to_bottom.under_way:
            # The reactive torque vanishes with the bit's contact, before pressure shows it.
            return 0.0
        measured = pressure.reactive_torque
        setpoint = self._rig.motor.torque_per_pressure * block.auto_driller.setpoint
        return max(measured, 0.5 * (measured + setpoint))
