"""What a torque reading is beside the pipe's torque: how late it comes, and what speeds the drive itself up.

When the drive changes its speed by dv, the torque that the pipe takes changes at once by ``Z dv``, Z the pipe's wave
impedance, and then slowly as friction turns over along the string. A sensor that lags shows that late. A torque that is
read at the drive's motor leaps at each reversal by ``J a`` with the acceleration a, too. From one sample to the next,

    d(torque) = Z d(v') + J d(a') + r side',

primes for what has passed a lag of the first order. Lag and J are those that leave least of what is read; J is nothing
where a lag alone does nearly as well.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_LAGS: Array = np.array([1e-3, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0])   # s, that are held against each other
_EXPECTED = 0.4             # s, by which a lag is believed to be off the rig file's
_ALIKE = 6.0                # samples that are worth one: what friction does repeats in each stroke
_SURE = 0.6                 # of the squares that a lag alone leaves, below which the drive's inertia is believed
_FEW = 10.0                 # samples, whose noise says nothing
_EVERY = 5                  # samples, after which the lags are weighed again
_TURNS = 0.3                # rad/s, about which friction turns over
_ABSURD = 1e3               # rad/s2, that no drive makes
_LARGEST = 2e4              # kg m2
_SHORTEST, _LONGEST = 0.5, 1.5    # of a sample's interval, between samples that are held against each other


class TorqueSensorModel:
    """impedance: N m s/rad, of the uppermost pipe; noise: N m, of one sample of torque; interval: s between samples;
    lag: s, of the sensor as the rig file has it."""

    def __init__(self, impedance: float, noise: float, interval: float, lag: float = 0.0):
        self.impedance = impedance
        self._variance = 2.0 * max(noise, 1.0) ** 2
        self.interval = interval
        self._prior = -np.abs(_LAGS - lag) / _EXPECTED
        self._passed = np.zeros((3, len(_LAGS)))   # speed rad/s, acceleration rad/s2, side: through each lag
        self._squares = np.zeros((2, 2, len(_LAGS)))   # of the changes that J and r go with
        self._products = np.zeros((2, len(_LAGS)))     # ... with what Z leaves
        self._left = np.zeros(len(_LAGS))              # squares of that, N2 m2
        self._count = 0
        self._last = (math.nan, math.nan)   # rad/s, N m
        self._accelerated = False    # whether the acceleration of the sample before is known
        self._picked = 0
        self.inertia = 0.0        # kg m2, 0 where none shows
        self.likeliest_lag = float(_LAGS[self._prior.argmax()])   # s
        self.lag = float(np.exp(self._prior) @ _LAGS / np.exp(self._prior).sum())   # s

    def pipe_torque(self, speed: float, torque: float, step: float) -> float:
        """The torque (N m) that the pipe takes, `lag` s ago, of one sample: speed of the drive rad/s, torque as read
        N m (NaN where there is none), s since the sample before."""
        if step <= 0.0:
            return torque
        before, self._last = self._last, (speed, torque)
        acceleration = (speed - before[0]) / step
        if not (_SHORTEST * self.interval < step < _LONGEST * self.interval and abs(acceleration) < _ABSURD):
            self._passed[:] = 0.0
            self._passed[0] = self.speed
            self._accelerated = False
            return torque
        changes = self._pass(before[0], speed, acceleration, step)
        change = torque - before[1]
        known, self._accelerated = self._accelerated, True
        if known and math.isfinite(change):
            self._learn(changes, change, step)
        return torque - self.inertia * float(self._passed[1, self._picked])

    @property
    def speed(self) -> float:
        """rad/s, of the drive at the last sample, 0 where there is none that a drive could have."""
        return self._last[0] if abs(self._last[0]) < _ABSURD else 0.0

    def torque_from_below(self, torque: float) -> float:
        """What of the pipe's torque (N m) is there whatever the drive does now: all but ``Z v``, `lag` s ago."""
        return torque - self.impedance * float(self._passed[0, self._picked])

    def _pass(self, before: float, speed: float, acceleration: float, step: float) -> Array:
        """Take a step through each lag, the speed a straight line; returns by how much the three have changed."""
        kept, old = np.exp(-step / _LAGS), self._passed
        follows = acceleration * _LAGS   # by which a lagging speed stays behind one that rises steadily
        side = math.tanh(speed / _TURNS)
        self._passed = np.array([speed - follows - (before - follows - old[0]) * kept,
                                 acceleration + (old[1] - acceleration) * kept, side + (old[2] - side) * kept])
        return self._passed - old

    def _learn(self, changes: Array, change: float, step: float) -> None:
        rows = np.array([changes[1], self._passed[2] * step])
        beyond = change - self.impedance * changes[0]
        self._squares += rows[:, None, :] * rows[None, :, :]
        self._products += rows * beyond
        self._left += beyond * beyond
        self._count += 1
        if self._count % _EVERY == 0:
            self._weigh()

    def _weigh(self) -> None:
        leap, both, slow = self._squares[0, 0], self._squares[0, 1], self._squares[1, 1]
        without = self._left - self._products[1] ** 2 / np.maximum(slow, 1e-9)
        alone = np.maximum(leap - both**2 / np.maximum(slow, 1e-9), 1e-9)
        told = self._products[0] - both * self._products[1] / np.maximum(slow, 1e-9)
        inertia = np.clip(told / alone, 0.0, _LARGEST)
        beside = without - inertia * (2.0 * told - inertia * alone)
        sure = float(beside.min()) + _FEW * self._variance < _SURE * float(without.min())
        squares = beside if sure else without
        spread = max(float(squares.min()) / self._count, self._variance) * _ALIKE
        weight = self._prior - 0.5 * (squares - squares.min()) / spread
        weight = np.exp(weight - weight.max())
        self._picked = int(weight.argmax())
        self.likeliest_lag = float(_LAGS[self._picked])
        self.lag = float(weight @ _LAGS / weight.sum())
        self.inertia = float(inertia[self._picked]) if sure else 0.0
