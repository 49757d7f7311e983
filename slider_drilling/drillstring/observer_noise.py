"""What the noise of measured torque does through an observer: it shakes the simulated drive.

A drive that shakes frees its string from friction. So the observer smooths what it feeds back, as long as the
noise needs.
"""

from __future__ import annotations

import math

from slider_drilling.drillstring.assemble import common_mesh
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import torsional_impedance

_SHAKEN = 0.02  # rad/s RMS by which noise may shake the drive; at 0.03 fitted friction is 5 to 7 % too large


def needed_smoothing(rig: Rig, noise: float, interval: float, gain: float) -> float:
    """Smoothing of an observer, s, that keeps the noise from freeing the string.

    White noise passes a lag of T with the variance ``noise^2 interval / (2 T)``.

    Args:
        rig: The rig; its string's wave impedance says how far a torque turns the drive.
        noise: Standard deviation of the torque's noise, N m.
        interval: s between two samples.
        gain: See `Observer`.
    """
    impedance = torsional_impedance(rig, common_mesh([rig], 2))
    return 0.5 * interval * (gain * noise / (impedance * _SHAKEN)) ** 2


def noise_shrinkage(gain: float, smoothing: float, interval: float) -> float:
    """Factor, 1 to 1 + gain, by which an observer shrinks white noise in the error of the torque.

    The string answers a turn of its drive with its wave impedance, so the error is the noise times
    ``(1 + s T) / (1 + gain + s T)``; its power is the mean up to half the sampling rate.

    Args:
        gain, smoothing: See `Observer`.
        interval: s between two samples.
    """
    whole = 1.0 + gain
    if smoothing <= 0.0:
        return whole
    highest = math.pi * smoothing / (interval * whole)
    return 1.0 / math.sqrt(1.0 - (1.0 - 1.0 / whole**2) * math.atan(highest) / highest)
