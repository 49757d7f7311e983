"""Check that the flow is known wherever pressure was measured; mask the pressure where it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log.series import Array, JointSeries
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.log_inputs.fill_pump_gaps import fill_pump_gaps, hidden_flow_changes


def mask_pressure_of_unknown_flow(log: RigLog) -> tuple[RigLog, list[LogIssue]]:
    """Mask standpipe pressure while pump samples are missing and the pump changed its speed.

    The pressure still shows when the speed changed, so the pump gets samples around that moment.

    Returns:
        The log with these pressures as NaN, and a note if there are any.
    """
    pump, pressure = log.mud_pump, log.standpipe_pressure
    if pump is None or pressure is None:
        return log, []
    known = np.isfinite(pump.velocity)
    time, speed = pump.time[known], pump.velocity[known]
    unknown = np.zeros(pressure.time.shape, dtype=bool)
    for index in hidden_flow_changes(time, speed):
        unknown |= (pressure.time > time[index]) & (pressure.time < time[index + 1])
    unknown &= np.isfinite(pressure.value)
    if not unknown.any():
        return log, []
    first = float(pressure.time[unknown][0])
    text = (
        f"standpipe_pressure: {np.count_nonzero(unknown)} samples, the first at {first:.1f} s, are left out: the pump "
        "changed its speed there and its own samples are missing"
    )
    masked = replace(pressure, value=np.where(unknown, np.nan, pressure.value))
    filled = _with_speeds(pump, *fill_pump_gaps(time, speed, pressure.time, pressure.value))
    return replace(log, mud_pump=filled, standpipe_pressure=masked), [LogIssue("note", "standpipe_pressure", text)]


def _with_speeds(pump: JointSeries, time: Array, speed: Array) -> JointSeries:
    """The pump with samples of its speed added: time (n,) s, speed (n,) rad/s. Times that it has stay as they are."""
    new = ~np.isin(time, pump.time)
    missing = np.full(np.count_nonzero(new), np.nan)
    order = np.argsort(np.concatenate([pump.time, time[new]]), kind="stable")

    def merged(values: Array, added: Array) -> Array:
        return np.concatenate([values, added])[order]

    return JointSeries(
        merged(pump.time, time[new]), merged(pump.arrival, time[new]), merged(pump.position, missing),
        merged(pump.velocity, speed[new]), merged(pump.effort, missing),
    )  # fmt: skip
