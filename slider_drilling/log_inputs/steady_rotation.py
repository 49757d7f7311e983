"""When a string rotates steadily: friction then acts around it, and hardly along it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.log.series import Array

_TURNING = 1.0  # rad/s
_STEADY_S = 20.0


def rotates_steadily(time: Array, speed: Array) -> NDArray[np.bool_]:
    """Whether the drive has turned one way for 20 s, at each sample.

    Args:
        time: (n,) s.
        speed: (n,) of the top drive, rad/s; NaN counts as a stand.
    """
    speed = np.where(np.isfinite(speed), speed, 0.0)
    turning = np.abs(speed) > _TURNING
    same = np.r_[False, turning[1:] & turning[:-1] & (np.sign(speed[1:]) == np.sign(speed[:-1]))]
    start = np.where(same, -np.inf, time)
    return np.asarray(time - np.maximum.accumulate(start) > _STEADY_S)
