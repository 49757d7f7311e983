"""One motion from two measurements of it: a position and a speed that do not quite agree."""

from __future__ import annotations

import numpy as np
from scipy.integrate import cumulative_trapezoid

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.sample_gaps import gap_indices

_SPAN = 8  # samples over which errors of a speed add up and those of a position do not
_MIN_SPANS = 2 * _SPAN  # fewer say nothing about the errors
_MEDIAN_TO_VARIANCE = 2.198  # of squares of normally distributed values
_PASSES, _TAIL = 4, 4.0  # of iterative reweighting; degrees of freedom of its heavy-tailed increments
_MULTIPLE_TOLERANCE = 1e-3  # of a step, for a multiple of it
_BULK = 0.99  # of all samples; the rest may be single events
_MIN_PROCESS_NOISE = 1e-6  # of the errors' variance: such a motion remembers thirty samples
_MIN_INTERVAL = 0.01  # of the usual interval; closer samples are not smoothed between
_NEGLIGIBLE = 1e-4  # of the usual way between two samples: no disagreement


def fuse_position_and_speed(time: Array, position: Array, speed: Array) -> tuple[Array, Array]:
    """Position and speed of highest likelihood given both measurements (Kalman smoother in batch form).

    An encoder of one degree jumps by a tenth of a radian a second from sample to sample. A string between a cubic
    through such jumps takes and gives hundreds of N m.

    Model: both measurements have white errors, and the speed is a Wiener process between samples (whose most likely
    path is a cubic where both are exact). The size of the errors follows from how far the position departs from the
    integral of the speed, from one sample to the next and over several: errors of the speed add up, those of the
    position do not. The process noise is how much the logged speed itself changes, less its error. Parts of a record
    between gaps are smoothed separately.

    Args:
        time: s, (n,), ascending.
        position, speed: In units whose ratio is 1/s, (n,).

    Returns:
        Position and speed. They are the given arrays themselves where both agree as well as those of a smooth motion
        do, where the record is too short, or where two samples come at almost the same time.
    """
    steps = np.diff(time)
    usual = float(np.median(steps)) if steps.size else 0.0
    parts = np.split(np.arange(time.size), gap_indices(time) + 1)
    departures = [_departure(time[part], position[part], speed[part]) for part in parts]
    pairs = np.concatenate([np.diff(row) for row in departures])
    spans = np.concatenate([row[_SPAN:] - row[:-_SPAN] for row in departures])
    changes = np.concatenate([np.diff(speed[part]) for part in parts])
    typical = float(np.mean(np.abs(speed)))
    if spans.size < _MIN_SPANS or typical == 0.0 or float(steps.min()) < _MIN_INTERVAL * usual:
        return position, speed
    near, far, rounding = _variance(pairs), _variance(spans), quantisation_step(position) ** 2 / 12.0
    negligible = (_NEGLIGIBLE * typical * usual) ** 2
    even = _variance(changes)
    # An even motion may be a whole number of quantisation steps a sample: steps then only show where it slips by one.
    coarse = float(np.quantile(pairs**2, _BULK)) > rounding > negligible
    if max(near, far) <= max(even * usual**2 / 12.0, negligible) and not coarse:
        return position, speed
    growth = max(far - max(near, 2.0 * rounding), 0.0) / ((_SPAN - 0.5) * usual**2)
    speed_variance = max(growth, quantisation_step(speed) ** 2 / 12.0, negligible / usual**2)
    position_variance = max(0.5 * near - 0.25 * speed_variance * usual**2, rounding, negligible)
    process_noise = (
        max(float(np.mean(changes**2)) - min(2.0 * speed_variance, even), _MIN_PROCESS_NOISE * near / usual**2) / usual
    )
    sigmas = np.sqrt(position_variance), np.sqrt(speed_variance)
    fused = [_smooth_robustly(time[part], position[part], speed[part], sigmas, process_noise) for part in parts]
    return np.concatenate([own for own, _ in fused]), np.concatenate([own for _, own in fused])


