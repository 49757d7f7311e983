"""The command with which a controller leaves a rig: block stopped, top drive held, pump as it is."""

from __future__ import annotations

import math
from dataclasses import replace

from slider_drilling.control.interface import RigCommand


def safe_stop(last: RigCommand, angle: float, speed: float, max_acceleration: float) -> RigCommand:
    """The command that stops block and top drive.

    Args:
        last: The last command; its pump speed goes on, since without flow cuttings settle.
        angle: Of the top drive at the last sample, rad; NaN if it is not known.
        speed: Of the top drive at the last sample, rad/s; NaN if it is not known.
        max_acceleration: Of the top drive, rad/s2.

    Returns:
        A command to hold the top drive where it comes to rest if braked as hard as it can; at the last commanded angle
        if it is not known where it is.
    """
    at_rest = angle + speed * abs(speed) / (2.0 * max_acceleration)
    held = at_rest if math.isfinite(at_rest) else float(last.top_drive_angle)
    return replace(last, top_drive_angle=held, top_drive_speed=0.0, block_speed=0.0)
