"""Pressure that was measured while the pump changed its speed and nobody logged how: masked and said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.diagnosis.first_look.finding import Finding
from slider_drilling.drillstring.lost_motion import lost
from slider_drilling.log import RigLog

# Of the pump's speed: pressure goes with the square of the flow, and a sensor shows a thousandth of it.
_CHANGED = 2e-3


def without_unknown_flow(log: RigLog) -> tuple[RigLog, list[Finding]]:
    """The log with standpipe pressure made NaN wherever the pump's samples were lost while its speed changed."""
    pump, pressure = log.mud_pump, log.standpipe_pressure
    if pump is None or pressure is None:
        return log, []
    known = np.isfinite(pump.velocity)
    time, speed = pump.time[known], pump.velocity[known]
    unknown = np.zeros(pressure.time.shape, dtype=bool)
    for index in lost(time):
        if abs(speed[index + 1] - speed[index]) > _CHANGED * np.max(np.abs(speed)):
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
    return replace(log, standpipe_pressure=replace(pressure, value=value)), [
        Finding("note", "standpipe_pressure", text)
    ]