def quantisation_step(values: Array) -> float:
    """The step of which all values (n,) are multiples; 0 where there is none."""
    apart = np.diff(np.unique(values))
    least = 1e-9 * np.max(np.abs(values), initial=0.0)
    step, rest = np.inf, apart[apart > least]
    # Euclid's algorithm for the greatest common divisor, with tolerance.
    while rest.size:
        step = float(rest.min())
        rest = np.abs(apart - step * np.round(apart / step))
        rest = rest[rest > max(_MULTIPLE_TOLERANCE * step, least)]
    return step if step < np.inf and step > _MULTIPLE_TOLERANCE * float(np.median(apart)) else 0.0


def smooth_motion(
    step: Array, position: Array, speed: Array, sigmas: tuple[float, float], process_noise: Array
) -> tuple[Array, Array]:
    """Position and speed (n,) that minimise the squared misfit to both measurements and to the Wiener process.

    Args:
        step: s between samples, (n - 1,).
        position, speed: Measurements, (n,).
        sigmas: Standard deviations of the errors of position and speed.
        process_noise: Variance of the speed's increments per s, one a step, (n - 1,).
    """
    from scipy.linalg import solveh_banded  # slow to import, rarely needed

    # Each step couples position and speed at its two ends like the stiffness matrix of a beam, which bends as the most
    # likely path does.
    far, cross, own = 12.0 / (process_noise * step**3), 6.0 / (process_noise * step**2), 4.0 / (process_noise * step)
    bands = np.zeros((4, 2 * position.size))  # lower form: row d couples unknown k with k + d
    bands[0] = np.tile((sigmas[0] ** -2.0, sigmas[1] ** -2.0), position.size)
    for first, sign in ((0, 1.0), (2, -1.0)):  # the step's two ends
        inside = slice(first, first + 2 * step.size, 2)
        bands[0, inside] += far
        bands[0, first + 1 : first + 1 + 2 * step.size : 2] += own
        bands[1, inside] += sign * cross
    bands[1, 1:-1:2] = -cross
    bands[2, 0:-2:2], bands[2, 1:-2:2] = -far, 0.5 * own
    bands[3, 0:-2:2] = cross
    measured = np.column_stack([position / sigmas[0] ** 2, speed / sigmas[1] ** 2]).ravel()
    solution = solveh_banded(bands, measured, lower=True)
    return solution[0::2], solution[1::2]


def _smooth_robustly(
    time: Array, position: Array, speed: Array, sigmas: tuple[float, float], process_noise: float
) -> tuple[Array, Array]:
    """`smooth_motion` with iteratively reweighted process noise: more of it where the speed changes hard at times."""
    if time.size < 2:
        return position, speed
    step, noise = np.diff(time), np.full(time.size - 1, process_noise)
    motion = position, speed
    for _ in range(_PASSES):
        motion = smooth_motion(step, position, speed, sigmas, noise)
        way = np.diff(motion[0]) - motion[1][:-1] * step
        change = np.diff(motion[1])
        # Squared increment of the process over each step, from the way and the speed that it adds.
        increment = 12.0 * way**2 / step**3 - 12.0 * way * change / step**2 + 4.0 * change**2 / step
        noise = process_noise * np.maximum((_TAIL + increment / process_noise) / (_TAIL + 2.0), 1.0)
    return motion


def _departure(time: Array, position: Array, speed: Array) -> Array:
    """How far a position has departed from the integral of its speed since the first sample, (n,)."""
    return np.asarray(position - position[:1] - cumulative_trapezoid(speed, time, initial=0.0))


def _variance(values: Array) -> float:
    """Variance about 0 of the bulk of values: corners of a motion are not errors."""
    return _MEDIAN_TO_VARIANCE * float(np.median(values**2))
