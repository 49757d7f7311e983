"""Check whether speed or torque of a rocking drive has lost its sign."""

from __future__ import annotations

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log.series import Array
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.table_import.rocking_signs import looks_unsigned, signed_by

_MIN_NEGATIVE = 0.2  # share of the samples that would be negative


def check_unsigned(log: RigLog) -> list[LogIssue]:
    """A speed or torque that is never negative although the other of the two shows that the drive rocks."""
    drive = log.top_drive
    if drive is None:
        return []
    speed, torque = drive.velocity, drive.effort
    lost = []
    if looks_unsigned(speed) and _turns_both_ways(speed, torque, of_speed=True):
        lost.append("speed")
    if looks_unsigned(torque) and (lost or _turns_both_ways(torque, speed, of_speed=False)):
        lost.append("surface torque")
    if not lost:
        return []
    text = (
        f"the top drive's {' and '.join(lost)} never turns negative while it rocks: the sign is lost; export it with "
        "its sign, or import the table with unsigned: true, which restores it where the other of the two tells it"
    )
    return [LogIssue("unusable", "top_drive", text, "signs")]


def _turns_both_ways(size: Array, other: Array, of_speed: bool) -> bool:
    """Whether the other signal gives a good part of this one a negative sign; true where it has lost its sign, too."""
    known = other[np.isfinite(other)]
    if of_speed and (known.size == 0 or looks_unsigned(other)):
        return True
    try:
        signed = signed_by(size, other, of_speed, "")
    except InputError:
        return False
    return float(np.mean(signed[np.isfinite(signed)] < 0.0)) > _MIN_NEGATIVE
