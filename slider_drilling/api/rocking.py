"""`rocking`: commands of steady rocking about a fixed centre while the block is lowered."""

from __future__ import annotations

import numpy as np

from slider_drilling.api.checks import check_rig
from slider_drilling.control.rocking import Rocking
from slider_drilling.drillstring import Commands
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.schema.option_types import check_argument


def rocking(
    rig: Rig,
    duration: float,
    *,
    amplitude: float,
    period: float,
    rounding: float = 0.5,
    centre: float = 0.0,
    block_speed: float = 0.0025,
    pump_speed: float | None = None,
    interval: float | None = None,
) -> Commands:
    """Commands that rock the top drive from rest, with a triangle wave whose peaks are rounded.

    Args:
        rig: Gives sampling rate and pump speed.
        duration: s.
        amplitude: To either side, rad.
        period: s.
        rounding: Half the width of a rounded peak, s.
        centre: Centre of rocking, rad; reached over the first period.
        block_speed: m/s, positive lowers.
        pump_speed: rad/s; the one for the reference flow if None.
        interval: Time between samples, s; that of the rig's sensors if None.

    Raises:
        InputError: A number cannot be used.
    """
    check_rig(rig, "rocking")
    given = {"duration": duration, "amplitude": amplitude, "period": period, "rounding": rounding, "centre": centre,
             "block_speed": block_speed, "pump_speed": 0.0 if pump_speed is None else pump_speed,
             "interval": 1.0 if interval is None else interval}  # fmt: skip
    for name, value in given.items():
        check_argument(value, float, f"rocking: {name}")
        if not np.isfinite(value):
            raise InputError(f"rocking: {name} = {value}: must be a finite number")
    if duration <= 0.0 or given["interval"] <= 0.0:
        raise InputError(f"rocking: duration = {duration} s, interval = {interval} s: must be above 0")
    wave = Rocking(amplitude, period, rounding)
    step = 1.0 / rig.sensors.rate if interval is None else interval
    time = step * np.arange(round(duration / step) + 1, dtype=np.float64)
    angle, speed = np.array([wave.from_rest(t) for t in time]).T
    # A smooth step to the centre: no speed at either end.
    share = np.clip(time / period, 0.0, 1.0)
    angle = angle + centre * share**2 * (3.0 - 2.0 * share)
    speed = speed + centre * 6.0 * share * (1.0 - share) / period
    pump = rig.reference_pump_speed if pump_speed is None else pump_speed
    return Commands(time, angle, speed, block_speed * time, np.full_like(time, block_speed), np.full_like(time, pump))
