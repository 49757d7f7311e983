"""Histogram filter on the circle: the probability of each degree of an angle, independent of whole turns."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_BINS = 360
_NEIGHBOURHOOD = math.radians(40.0)   # around the mode, for its mean and standard deviation
_CENTRES = (np.arange(_BINS) + 0.5) * (2.0 * math.pi / _BINS) - math.pi
_ORDERS = np.arange(_BINS // 2 + 1)


class CircularHistogram:
    """Probability of an angle, uniform at first.

    Args:
        outliers: Share of samples that may be any angle; it keeps some probability everywhere.

    Attributes:
        mean: Around the mode, rad.
        sigma: One standard deviation around the mode, rad.
        weight: Probability that the angle lies around the mode.
    """

    def __init__(self, outliers: float):
        self._outliers = outliers
        self._probability = np.full(_BINS, 1.0 / _BINS)
        self.mean = 0.0
        self.sigma = math.pi / math.sqrt(3.0)   # of the uniform distribution
        self.weight = 0.0

    def diffuse(self, variance: float) -> None:
        """Prediction step: convolve with a normal distribution of this variance (rad2)."""
        waves = np.fft.rfft(self._probability) * np.exp(-0.5 * _ORDERS**2 * variance)
        self._probability = np.maximum(np.fft.irfft(waves, _BINS), 0.0)
        self._summarise()

    def update(self, angle: float, variance: float) -> None:
        """Bayes' rule for a sample (rad) of this variance (rad2) that may be an outlier."""
        normal = np.exp(-0.5 * _difference(angle) ** 2 / variance) / math.sqrt(2.0 * math.pi * variance)
        posterior = self._probability * (self._outliers / (2.0 * math.pi) + (1.0 - self._outliers) * normal)
        self._probability = posterior / posterior.sum()
        self._summarise()

    def _summarise(self) -> None:
        mode = float(_CENTRES[int(np.argmax(self._probability))])
        off = _difference(mode)
        near = np.where(np.abs(off) <= _NEIGHBOURHOOD, self._probability, 0.0)
        self.weight = float(near.sum() / self._probability.sum())
        shift = float((near * off).sum() / near.sum())
        self.mean = math.remainder(mode + shift, 2.0 * math.pi)
        self.sigma = math.sqrt(float((near * (off - shift) ** 2).sum() / near.sum()))


def _difference(angle: float) -> NDArray[np.float64]:
    """Each bin's centre minus `angle`, rad in [-pi, pi)."""
    return np.asarray((_CENTRES - angle + math.pi) % (2.0 * math.pi) - math.pi, dtype=np.float64)
