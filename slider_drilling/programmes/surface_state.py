"""What a programme's controller knows of the rig: channels, loads since the string hung free, and bottom."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

import numpy as np

from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
from slider_drilling.control.estimation.measurement_monitor import MeasurementMonitor
from slider_drilling.control.estimation.torque_sensor_model import TorqueSensorModel
from slider_drilling.control.interface import Measurements
from slider_drilling.programmes.bottom import BottomTracker
from slider_drilling.programmes.motion import DriveStates
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import build_mesh, torsional_impedance

_SMOOTHING = 1.0  # s, of hook load and standpipe pressure for their limits
_QUICK, _SMOOTH = 0.5, 2.0  # s, filters of differential pressure
_FLOW_SETTLES = 5.0  # lags of the standpipe after a change of flow, until pressure shows the motor again
_RECENT = 3  # samples of torque, over which noise is averaged
_TARE_PARTS, _MIN_TARED = 3, 5  # parts of the tare that are compared, and samples of each
_TARE_SIGMAS, _STEADY = 5.0, 1e3  # of the mean of a part, and N, by which the parts may differ
_FLOW_CHANGE = 0.004  # share of the speed in a sample, above which the pump is changing


class SurfaceState:
    """The surface channels of a programme.

    Args:
        rig: Rig file.
        bit_height: Of the bit above bottom at the start, m.

    Attributes:
        interval: Nominal time between samples, s.
        monitor: Values and ages of the channels.
        pressure: Across the motor.
        torque_sensor: Lag and inertia of the torque reading.
        pipe_torque: Torque of the uppermost pipe in this sample, N m; NaN where it has none.
        bottom: Bounds of bottom and bit; None until the tare has ended.
        free_hook_load: Hook load of the string that hangs free, as tared, N.
        deficit: What has left the hook since the string hung free, smoothed, N.
        standpipe: Standpipe pressure, smoothed, Pa.
    """

    def __init__(self, rig: Rig, bit_height: float) -> None:
        self.interval = 1.0 / rig.sensors.rate
        self.monitor = MeasurementMonitor.of(rig.sensors)
        self.pressure = DifferentialPressure(rig, 0.0, _QUICK, _SMOOTH)
        torque = rig.sensors.surface_torque
        impedance = torsional_impedance(rig, build_mesh(rig, 200))
        self.torque_sensor = TorqueSensorModel(impedance, torque.noise, self.interval, torque.lag)
        self.pipe_torque = math.nan
        self._torques: deque[float] = deque(maxlen=_RECENT)
        self.bottom: BottomTracker | None = None
        self.deficit, self.standpipe = math.nan, math.nan
        self._stiffness, self._bit_height = rig.string.axial_stiffness, bit_height
        self._weight_per_pressure = rig.motor.torque_per_pressure / rig.bit.lever
        self._lag = rig.hydraulics.lag
        self._hook, self.free_hook_load, self._tared = math.nan, math.nan, 0
        self._tare_samples: list[float] = []  # N
        self._hook_noise = rig.sensors.hook_load.noise
        self._pump, self._pump_before = math.nan, math.nan  # rad/s, lagged as the pressure; of the last sample
        self._flow_changed = math.inf  # s ago
        share = math.sqrt(0.5 * self.interval / _SMOOTHING)  # of the noise that smoothing leaves
        self.hook_sigma = share * rig.sensors.hook_load.noise
        self.pressure_sigma = share * rig.sensors.standpipe_pressure.noise

    def read(self, measurements: Measurements, taring: bool) -> None:
        """Take one sample; taring: nothing moves yet, and the string hangs free."""
        monitor = self.monitor
        monitor.update(measurements, self.interval)
        step, torque = monitor.step, monitor.fresh("surface_torque")
        self.pipe_torque = self.torque_sensor.pipe_torque(measurements.top_drive_speed, torque, step)
        if math.isfinite(self.pipe_torque):
            self._torques.append(self.pipe_torque)
        self._read_hook_load(monitor.fresh("hook_load"), taring, step)
        self._read_pressure(monitor.fresh("standpipe_pressure"), monitor.value["pump_speed"], taring, step)
        block = monitor.value["block_position"]
        if taring:
            self.bottom = BottomTracker(self._stiffness, block, self._bit_height) if math.isfinite(block) else None
        elif self.bottom is not None:
            weight = self.weight_by_pressure if self.motor_pressure_known else None
            self.bottom.update(block, measurements.block_speed, self.deficit, weight)

    @property
    def weight_by_pressure(self) -> float:
        """Weight on bit by the pressure across the motor, N; 0 while a change of flow hides it."""
        return self._weight_per_pressure * max(self.pressure.smooth, 0.0) if self.motor_pressure_known else 0.0

    @property
    def recent_torque(self) -> float:
        """Mean torque of the last samples, N m; 0 before the first."""
        return sum(self._torques) / len(self._torques) if self._torques else 0.0

    @property
    def motor_pressure_known(self) -> bool:
        """Whether the standpipe has settled since the last change of flow."""
        return self._flow_changed > _FLOW_SETTLES * self._lag + _SMOOTH

    @property
    def largest_weight(self) -> float:
        """Largest weight that can be on the bit, N: what left the hook, wherever it hangs now."""
        if self.bottom is not None and self.bottom.surely_off:
            return 0.0
        deficit = self.deficit if math.isfinite(self.deficit) else 0.0
        return max(deficit, self.weight_by_pressure)

    def measured(self, drives: DriveStates) -> DriveStates:
        """The same drives, with block and bottom as they were measured."""
        block, bottom = self.monitor.value["block_position"], self.bottom
        if bottom is None or not math.isfinite(block):
            return drives
        return replace(drives, block=block, deepest=max(bottom.deepest, block), touching=bottom.touching)

    @property
    def unsteady_hook_load(self) -> float:
        """Change of the hook load during the tare, N; 0 where noise explains it."""
        if self._tared < _TARE_PARTS * _MIN_TARED:
            return 0.0
        parts = np.array_split(np.array(self._tare_samples), _TARE_PARTS)
        means = [float(part.mean()) for part in parts]
        swing = max(means) - min(means)
        noise = self._hook_noise / math.sqrt(len(parts[0])) * _TARE_SIGMAS + _STEADY
        return swing if swing > noise else 0.0

    @property
    def missing(self) -> str:
        """A channel that was not measured during the tare, or ""."""
        return next((name for name, value in self.monitor.value.items() if not math.isfinite(value)), "")

    def _read_hook_load(self, hook_load: float, taring: bool, step: float) -> None:
        if not math.isfinite(hook_load):
            return
        if taring:
            self._tared += 1
            self._tare_samples.append(hook_load)
            before = self.free_hook_load if self._tared > 1 else hook_load
            self.free_hook_load = before + (hook_load - before) / self._tared
            self._hook = self.free_hook_load
        self._hook += (1.0 - math.exp(-step / _SMOOTHING)) * (hook_load - self._hook)
        self.deficit = self.free_hook_load - self._hook

    def _read_pressure(self, pressure: float, pump: float, taring: bool, step: float) -> None:
        if not (math.isfinite(pressure) and math.isfinite(pump)):
            return
        if math.isnan(self._pump):
            self._pump = self._pump_before = pump
            self.standpipe = pressure
        changing = abs(pump - self._pump_before) > _FLOW_CHANGE * max(pump, self._pump_before)
        self._flow_changed = 0.0 if changing else self._flow_changed + step
        self._pump_before = pump
        self._pump += (pump - self._pump) * (1.0 - math.exp(-step / self._lag) if self._lag > 0.0 else 1.0)
        self.standpipe += (1.0 - math.exp(-step / _SMOOTHING)) * (pressure - self.standpipe)
        if taring:
            self.pressure.tare(pressure, pump, step)
        self.pressure.update(pressure, self._pump, step)
