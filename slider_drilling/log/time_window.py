"""A part of a log as a log: where the whole is longer than what is to be done with it can take."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import Array, Series


def cut_time_window(log: RigLog, first: float, last: float) -> RigLog:
    """The samples measured from `first` to `last` (s of the log); its t = 0 is `first`.

    The last value of a target before that stays, as of then. A series without a sample in it is None.
    """
    changed: dict[str, Any] = {"start_ns": log.start_ns + round(first * 1e9)}
    for key, series in log.series().items():
        keep = (series.time >= first) & (series.time <= last)
        if key == "tool_face_target" and not keep[:1].any():
            before = np.flatnonzero(series.time < first)
            keep[before[-1:]] = True
        changed[key] = _cut(series, keep, first) if keep.any() else None
    return replace(log, **changed)


def _cut(series: Series, keep: NDArray[np.bool_], first: float) -> Series:
    arrays = {part.name: getattr(series, part.name)[keep] for part in fields(series)}
    arrays["time"], arrays["arrival"] = arrays["time"] - first, arrays["arrival"] - first
    return replace(series, **arrays)


def most_active_window(log: RigLog, longest: float) -> tuple[RigLog, str]:
    """At most `longest` s of the log, and a sentence on which; the log itself, and "", where it is no longer.

    The stretch in which the top drive turns round most often, or turns most where it never does: rocking is where
    friction shows.
    """
    drive = log.top_drive
    if drive is None or drive.time[-1] - drive.time[0] <= longest:
        return log, ""
    time = drive.time
    begins = np.arange(time[0], time[-1] - longest + 1.0, longest / 20.0)
    total = _activity(time, drive.position, drive.velocity)
    ends = np.searchsorted(time, begins + longest, side="right") - 1
    gained = total[ends] - total[np.searchsorted(time, begins)]
    first = float(begins[int(np.argmax(gained))])
    sentence = (
        f"the log's {time[-1] - time[0]:.0f} s but for the {longest:.0f} s from {first:.0f} s on, where the top drive "
        "rocks most: more than that is not analysed at once"
    )
    return cut_time_window(log, first, first + longest), sentence


def _activity(time: Array, position: Array, velocity: Array) -> Array:
    """How often the top drive has turned round up to each sample, with a bit for how far it has turned."""
    speed = np.where(np.isfinite(velocity), velocity, np.gradient(np.nan_to_num(position), time))
    moving = np.flatnonzero(np.abs(speed) > 0.05)
    turned = np.zeros(len(time))
    turns = moving[1:][np.sign(speed[moving[1:]]) != np.sign(speed[moving[:-1]])]
    turned[turns] = 1.0
    way = np.concatenate([[0.0], np.abs(speed[1:]) * np.diff(time)])
    return np.asarray(np.cumsum(turned + 1e-6 * np.nan_to_num(way)))
