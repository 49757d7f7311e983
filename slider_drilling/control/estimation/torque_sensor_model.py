"""Torque-sensor model: the lag of the reading, and the inertia of the drive in it.

When the drive changes its speed by dv, the torque of the pipe changes immediately by ``Z dv``, with Z the torsional
wave impedance of the pipe, and then slowly as friction reverses along the string. A sensor with a lag shows this
late. A torque that is read at the drive's motor also jumps at each reversal, by ``J a`` with the acceleration a. From
one sample to the next,

    d(torque) = Z d(v') + J d(a') + r side',

where primes denote a first-order lag. Lag and J are those that leave the smallest squared residual. J stays zero where
a lag alone explains the readings nearly as well.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_LAGS: Array = np.array([1e-3, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0])   # s, candidates
_LAG_PRIOR = 0.4            # s, scale of the prior around the rig file's lag
_CORRELATED_SAMPLES = 6.0   # samples that count as one: friction repeats in each stroke
_INERTIA_THRESHOLD = 0.6    # of the squared residual of a lag alone, below which the inertia is accepted
_NOISE_SAMPLES = 10.0       # samples whose noise variance the improvement must exceed
_UPDATE_INTERVAL = 5        # samples between two evaluations of the lags
_REVERSAL_SPEED = 0.3       # rad/s, scale over which friction reverses
_MAX_ACCELERATION = 1e3     # rad/s2 (and rad/s); no drive exceeds it
_MAX_INERTIA = 2e4          # kg m2
_MIN_STEP, _MAX_STEP = 0.5, 1.5   # of the sample interval, between samples that are compared
_TINY = 1e-9


class TorqueSensorModel:
    """Estimates lag and inertia of a torque reading, and takes the inertia out.

    Args:
        impedance: Torsional wave impedance of the uppermost pipe, N m s/rad.
        noise: One standard deviation of one torque sample, N m.
        interval: Time between samples, s.
        lag: Of the sensor by the rig file, s.

    Attributes:
        inertia: Of the drive in the reading, kg m2; 0 where none shows.
        lag: Posterior mean, s.
        most_likely_lag: s.
    """

    def __init__(self, impedance: float, noise: float, interval: float, lag: float = 0.0):
        self.impedance = impedance
        self._variance = 2.0 * max(noise, 1.0) ** 2
        self.interval = interval
        self._log_prior = -np.abs(_LAGS - lag) / _LAG_PRIOR
        self._lagged = np.zeros((3, len(_LAGS)))   # speed rad/s, acceleration rad/s2, side: after each lag
        # Normal equations of the regression on J and r, for each lag.
        self._squares = np.zeros((2, 2, len(_LAGS)))
        self._products = np.zeros((2, len(_LAGS)))      # with the residual of Z
        self._residual = np.zeros(len(_LAGS))           # sum of its squares, N2 m2
        self._count = 0
        self._last = (math.nan, math.nan)   # rad/s, N m
        self._acceleration_known = False    # of the sample before
        self._index = 0                     # of the most likely lag
        self.inertia = 0.0
        self.most_likely_lag = float(_LAGS[self._log_prior.argmax()])
        self.lag = float(np.exp(self._log_prior) @ _LAGS / np.exp(self._log_prior).sum())

    def pipe_torque(self, speed: float, torque: float, step: float) -> float:
        """Take one sample and return the torque of the pipe, `lag` s ago.

        Args:
            speed: Of the drive, rad/s.
            torque: Reading, N m; NaN where unknown.
            step: Time since the last sample, s.

        Returns:
            N m.
        """
        if step <= 0.0:
            return torque
        before, self._last = self._last, (speed, torque)
        acceleration = (speed - before[0]) / step
        regular = _MIN_STEP * self.interval < step < _MAX_STEP * self.interval
        if not (regular and abs(acceleration) < _MAX_ACCELERATION):
            self._lagged[:] = 0.0
            self._lagged[0] = self.speed
            self._acceleration_known = False
            return torque
        changes = self._advance_lags(before[0], speed, acceleration, step)
        change = torque - before[1]
        known, self._acceleration_known = self._acceleration_known, True
        if known and math.isfinite(change):
            self._learn(changes, change, step)
        return torque - self.inertia * float(self._lagged[1, self._index])

    @property
    def speed(self) -> float:
        """Speed of the drive at the last sample, rad/s; 0 where that is implausible."""
        return self._last[0] if abs(self._last[0]) < _MAX_ACCELERATION else 0.0

    def torque_from_below(self, torque: float) -> float:
        """The pipe's torque (N m) less ``Z v``: the part that arrives from below, `lag` s ago."""
        return torque - self.impedance * float(self._lagged[0, self._index])

    def _advance_lags(self, before: float, speed: float, acceleration: float, step: float) -> Array:
        """Advance each first-order lag by a step in which the speed is linear; returns the three changes."""
        decay, old = np.exp(-step / _LAGS), self._lagged
        delay = acceleration * _LAGS   # steady difference between a ramp and its lagged value
        side = math.tanh(speed / _REVERSAL_SPEED)
        self._lagged = np.array([speed - delay - (before - delay - old[0]) * decay,
                                 acceleration + (old[1] - acceleration) * decay, side + (old[2] - side) * decay])
        return self._lagged - old

    def _learn(self, changes: Array, change: float, step: float) -> None:
        rows = np.array([changes[1], self._lagged[2] * step])
        residual = change - self.impedance * changes[0]
        self._squares += rows[:, None, :] * rows[None, :, :]
        self._products += rows * residual
        self._residual += residual * residual
        self._count += 1
        if self._count % _UPDATE_INTERVAL == 0:
            self._evaluate()

    def _evaluate(self) -> None:
        """Solve the regression for each lag, decide on the inertia, and weight the lags."""
        squares_j, cross, squares_r = self._squares[0, 0], self._squares[0, 1], self._squares[1, 1]
        lag_only = self._residual - self._products[1] ** 2 / np.maximum(squares_r, _TINY)
        # Frisch-Waugh: regress on J after r has been taken out of both sides.
        partial_squares = np.maximum(squares_j - cross**2 / np.maximum(squares_r, _TINY), _TINY)
        partial_product = self._products[0] - cross * self._products[1] / np.maximum(squares_r, _TINY)
        inertia = np.clip(partial_product / partial_squares, 0.0, _MAX_INERTIA)
        with_inertia = lag_only - inertia * (2.0 * partial_product - inertia * partial_squares)
        accepted = float(with_inertia.min()) + _NOISE_SAMPLES * self._variance < (
            _INERTIA_THRESHOLD * float(lag_only.min()))
        squares = with_inertia if accepted else lag_only
        variance = max(float(squares.min()) / self._count, self._variance) * _CORRELATED_SAMPLES
        weight = self._log_prior - 0.5 * (squares - squares.min()) / variance
        weight = np.exp(weight - weight.max())
        self._index = int(weight.argmax())
        self.most_likely_lag = float(_LAGS[self._index])
        self.lag = float(weight @ _LAGS / weight.sum())
        self.inertia = float(inertia[self._index]) if accepted else 0.0
