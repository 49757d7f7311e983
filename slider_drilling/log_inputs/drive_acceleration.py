"""How fast a top drive speeds up, told from the noise of its measured speed."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline, make_smoothing_spline

from slider_drilling.drillstring.kernel_arrays import Array

_TIMES_S = np.geomspace(0.002, 1.0, 19)  # s, over which a speed may be smoothed
_SAMPLES = 1000  # the busiest, by which the time is chosen
_LEAST = 12  # samples, below which none could be held out


def drive_acceleration(time: Array, speed: Array) -> Array:
    """Acceleration (n,), rad/s2, at times (n,), s, increasing, of a speed (n,), rad/s, that is measured with noise.

    The slope of a cubic smoothing spline. It is as smooth as makes two thirds of the samples foretell the others best:
    differences of measured speeds are mostly noise where samples are close together (at 50 Hz a noise of 0.007 rad/s is
    one of 0.5 rad/s2), and would drive the inertia that a fit finds in a torque towards zero.
    """
    if time.size < _LEAST:
        return np.gradient(speed, time) if time.size > 1 else np.zeros_like(speed)
    busiest = _busiest(speed)
    errors = [_foretold(time[busiest], speed[busiest], smoothed) for smoothed in _TIMES_S]
    return np.asarray(_spline(time, speed, float(_TIMES_S[int(np.argmin(errors))])).derivative()(time))


def _busiest(speed: Array) -> slice:
    """The stretch of samples in which the speed changes most."""
    changes = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(speed)))])
    if speed.size <= _SAMPLES:
        return slice(None)
    begin = int(np.argmax(changes[_SAMPLES:] - changes[:-_SAMPLES]))
    return slice(begin, begin + _SAMPLES)


def _foretold(time: Array, speed: Array, smoothed: float) -> float:
    """Squared error of every third sample by a spline through those between."""
    out = np.zeros(time.size, dtype=bool)
    out[1:-1:3] = True  # neither the first nor the last: each lies between samples that are kept
    return float(np.sum((_spline(time[~out], speed[~out], smoothed)(time[out]) - speed[out]) ** 2))


def _spline(time: Array, speed: Array, smoothed: float) -> BSpline:
    """Low-pass of fourth order with this time constant, s: a penalty of its fourth power per interval of samples."""
    interval = (time[-1] - time[0]) / (time.size - 1)
    return make_smoothing_spline(time, speed, lam=smoothed**4 / interval)
