"""What is believed of an angle: a probability for each degree of the circle, so that a turn more or less is all one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_BINS = 360
_AROUND = math.radians(40.0)   # of the most likely angle, what its mean and spread are taken from
_CENTRES = (np.arange(_BINS) + 0.5) * (2.0 * math.pi / _BINS) - math.pi
_ORDERS = np.arange(_BINS // 2 + 1)


class CircularHistogram:
    """Begins knowing nothing. outliers: the share of samples that may be any angle; it keeps a doubt everywhere."""

    def __init__(self, outliers: float):
        self._outliers = outliers
        self._probability = np.full(_BINS, 1.0 / _BINS)
        self.mean = 0.0                           # rad, of what lies around the most likely angle
        self.spread = math.pi / math.sqrt(3.0)    # rad, one standard deviation there
        self.weight = 0.0                         # probability that the angle lies there

    def diffuse(self, variance: float) -> None:
        """The angle may have moved since: variance in rad2."""
        waves = np.fft.rfft(self._probability) * np.exp(-0.5 * _ORDERS**2 * variance)
        self._probability = np.maximum(np.fft.irfft(waves, _BINS), 0.0)
        self._summarise()

    def update(self, angle: float, variance: float) -> None:
        """Bayes with a sample (rad, of this variance in rad2) that is an outlier now and then."""
        normal = np.exp(-0.5 * _apart(angle) ** 2 / variance) / math.sqrt(2.0 * math.pi * variance)
        posterior = self._probability * (self._outliers / (2.0 * math.pi) + (1.0 - self._outliers) * normal)
        self._probability = posterior / posterior.sum()
        self._summarise()

    def _summarise(self) -> None:
        mode = float(_CENTRES[int(np.argmax(self._probability))])
        off = _apart(mode)
        near = np.where(np.abs(off) <= _AROUND, self._probability, 0.0)
        self.weight = float(near.sum() / self._probability.sum())
        shift = float((near * off).sum() / near.sum())
        self.mean = math.remainder(mode + shift, 2.0 * math.pi)
        self.spread = math.sqrt(float((near * (off - shift) ** 2).sum() / near.sum()))


def _apart(angle: float) -> NDArray[np.float64]:
    """Each bin's centre less `angle`, rad in [-pi, pi)."""
    return np.asarray((_CENTRES - angle + math.pi) % (2.0 * math.pi) - math.pi, dtype=np.float64)
