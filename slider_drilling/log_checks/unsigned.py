"""Check whether speed or torque of a rocking drive has lost its sign."""

from __future__ import annotations

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.table_import.rocking_signs import looks_unsigned


def check_unsigned(log: RigLog) -> list[LogIssue]:
    """A speed or torque that is never negative although the other of the two shows that the drive rocks."""
    drive = log.top_drive
    if drive is None or drive.time.size < 3:
        return []
    interval = max(float(np.median(np.diff(drive.time))), 1e-3)
    speed, torque = drive.velocity, drive.effort
    lost = ["speed"] if looks_unsigned(speed, torque, of_speed=True, interval=interval) else []
    if looks_unsigned(torque, speed, of_speed=False, interval=interval):
        lost.append("surface torque")
    if not lost:
        return []
    text = (
        f"the top drive's {' and '.join(lost)} never turns negative while it rocks: the sign is lost; export it with "
        "its sign, or import the table with unsigned: true, which restores it where the other of the two tells it"
    )
    return [LogIssue("unusable", "top_drive", text, "signs")]
