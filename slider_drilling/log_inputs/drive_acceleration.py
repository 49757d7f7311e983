"""Acceleration of the top drive from its measured, noisy speed."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline, make_smoothing_spline

from slider_drilling.drillstring.kernel_arrays import Array

_TIME_CONSTANTS_S = np.geomspace(0.002, 1.0, 19)  # candidates for smoothing
_SAMPLES = 1000  # of the stretch on which the time constant is chosen
_MIN_SAMPLES = 12  # for cross-validation


def drive_acceleration(time: Array, speed: Array) -> Array:
    """Acceleration of a speed that is measured with noise: the slope of a cubic smoothing spline.

    Cross-validation chooses the smoothness: two thirds of the samples predict the others. Plain differences are mostly
    noise where samples are close together (at 50 Hz a noise of 0.007 rad/s becomes 0.5 rad/s2). A fit of the drive's
    inertia to measured torque would then be biased towards zero.

    Args:
        time: s, (n,), increasing.
        speed: rad/s, (n,).

    Returns:
        rad/s2, (n,).
    """
    if time.size < _MIN_SAMPLES:
        return np.gradient(speed, time) if time.size > 1 else np.zeros_like(speed)
    part = _most_varied(speed)
    errors = [_held_out_error(time[part], speed[part], constant) for constant in _TIME_CONSTANTS_S]
    return np.asarray(_spline(time, speed, float(_TIME_CONSTANTS_S[int(np.argmin(errors))])).derivative()(time))


def _most_varied(speed: Array) -> slice:
    """The stretch of samples in which the speed changes most."""
    changes = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(speed)))])
    if speed.size <= _SAMPLES:
        return slice(None)
    begin = int(np.argmax(changes[_SAMPLES:] - changes[:-_SAMPLES]))
    return slice(begin, begin + _SAMPLES)


def _held_out_error(time: Array, speed: Array, time_constant: float) -> float:
    """Squared error at every third sample of a spline through the others."""
    out = np.zeros(time.size, dtype=bool)
    out[1:-1:3] = True  # never the first or the last: the spline must not extrapolate
    return float(np.sum((_spline(time[~out], speed[~out], time_constant)(time[out]) - speed[out]) ** 2))


def _spline(time: Array, speed: Array, time_constant: float) -> BSpline:
    """A smoothing spline that acts as a fourth-order low-pass with this time constant, s."""
    interval = (time[-1] - time[0]) / (time.size - 1)
    return make_smoothing_spline(time, speed, lam=time_constant**4 / interval)
