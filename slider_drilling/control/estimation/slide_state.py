"""State of a slide: everything that is estimated from the surface channels, sample by sample."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slider_drilling.control.estimation.cycle_average import CycleAverage, CycleAverager
from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
from slider_drilling.control.estimation.measurement_monitor import MeasurementMonitor
from slider_drilling.control.estimation.repeated_reading import RepeatedReading
from slider_drilling.control.estimation.rocking_phase import RockingPhase
from slider_drilling.control.estimation.tool_face_estimator import EstimatorNoise, ToolFaceEstimator
from slider_drilling.control.estimation.torque_sensor_model import TorqueSensorModel
from slider_drilling.control.interface import Measurements, MwdSample
from slider_drilling.control.slide_settings import SlideSettings

if TYPE_CHECKING:
    from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
    from slider_drilling.rig import Rig

# Rocking lets twist spread along a long string as heat spreads in a rod: with the square of the length.
_RESPONSE_PER_TRAVEL = 38.0  # 1/s, response time of the toolface over the squared travel time of torsion
_MIN_RESPONSE_SHARE = 0.75   # of that time; no string responds faster
_MIN_INITIAL_RESPONSE = 60.0   # s, assumed at first: a shorter one makes short strings slow to set
_UNEXPLAINED = math.radians(0.8)   # rad, of an MWD sample besides its noise
_WALK, _DRIFT = math.radians(0.6), math.radians(0.15)   # rad/sqrt(s), of the toolface and of its offset
# Prior of the mean torque of a cycle with an unloaded bit: bias of the sensor, N m, and friction that differs between
# right and left, as a share of the breakover torque beyond this one, N m. A shorter string shows the difference soon
# enough by MWD, and a wider prior would double its time to set where friction depends on the pipe's angle.
_BIAS_SIGMA, _DIRECTION_SIGMA, _DIRECTION_FROM = 200.0, 0.25, 8.5e3
_TWIST_SHARE = 0.1           # error of the twist over the driving twist
_MOVE_SHARE = 0.3            # of a move of the centre, that surface torque does not show yet
_QUICK_TIME, _SMOOTH_TIME = 0.5, 6.0   # s, filters of differential pressure


class SlideState:
    """Measurements, differential pressure, torque and toolface of a slide.

    Args:
        rig: Rig with its worn motor.
        settings: Settings of the slide.
        model: Torque and drag of the string.

    Attributes:
        interval: Time between samples, s.
        monitor: Values and ages of the channels.
        pressure: Across the motor.
        torque_sensor: Lag and inertia of the torque reading.
        tool_face: Toolface and string.
        pipe_torque: Torque of the uppermost pipe in this sample, N m; NaN where it has none.
        mwd_age: Time since the last accepted MWD sample was read, s; while MWD is stuck, since its first equal reading.
    """

    def __init__(self, rig: Rig, settings: SlideSettings, model: TorqueAndDrag):
        self.interval = 1.0 / rig.sensors.rate
        self._spreading_time = _RESPONSE_PER_TRAVEL * model.travel_time**2
        self.monitor = MeasurementMonitor.of(rig.sensors)
        self.pressure = DifferentialPressure(rig, settings.off_bottom_pressure, _QUICK_TIME, _SMOOTH_TIME)
        sensor = rig.sensors.surface_torque
        self.torque_sensor = TorqueSensorModel(model.impedance, sensor.noise, self.interval, sensor.lag)
        mwd = rig.sensors.mwd
        sample = math.sqrt(mwd.noise**2 + mwd.resolution**2 / 12.0 + _UNEXPLAINED**2)
        spread = math.hypot(mwd.noise, _UNEXPLAINED) if mwd.noise > 0.0 else 0.0
        self._mwd_repeats = RepeatedReading(spread, mwd.resolution)
        noise = EstimatorNoise(sample, sensor.noise, self.interval, _TWIST_SHARE, _MOVE_SHARE, _WALK, _DRIFT)
        breakover_torque = model.breakover_torque(model.full_amplitude(1.0), 1.0)
        self.tool_face = ToolFaceEstimator(
            model.compliance, self._response_time(settings), noise, bias=rig.effects.torque_sensor_bias.bias,
            min_response_time=_MIN_RESPONSE_SHARE * self._spreading_time,
            bias_sigma=math.hypot(_BIAS_SIGMA, _DIRECTION_SIGMA * max(breakover_torque - _DIRECTION_FROM, 0.0)))
        self._averager = CycleAverager()
        self._phase = RockingPhase()
        self._strokes = 0            # reversals that the phase knows of
        self.pipe_torque = math.nan
        self.mwd_age = 0.0

    def configure(self, rig: Rig, settings: SlideSettings) -> None:
        """Use other settings from the next sample on."""
        self.pressure.configure(rig, settings.off_bottom_pressure)
        self.tool_face.filter.response_time = self._response_time(settings)

    def _response_time(self, settings: SlideSettings) -> float:
        """Response time of the toolface that is assumed at first, s."""
        return settings.response_time or max(self._spreading_time, _MIN_INITIAL_RESPONSE)

    @property
    def elapsed(self) -> float:
        """Advance of the clock in this sample, s; the sample interval where the clock stood still."""
        return self.monitor.step or self.interval

    def read(self, measurements: Measurements, off_bottom: bool) -> None:
        """Take the channels of one sample; off_bottom: whether the pressure is circulation alone."""
        monitor = self.monitor
        monitor.update(measurements, self.interval)
        torque = monitor.fresh("surface_torque")
        self.pipe_torque = self.torque_sensor.pipe_torque(measurements.top_drive_speed, torque, monitor.step)
        pressure, pump_speed = monitor.fresh("standpipe_pressure"), monitor.value["pump_speed"]
        if off_bottom:
            self.pressure.tare(pressure, pump_speed, monitor.step)
        self.pressure.update(pressure, pump_speed, monitor.step)

    @property
    def mwd_stuck(self) -> bool:
        """Whether MWD repeats its reading although its noise would change it."""
        return self._mwd_repeats.stuck

    def advance(self, strokes: int) -> CycleAverage | None:
        """Advance the toolface to this sample.

        Args:
            strokes: Reversals of the reference so far.

        Returns:
            The average of the rocking cycle that has just ended, or None.
        """
        monitor = self.monitor
        if monitor.jumped:
            self.tool_face.reset_clock(monitor.time)
        self.mwd_age += monitor.step
        if not math.isfinite(monitor.time):
            return None
        self.tool_face.advance(monitor.time, self.pressure.reactive_torque)
        if strokes != self._strokes:
            self._strokes = strokes
            self._phase.add_reversal(monitor.time)
        return self._averager.update(monitor.step, monitor.fresh("top_drive_angle"), self.pipe_torque,
                                     self.pressure.quick_reactive_torque, strokes)

    def take_mwd(self, samples: tuple[MwdSample, ...], reference: float) -> None:
        """Take the MWD samples of this sample; reference: toolface whose whole turn the first ones get, rad."""
        for sample in samples:
            self._mwd_repeats.update(sample.tool_face, sample.measured_at)
            if self.mwd_stuck:
                self.mwd_age = max(self.monitor.time - self._mwd_repeats.since, 0.0)
            elif self.tool_face.update_with_mwd(sample, reference, self._phase.at(sample.measured_at)):
                self.mwd_age = max(self.monitor.time - sample.measured_at, 0.0)
