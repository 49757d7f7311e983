"""Pressure that was measured while the pump changed its speed and nobody logged how: it tells when, and is masked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.log.series import Array, JointSeries, RigLog
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.log_inputs.reconstruct_flow import lost_changes, with_lost_flow


def mask_pressure_of_unknown_flow(log: RigLog) -> tuple[RigLog, list[LogIssue]]:
    """The log with standpipe pressure made NaN wherever the pump's samples were lost while its speed changed, and with
    the pump's speed about the moment of the change where that pressure tells it.
    """
    pump, pressure = log.mud_pump, log.standpipe_pressure
    if pump is None or pressure is None:
        return log, []
    known = np.isfinite(pump.velocity)
    time, speed = pump.time[known], pump.velocity[known]
    unknown = np.zeros(pressure.time.shape, dtype=bool)
    for index in lost_changes(time, speed):
        unknown |= (pressure.time > time[index]) & (pressure.time < time[index + 1])
    unknown &= np.isfinite(pressure.value)
    if not unknown.any():
        return log, []
    first = float(pressure.time[unknown][0])
    text = (
        f"standpipe_pressure: {np.count_nonzero(unknown)} samples, the first at {first:.1f} s, are left out: the pump "
        "changed its speed meanwhile and its own samples are missing"
    )
    value = np.where(unknown, np.nan, pressure.value)
    found = _with_speeds(pump, *with_lost_flow(time, speed, pressure.time, pressure.value))
    return replace(log, mud_pump=found, standpipe_pressure=replace(pressure, value=value)), [
        LogIssue("note", "standpipe_pressure", text)
    ]


def _with_speeds(pump: JointSeries, time: Array, speed: Array) -> JointSeries:
    """A pump with samples of its speed (n,), s, rad/s, of which it may have some already."""
    new = ~np.isin(time, pump.time)
    nothing = np.full(np.count_nonzero(new), np.nan)
    order = np.argsort(np.concatenate([pump.time, time[new]]), kind="stable")

    def joined(own: Array, added: Array) -> Array:
        return np.concatenate([own, added])[order]

    return JointSeries(
        joined(pump.time, time[new]), joined(pump.arrival, time[new]), joined(pump.position, nothing),
        joined(pump.velocity, speed[new]), joined(pump.effort, nothing),
    )  # fmt: skip
