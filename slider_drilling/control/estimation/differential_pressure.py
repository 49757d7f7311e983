"""Differential pressure: standpipe pressure less what circulation alone needs at this flow."""

from __future__ import annotations

import math

from slider_drilling.rig import FLOW_EXPONENT, Rig

_MIN_TARE_FLOW = 0.8    # of the reference flow
_MAX_TARE_ERROR = 0.06  # of the rig file's off-bottom pressure; a larger difference is the bit's load
_TARE_TIME = 8.0        # s, time constant


class DifferentialPressure:
    """Pressure across the motor, and the reactive torque that it stands for.

    Without a sample both filters hold their last value.

    Args:
        rig: Rig file.
        off_bottom_pressure: Standpipe pressure at the reference flow, off bottom, Pa; 0: the rig file's, until `tare`
            has measured it.
        quick_time: Time constant of `quick`, s.
        smooth_time: Time constant of `smooth`, s.

    Attributes:
        quick: Pa, for stall detection.
        smooth: Pa, for control.
        assumed: Pa, used in place of `smooth` for the reactive torque while the pressure cannot be believed, or None.
        tare_error: How far the pressure off bottom is from the rig file's, as a share; 0 while it is tared.
    """

    def __init__(self, rig: Rig, off_bottom_pressure: float, quick_time: float, smooth_time: float):
        self.quick = self.smooth = 0.0
        self._setting = math.nan
        self._off_bottom = 0.0
        self._circulation = 0.0   # circulating pressure of the last sample over the off-bottom pressure
        self.assumed: float | None = None
        self.tare_error = 0.0
        self.configure(rig, off_bottom_pressure)
        self._reference_speed = rig.reference_pump_speed
        self._torque_per_pressure = rig.motor.torque_per_pressure
        self._times = (quick_time, smooth_time)

    def configure(self, rig: Rig, off_bottom_pressure: float) -> None:
        """Use another off-bottom pressure (Pa, 0: the rig file's) from now on; the same one keeps the tare."""
        if off_bottom_pressure == self._setting:
            return
        self._setting = off_bottom_pressure
        self._given = off_bottom_pressure > 0.0
        self.tare_error = 0.0
        self._rig_file_pressure = rig.circulating_pressure
        before, self._off_bottom = self._off_bottom, off_bottom_pressure or self._rig_file_pressure
        # The pressure across the motor is known anew at once; its filters must not show a change.
        self.quick += self._circulation * (before - self._off_bottom)
        self.smooth += self._circulation * (before - self._off_bottom)

    def tare(self, standpipe_pressure: float, pump_speed: float, step: float) -> None:
        """Take one sample off bottom, before `update`: pressure Pa, crank speed rad/s, time since the last one s.

        A string that already drills shows far more pressure than a rig file is wrong by; such samples are ignored.
        """
        flow = pump_speed / self._reference_speed
        if self._given or not (math.isfinite(standpipe_pressure) and flow >= _MIN_TARE_FLOW):
            return
        measured = standpipe_pressure / flow**FLOW_EXPONENT
        error = measured / self._rig_file_pressure - 1.0
        outside = abs(error) > _MAX_TARE_ERROR
        self.tare_error += (1.0 - math.exp(-step / _TARE_TIME)) * ((error if outside else 0.0) - self.tare_error)
        if not outside:
            self._off_bottom += (1.0 - math.exp(-step / _TARE_TIME)) * (measured - self._off_bottom)

    def circulating(self, pump_speed: float) -> float:
        """Standpipe pressure off bottom at a crank speed of the pump (rad/s), Pa."""
        return self._off_bottom * float(max(pump_speed, 0.0) / self._reference_speed) ** FLOW_EXPONENT

    def update(self, standpipe_pressure: float, pump_speed: float, step: float) -> None:
        """Take one sample: pressure Pa, crank speed of the pump rad/s, time since the last one s."""
        if not (math.isfinite(standpipe_pressure) and math.isfinite(pump_speed)):
            return
        flow = max(pump_speed, 0.0) / self._reference_speed
        self._circulation = flow**FLOW_EXPONENT
        pressure = standpipe_pressure - self._off_bottom * self._circulation
        self.quick += (1.0 - math.exp(-step / self._times[0])) * (pressure - self.quick)
        self.smooth += (1.0 - math.exp(-step / self._times[1])) * (pressure - self.smooth)

    @property
    def tare_too_low(self) -> bool:
        """Whether the pressure off bottom was below any that the rig file's circulation can have."""
        return self.tare_error < -_MAX_TARE_ERROR

    @property
    def reactive_torque(self) -> float:
        """Torque with which the motor turns its housing to the left, from `smooth` or `assumed`, N m."""
        pressure = self.smooth if self.assumed is None else self.assumed
        return self._torque_per_pressure * max(pressure, 0.0)

    @property
    def quick_reactive_torque(self) -> float:
        """The same from `quick`, for averages over a cycle, N m."""
        return self._torque_per_pressure * self.quick
