"""One motion from two measurements of it: a position and a speed that do not quite agree."""

from __future__ import annotations

import numpy as np
from scipy.integrate import cumulative_trapezoid

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.sample_gaps import gap_indices

# Samples over which errors of a speed add up and those of a position do not.
_LONGER = 8
_LEAST = 2 * _LONGER  # of such stretches, fewer of which tell nothing
_MEDIAN_TO_VARIANCE = 2.198  # of squares that are normally distributed
# Passes in which a speed that is pushed hard at times is found; of how many normal draws its spread is known.
_PASSES, _TAIL = 4, 4.0
_MULTIPLE = 1e-3  # of a step, by which a multiple of it may be off
_BULK = 0.99  # of all samples, the rest being what a log may hold once
_STIFFEST = 1e-6  # of the errors' square, that the speed spreads at least: such a motion remembers thirty samples
_CLOSEST = 0.01  # of the usual step, between two samples that no motion need be told between
_EXACT = 1e-4  # of the common way between two samples: nobody calls that a disagreement


def fuse_position_and_speed(time: Array, position: Array, speed: Array) -> tuple[Array, Array]:
    """Position and speed (n,) at times s, (n,), ascending, as they are likeliest given both; as they are where they
    agree as well as those of a smooth motion do: then the arrays that were given.

    An encoder of a degree steps by a tenth of a radian a second from one sample to the next, and a string between a
    cubic through such steps takes and gives hundreds of N m. Each measurement has a white error, the speed is a Wiener
    process between samples (of which such a cubic is the likeliest path when both are exact). How large the errors are
    is told by how far the position goes beyond the speed's integral from one sample to the next, and over some samples:
    errors of the speed add up, those of the position do not. The spread of the speed is what the log's own changes by,
    without its error. Stretches between lost samples are taken by themselves. A log that is too short, or of which two
    samples come at next to the same time, is left as it is.
    """
    steps = np.diff(time)
    usual = float(np.median(steps)) if steps.size else 0.0
    stretches = np.split(np.arange(time.size), gap_indices(time) + 1)
    beyond = [_beyond(time[one], position[one], speed[one]) for one in stretches]
    pairs = np.concatenate([np.diff(one) for one in beyond])
    over = np.concatenate([one[_LONGER:] - one[:-_LONGER] for one in beyond])
    changes = np.concatenate([np.diff(speed[one]) for one in stretches])
    common = float(np.mean(np.abs(speed)))
    if over.size < _LEAST or common == 0.0 or float(steps.min()) < _CLOSEST * usual:
        return position, speed
    near, far, rounded = _variance(pairs), _variance(over), quantisation_step(position) ** 2 / 12.0
    exact = (_EXACT * common * usual) ** 2
    even = _variance(changes)
    # An even motion may be a whole number of steps a sample: then only where it slips by one do they show.
    coarse = float(np.quantile(pairs**2, _BULK)) > rounded > exact
    if max(near, far) <= max(even * usual**2 / 12.0, exact) and not coarse:
        return position, speed
    adds_up = max(far - max(near, 2.0 * rounded), 0.0) / ((_LONGER - 0.5) * usual**2)
    errs = max(adds_up, quantisation_step(speed) ** 2 / 12.0, exact / usual**2)
    spread = max(float(np.mean(changes**2)) - min(2.0 * errs, even), _STIFFEST * near / usual**2) / usual
    sigmas = np.sqrt(max(0.5 * near - 0.25 * errs * usual**2, rounded, exact)), np.sqrt(errs)
    found = [_likeliest(time[one], position[one], speed[one], sigmas, spread) for one in stretches]
    return np.concatenate([own for own, _ in found]), np.concatenate([own for _, own in found])


def _beyond(time: Array, position: Array, speed: Array) -> Array:
    """(n,) how far a position has gone beyond the integral of its speed since the first sample."""
    return np.asarray(position - position[:1] - cumulative_trapezoid(speed, time, initial=0.0))


def _variance(values: Array) -> float:
    """Of the bulk of values about 0: corners of a motion are no errors."""
    return _MEDIAN_TO_VARIANCE * float(np.median(values**2))


def quantisation_step(values: Array) -> float:
    """The step that values (n,) are all multiples of, 0 where they are of none."""
    apart = np.diff(np.unique(values))
    least = 1e-9 * np.max(np.abs(values), initial=0.0)
    step, left = np.inf, apart[apart > least]
    while left.size:
        # Their greatest common divisor, as Euclid has it.
        step = float(left.min())
        left = np.abs(apart - step * np.round(apart / step))
        left = left[left > max(_MULTIPLE * step, least)]
    return step if step < np.inf and step > _MULTIPLE * float(np.median(apart)) else 0.0


def _likeliest(
    time: Array, position: Array, speed: Array, sigmas: tuple[float, float], spread: float
) -> tuple[Array, Array]:
    """Position and speed (n,) that minimise the squares of what they miss of the measurements, in their sigmas, and of
    what pushes the speed: one that is pushed harder than by this spread at times is given more of it there.
    """
    if time.size < 2:
        return position, speed
    step, given = np.diff(time), np.full(time.size - 1, spread)
    found = position, speed
    for _ in range(_PASSES):
        found = _smoothed(step, position, speed, sigmas, given)
        way = np.diff(found[0]) - found[1][:-1] * step
        change = np.diff(found[1])
        pushed = 12.0 * way**2 / step**3 - 12.0 * way * change / step**2 + 4.0 * change**2 / step
        given = spread * np.maximum((_TAIL + pushed / spread) / (_TAIL + 2.0), 1.0)
    return found


def _smoothed(
    step: Array, position: Array, speed: Array, sigmas: tuple[float, float], spread: Array
) -> tuple[Array, Array]:
    """The same for a spread (n - 1,) of each step s."""
    from scipy.linalg import solveh_banded  # whoever asks for it waits

    # Of the two unknowns at each end of a step: the stiffness of a beam, which bends as such a path does.
    far, cross, own = 12.0 / (spread * step**3), 6.0 / (spread * step**2), 4.0 / (spread * step)
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
    solved = solveh_banded(bands, measured, lower=True)
    return solved[0::2], solved[1::2]
