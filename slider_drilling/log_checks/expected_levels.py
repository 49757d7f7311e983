"""What the rig file lets a channel be: from static loads, from the flow, and from a replay of the log's own motions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.drillstring import simulate
from slider_drilling.drillstring.recorded_channels import Commands, Response
from slider_drilling.log import RigLog
from slider_drilling.log.series import Array
from slider_drilling.log_inputs.drives_from_log import commands_from_log
from slider_drilling.rig import Rig
from slider_drilling.wellbore.static_loads import static_loads

_ELEMENTS = 32
_LONGEST_S = 1200.0  # of a replay; a longer log is replayed in its first part
_FIRST = 0.05  # share of the log that tells how the string hangs at the start
_ON = 0.3  # of the fastest that the pump ran

# What a channel may be over what the rig file gives, and still be a matter of tuning or of a known effect. Torque:
# friction factors (0.4 to 2.5; from 0.15 in a log of torque alone) and a sensor's gain (0.4 to 2.5) at their ends
# together. Pressure: a flow off by two thirds, as 1.66**1.8. Hook load: drag of a string just raised or lowered in a
# long horizontal hole.
TORQUE, TORQUE_ALONE, PRESSURE, HOOK_LOAD = (0.16, 6.25), (0.06, 6.25), (0.4, 2.5), (0.4, 2.0)

# N/m: an off-bottom bit; the plant's rig file has no "not on bottom", but rock this soft takes no weight.
OFF_BOTTOM_STIFFNESS = 1.0


@dataclass(frozen=True)
class ExpectedLevel:
    """measured: the level that the log shows; by_file: what the rig file gives; low, high: what could be tuned to.

    All in the channel's SI unit; what: how the level is called in a sentence.
    """

    what: str
    measured: float
    expected: float
    low: float
    high: float

    @property
    def fits(self) -> bool:
        return self.low <= self.measured <= self.high


def simulate_as_given(log: RigLog, rig: Rig) -> tuple[Commands, Response] | None:
    """The log's first part driven through the plant as the rig file gives it; None where nothing drives it."""
    commands = commands_from_log(log, rig).commands
    inside = commands.time <= commands.time[0] + _LONGEST_S
    if np.count_nonzero(inside) < 3:
        return None
    commands = commands.part(inside)
    return commands, simulate(rig, commands, _ELEMENTS)


def hook_load(log: RigLog, rig: Rig) -> ExpectedLevel | None:
    """Of the string as it hangs at the start, against its buoyed weight."""
    if log.draw_works is None:
        return None
    values = log.draw_works.effort[np.isfinite(log.draw_works.effort)]
    if values.size == 0:
        return None
    measured = float(np.median(values[: max(int(_FIRST * values.size), 1)]))
    hanging = static_loads(rig, elements=100).hook_load
    return ExpectedLevel("starts at", measured, hanging, HOOK_LOAD[0] * hanging, HOOK_LOAD[1] * hanging)


def standpipe_pressure(log: RigLog, rig: Rig, pump_unit: float = 1.0) -> ExpectedLevel | None:
    """While the pump runs, against what its flow needs through the string, and the motor's pressure on top.

    pump_unit: of the pump's speed, in rad/s.
    """
    pipe, pump, hydraulics = log.standpipe_pressure, log.mud_pump, rig.hydraulics
    if pipe is None:
        return None
    flow = np.full(pipe.time.size, hydraulics.reference_flow)
    if pump is not None and np.isfinite(pump.velocity).any():
        known = np.isfinite(pump.velocity)
        flow = np.interp(pipe.time, pump.time[known], pump_unit * pump.velocity[known]) * rig.mud_pump.displacement
    running = np.isfinite(pipe.value) & (flow > _ON * flow.max()) & (flow > 0.0)
    if not running.any():
        return None
    needed = rig.circulating_pressure * (flow[running] / hydraulics.reference_flow) ** 1.8
    by_file, measured = float(np.median(needed)), float(np.median(pipe.value[running]))
    if by_file <= 0.0:
        return None
    high = PRESSURE[1] * by_file + rig.motor.max_pressure
    return ExpectedLevel("is", measured, by_file, PRESSURE[0] * by_file, high)


def surface_torque(log: RigLog, response: Response) -> ExpectedLevel | None:
    """How large it is nearly always (95 %), against the replay of the same motion."""
    drive = log.top_drive
    if drive is None or not np.isfinite(drive.effort).any():
        return None
    inside = np.isfinite(drive.effort) & (drive.time <= response.time[-1])
    if np.count_nonzero(inside) < 10:
        return None
    measured, by_file = _sizes(drive.effort[inside]), _sizes(response.surface_torque)
    # A sensor that is off by a constant shows a size but no spread, a string turned steadily hardly a spread.
    ratios = [m / f for m, f in zip(measured, by_file, strict=True) if f > 0.0]
    if not ratios:
        return None
    ratio = min(ratios, key=lambda r: abs(np.log(max(r, 1e-12))))
    least, most = TORQUE_ALONE if log.draw_works is None and log.standpipe_pressure is None else TORQUE
    return ExpectedLevel("reaches", ratio * by_file[0], by_file[0], least * by_file[0], most * by_file[0])


def _sizes(values: Array) -> tuple[float, float]:
    low, high = np.quantile(values, (0.05, 0.95))
    return float(np.quantile(np.abs(values), 0.95)), float(high - low)


def rig_off_bottom(log: RigLog, rig: Rig) -> Rig:
    """The rig with rock that takes no weight where the log holds neither drawworks nor standpipe pressure."""
    if log.draw_works is not None or log.standpipe_pressure is not None:
        return rig
    return replace(rig, bit=replace(rig.bit, depth_of_cut_stiffness=OFF_BOTTOM_STIFFNESS))
