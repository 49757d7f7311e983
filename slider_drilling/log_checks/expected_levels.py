"""The level of each channel by the rig file: from static loads, from the flow, and from a simulation of the log."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.drillstring import simulate
from slider_drilling.drillstring.recorded_channels import Response
from slider_drilling.log import RigLog
from slider_drilling.log.series import Array
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.rig import Rig
from slider_drilling.wellbore.static_loads import static_loads

_ELEMENTS = 32
_MAX_SIMULATED = 1200.0  # s; only the first part of a longer log is simulated
_START_SHARE = 0.05  # of the log: shows how the string hangs at the start
_NOISE = 3.0  # standard deviations of noise that are no level
_PUMPING = 0.3  # of the highest flow in the log
_CARRIED = 0.01  # of the string's weight, that is always left on the hook

# Measured over expected level that calibration or a catalogued effect can still explain.
# Torque: friction factors (0.4 to 2.5; from 0.15 with torque alone) and a sensor's gain (0.4 to 2.5) at their limits.
# Pressure: a flow that is wrong by two thirds, 1.66**1.8. Hook load: drag in a long horizontal hole.
TORQUE, TORQUE_ALONE, PRESSURE, HOOK_LOAD = (0.16, 6.25), (0.06, 6.25), (0.4, 2.5), (0.4, 2.0)

# N/m. A rig file cannot say "off bottom", but rock this soft takes no weight.
OFF_BOTTOM_STIFFNESS = 1.0


@dataclass(frozen=True)
class ExpectedLevel:
    """A channel's level as measured and as the rig file gives it, in the channel's SI unit.

    Attributes:
        verb: Joins the channel's name and the level in a sentence ("starts at").
        measured: Level in the log.
        expected: Level by the rig file.
        low: Lowest level that calibration can reach.
        high: Highest level that calibration can reach.
        noise: Standard deviation of the channel's white noise.
    """

    verb: str
    measured: float
    expected: float
    low: float
    high: float
    noise: float = 0.0

    @property
    def fits(self) -> bool:
        """Whether calibration can reach the measured level."""
        return self.low <= self.measured <= self.high

    @property
    def dead(self) -> bool:
        """Whether the level is zero or no more than noise: no sensor is behind the channel."""
        return abs(self.measured) <= _NOISE * self.noise


def simulate_as_given(log: RigLog, rig: Rig) -> Response | None:
    """Simulate the first part of the log with the rig file as given; None if the log drives nothing."""
    commands = commands_from_log(log, rig).commands
    inside = commands.time <= commands.time[0] + _MAX_SIMULATED
    if np.count_nonzero(inside) < 3:
        return None
    return simulate(rig, commands.samples(inside), _ELEMENTS)


def hook_load(log: RigLog, rig: Rig, whole: bool = True) -> ExpectedLevel | None:
    """Hook load at the start of the log, against the string's buoyed weight.

    Args:
        log: The log.
        rig: Its rig file.
        whole: Whether the log begins as a run does. In a part of one, wall and bit may carry most of the string.
    """
    if log.draw_works is None:
        return None
    values = log.draw_works.effort[np.isfinite(log.draw_works.effort)]
    if values.size == 0:
        return None
    measured = float(np.median(values[: max(int(_START_SHARE * values.size), 1)]))
    hanging = static_loads(rig, elements=100).hook_load
    noise = _white_noise(values)
    least = HOOK_LOAD[0] * hanging if whole else max(_NOISE * noise, _CARRIED * hanging)
    return ExpectedLevel("starts at", measured, hanging, least, HOOK_LOAD[1] * hanging, noise)


def standpipe_pressure(log: RigLog, rig: Rig, pump_unit: float = 1.0) -> ExpectedLevel | None:
    """Pressure while the pump runs, against the pressure loss at its flow; the motor may add its maximum.

    Args:
        log: The log.
        rig: Its rig file.
        pump_unit: Unit of the pump's speed, in rad/s.
    """
    pressure, pump = log.standpipe_pressure, log.mud_pump
    if pressure is None:
        return None
    speed = np.full(pressure.time.size, rig.reference_pump_speed)
    if pump is not None and np.isfinite(pump.velocity).any():
        known = np.isfinite(pump.velocity)
        speed = np.interp(pressure.time, pump.time[known], pump_unit * pump.velocity[known])
    running = np.isfinite(pressure.value) & (speed > _PUMPING * speed.max()) & (speed > 0.0)
    if not running.any():
        return None
    loss = rig.circulation_at(speed[running])
    expected, measured = float(np.median(loss)), float(np.median(pressure.value[running]))
    if expected <= 0.0:
        return None
    high = PRESSURE[1] * expected + rig.motor.pressure_at_stall
    noise = _white_noise(pressure.value[running])
    return ExpectedLevel("is", measured, expected, PRESSURE[0] * expected, high, noise)


def surface_torque(log: RigLog, time: Array, simulated: Array) -> ExpectedLevel | None:
    """The 95 % quantile of the torque's size, against the simulation of the same motion.

    Args:
        log: The log.
        time: Of the simulation, s.
        simulated: Surface torque then, N m.
    """
    drive = log.top_drive
    if drive is None or not np.isfinite(drive.effort).any():
        return None
    inside = np.isfinite(drive.effort) & (drive.time <= time[-1])
    if np.count_nonzero(inside) < 10:
        return None
    measured, expected = _size_and_spread(drive.effort[inside]), _size_and_spread(simulated)
    # A sensor with an offset has a wrong size but the right spread; a string turned steadily has hardly a spread.
    ratios = [m / e for m, e in zip(measured, expected, strict=True) if e > 0.0]
    if not ratios:
        return None
    ratio = min(ratios, key=lambda r: abs(np.log(max(r, 1e-12))))
    low, high = TORQUE_ALONE if log.draw_works is None and log.standpipe_pressure is None else TORQUE
    limits = low * expected[0], high * expected[0]
    return ExpectedLevel("reaches", ratio * expected[0], expected[0], *limits, _white_noise(drive.effort[inside]))


def _white_noise(values: Array) -> float:
    """Standard deviation of the noise of evenly spaced values, by their second differences, which cancel trends."""
    if values.size < 3:
        return 0.0
    return float(1.4826 * np.median(np.abs(np.diff(values, 2))) / np.sqrt(6.0))


def _size_and_spread(values: Array) -> tuple[float, float]:
    low, high = np.quantile(values, (0.05, 0.95))
    return float(np.quantile(np.abs(values), 0.95)), float(high - low)


def rig_off_bottom(log: RigLog, rig: Rig) -> Rig:
    """The rig with rock that takes no weight if the log holds neither drawworks nor standpipe pressure."""
    if log.draw_works is not None or log.standpipe_pressure is not None:
        return rig
    return replace(rig, bit=replace(rig.bit, depth_of_cut_stiffness=OFF_BOTTOM_STIFFNESS))
