"""Amplitude and period of rocking: from the string model, the breakover test and what sliding shows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slider_drilling.control.estimation.breakover_test import SLOW_DOWN_TRAVEL_TIMES, BreakoverTest
from slider_drilling.control.estimation.rocking_phase import period_with_distinct_phases
from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.control.top_drive.amplitude_adaptation import AmplitudeAdaptation
from slider_drilling.wellbore.zones import Zones

if TYPE_CHECKING:
    from slider_drilling.control.block.return_to_bottom import ReturnToBottom
    from slider_drilling.rig import Rig

HOLDING_ERROR, SETTING_ERROR = math.radians(12.0), math.radians(45.0)   # rad: below it holds, above it sets
_PERIOD_PER_TRAVEL = 6.4     # best rocking period over the travel time of torsion from top to bit
_MIN_PERIOD = 6.0            # s
_MAX_TEST_SPEED = 6.0        # rad/s, of the breakover test
_FRICTION_PRIOR_SIGMA = 0.25   # of ln(friction scale)
_FAST_SLIDING_SHARE = 0.3    # of the holding amplitude while the string slides fast and so turns easily
_MAX_ACCELERATION_SHARE, _MAX_SPEED_SHARE = 0.9, 0.95   # of the top drive's limits; the rest is for tracking
# Amplitude at a torque limit: cut to this share of the present one, never below this share of the holding amplitude,
# recovered at this rate per s.
_TRIP_REDUCTION, _MIN_BEARABLE_SHARE, _RECOVERY_RATE = 0.98, 0.3, 0.001


class AmplitudeControl:
    """Chooses amplitude and period of rocking.

    Args:
        rig: Rig with its worn motor.
        settings: Settings of the slide.
        weight_on_bit: For the tension in the torque-and-drag model, N.

    Attributes:
        amplitude: Present amplitude, rad.
        model: Torque and drag with weight on bit.
        test: Breakover test.
        adaptation: Correction of the amplitude while sliding.
    """

    def __init__(self, rig: Rig, settings: SlideSettings, weight_on_bit: float):
        self._rig = rig
        self._settings = settings
        self.adaptation = AmplitudeAdaptation()
        self.amplitude = 0.0
        self._bearable = math.inf   # rad, amplitude that the torque limits allow
        self.model = TorqueAndDrag(rig, settings.friction_factor, weight_on_bit)
        self.test = BreakoverTest(TorqueAndDrag(rig, settings.friction_factor, 0.0), _FRICTION_PRIOR_SIGMA)

    def configure(self, settings: SlideSettings, weight_on_bit: float) -> None:
        """Use other settings; another friction factor starts the breakover test again."""
        friction_changed = settings.friction_factor != self._settings.friction_factor
        self._settings = settings
        if friction_changed:
            self.model = TorqueAndDrag(self._rig, settings.friction_factor, weight_on_bit)
            off_bottom = TorqueAndDrag(self._rig, settings.friction_factor, 0.0)
            self.test = BreakoverTest(off_bottom, _FRICTION_PRIOR_SIGMA)

    @property
    def testing(self) -> bool:
        """Whether the breakover test is running; a set amplitude skips it."""
        return self.test.running and self._settings.amplitude == 0.0

    @property
    def max_speed(self) -> float:
        """Of the top drive, rad/s."""
        return min(self._settings.max_rocking_speed, _MAX_SPEED_SHARE * self._rig.top_drive.max_speed)

    @property
    def max_acceleration(self) -> float:
        """Of the top drive, rad/s2."""
        limit = _MAX_ACCELERATION_SHARE * self._rig.top_drive.max_acceleration
        return min(self._settings.rounding_acceleration, limit)

    @property
    def slow_down_time(self) -> float:
        """Time constant with which strokes slow down towards their ends, s; 0 after the breakover test."""
        return SLOW_DOWN_TRAVEL_TIMES * self.model.travel_time if self.testing else 0.0

    @property
    def period(self) -> float:
        """Rocking period, s; longer than the best one where the drive could not make the amplitude in it."""
        period = self._settings.period
        if period <= 0.0:
            period = max(_PERIOD_PER_TRAVEL * self.model.travel_time, _MIN_PERIOD)
            period = period_with_distinct_phases(period, self._rig.sensors.mwd.period)
            if self.testing:
                period = max(period, 4.0 * self.amplitude / _MAX_TEST_SPEED)
        return max(period, 4.0 * self.amplitude / self.max_speed)

    def amplitude_for(self, share: float) -> float:
        """Amplitude (rad) for a share of the one that frees the whole string, by the friction known so far."""
        scale = 1.0 if self.testing else self.test.friction_scale
        return share * self.adaptation.factor * self.adaptation.release * self.model.full_amplitude(scale)

    def update(self, error: float, return_to_bottom: ReturnToBottom, step: float) -> None:
        """Choose the amplitude for one sample.

        Args:
            error: Target minus toolface, rad.
            return_to_bottom: Whether the bit is off bottom, and the string slides fast.
            step: Time since the last sample, s.
        """
        holding = self.amplitude_for(self._settings.holding_amplitude_share)
        self._bearable = max(self._bearable, _MIN_BEARABLE_SHARE * holding) * (1.0 + _RECOVERY_RATE * step)
        self.amplitude = min(self._target(error, return_to_bottom), self._bearable)

    def reduce(self) -> None:
        """Rock less after a torque limit was met."""
        self._bearable = _TRIP_REDUCTION * self.amplitude

    def _target(self, error: float, return_to_bottom: ReturnToBottom) -> float:
        settings = self._settings
        holding, setting = settings.holding_amplitude_share, settings.setting_amplitude_share
        if settings.amplitude > 0.0:
            return settings.amplitude
        if self.testing:
            return self.amplitude_for(holding)
        if return_to_bottom.fast:
            return self.amplitude_for(_FAST_SLIDING_SHARE * holding)
        if return_to_bottom.under_way:
            return self.amplitude_for(setting)
        weight = min(max((abs(error) - HOLDING_ERROR) / (SETTING_ERROR - HOLDING_ERROR), 0.0), 1.0)
        return self.amplitude_for(holding + (setting - holding) * weight)

    def zones(self, reactive_torque: float) -> Zones:
        """The three zones at the present amplitude and this reactive torque (N m)."""
        return self.model.zones(self.amplitude, reactive_torque, self.test.friction_scale)

    def torque_share(self, reactive_torque: float) -> float:
        """Share of the compliance that carries the mean surface torque; half of the static zone counts.

        Args:
            reactive_torque: N m.
        """
        rocked = self.model.compliance_at(self.zones(reactive_torque).rocked_to)
        return 0.5 + 0.5 * rocked / self.model.compliance
