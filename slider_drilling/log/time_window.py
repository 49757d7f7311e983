"""Cuts a time window out of a log."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import Array, Series


def cut_time_window(log: RigLog, first: float, last: float) -> RigLog:
    """The log between two times.

    The last target before the window is kept at its own time. A series without samples in the window is None.

    Args:
        log: The whole log.
        first: Start of the window, s of the log; t = 0 of the result.
        last: End of the window, s of the log.
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
    """The window in which the top drive reverses most often, or turns most where it never reverses.

    Rocking is where friction shows best.

    Args:
        log: The whole log.
        longest: Length of the window, s.

    Returns:
        The window and a sentence on it; the log itself and "" where it is not longer.
    """
    drive = log.top_drive
    if drive is None or drive.time[-1] - drive.time[0] <= longest:
        return log, ""
    time = drive.time
    starts = np.arange(time[0], time[-1] - longest + 1.0, longest / 20.0)
    total = _activity(time, drive.position, drive.velocity)
    ends = np.searchsorted(time, starts + longest, side="right") - 1
    activity = total[ends] - total[np.searchsorted(time, starts)]
    first = float(starts[int(np.argmax(activity))])
    sentence = (
        f"all but {longest:.0f} s of the log's {time[-1] - time[0]:.0f} s: analysed from {first:.0f} s on, where the "
        "top drive rocks most"
    )
    return cut_time_window(log, first, first + longest), sentence


def _activity(time: Array, position: Array, velocity: Array) -> Array:
    """Number of reversals of the top drive up to each sample, plus a millionth of the angle turned."""
    speed = np.where(np.isfinite(velocity), velocity, np.gradient(np.nan_to_num(position), time))
    moving = np.flatnonzero(np.abs(speed) > 0.05)
    reversals = np.zeros(len(time))
    turns = moving[1:][np.sign(speed[moving[1:]]) != np.sign(speed[moving[:-1]])]
    reversals[turns] = 1.0
    angle = np.concatenate([[0.0], np.abs(speed[1:]) * np.diff(time)])
    return np.asarray(np.cumsum(reversals + 1e-6 * np.nan_to_num(angle)))
