"""What a torque read at the top drive's motor holds beyond the pipe's: what speeds the drive itself up.

At each reversal the drive is braked hard, and a torque read at its motor leaps by ``J a`` with the acceleration; what
the pipe takes goes with the speed (its wave impedance) and with the twist, and does not leap. From one sample to the
next, ``d(torque) = J d(acceleration) + Z d(speed)``: J is learnt by least squares, and taken off.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_PRIOR = (300.0, 1e3)         # kg m2 and N m s: one standard deviation of J, of Z
_SHARP = 2.0                  # rad/s2, of change from one sample to the next, that tells of J
_ABSURD = 1e3                 # rad/s2, that no drive makes
_SURE = 4.0                   # standard deviations of J beyond nothing, from which on it is believed
_LARGEST = 2e4                # kg m2
_SHORTEST, _LONGEST = 0.5, 1.5    # of a sample's interval, between samples that are held against each other


class DriveInertia:
    """noise: N m, of one sample of torque; interval: s between samples."""

    def __init__(self, noise: float, interval: float):
        self._variance = 2.0 * max(noise, 1.0) ** 2
        self._interval = interval
        self._information: NDArray[np.float64] = np.diag([one**-2 for one in _PRIOR])
        self._told: NDArray[np.float64] = np.zeros(2)
        self._last = (math.nan, math.nan, math.nan)   # rad/s, rad/s2, N m
        self.inertia = 0.0        # kg m2, 0 where none shows

    def pipe_torque(self, speed: float, torque: float, step: float) -> float:
        """The torque (N m) that the pipe takes, of one sample: speed of the drive rad/s, torque as read N m (NaN where
        there is none), s since the sample before."""
        before, self._last = self._last, (speed, math.nan, torque)
        if not _SHORTEST * self._interval < step < _LONGEST * self._interval:
            return torque
        acceleration = (speed - before[0]) / step
        self._last = (speed, acceleration, torque)
        row = np.array([acceleration - before[1], speed - before[0]])
        change = torque - before[2]
        if math.isfinite(change) and _SHARP < abs(row[0]) < _ABSURD:
            self._learn(row, change)
        return torque - self.inertia * acceleration if abs(acceleration) < _ABSURD else torque

    def _learn(self, row: NDArray[np.float64], change: float) -> None:
        self._information += np.outer(row, row) / self._variance
        self._told += row * change / self._variance
        covariance = np.linalg.inv(self._information)
        mean = float((covariance @ self._told)[0])
        sure = mean > _SURE * math.sqrt(float(covariance[0, 0]))
        self.inertia = min(mean, _LARGEST) if sure else 0.0
