"""Slides of a whole well: the example rig, longer wells like it, and commands with rocking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.control.rocking import Rocking
from slider_drilling.drillstring import Commands
from slider_drilling.rig import Rig

ELEMENTS = 100
"""Surface torque is then within 3 % of that with 200 elements: enough to compare tools, and four times as fast."""
HOUR = 3600.0
INTERVAL = 0.1
ROUNDING = 0.2


def longer(rig: Rig, extra: float) -> Rig:
    """The same well with its horizontal hole and drill pipe longer by ``extra`` m."""
    *above, last = rig.well.survey
    *cased, open_hole = rig.well.friction_intervals
    pipe, *below = rig.string.sections
    return replace(
        rig,
        well=replace(
            rig.well,
            survey=(*above, (last[0] + extra, last[1], last[2])),
            friction_intervals=(*cased, replace(open_hole, to=open_hole.to + extra)),
        ),
        string=replace(rig.string, sections=(replace(pipe, length=pipe.length + extra), *below)),
    )


def slide(rig: Rig, duration: float, rate_m_per_h: float, amplitude: float = 0.0, period: float = 20.0) -> Commands:
    """Commands of a slide at constant block speed.

    Args:
        duration: s.
        rate_m_per_h: Block speed, m/h.
        amplitude: Of the rocking, rad; 0 for none.
        period: Of the rocking, s.
    """
    time = np.arange(round(duration / INTERVAL) + 1, dtype=np.float64) * INTERVAL
    angle, speed = np.zeros(time.size), np.zeros(time.size)
    if amplitude > 0.0:
        wave = Rocking(amplitude, period, ROUNDING)
        angle, speed = np.array([wave.from_rest(t) for t in time]).T
    lowering = np.full(time.size, rate_m_per_h / HOUR)
    block = time * rate_m_per_h / HOUR
    pump = np.full_like(time, rig.reference_pump_speed)
    return Commands(time, angle, speed, block, lowering, pump)
