"""Motion of the top drive while it was not logged: the single change of speed that joins what is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.sample_gaps import gap_indices

_MAX_INTERVAL_S = 0.25  # between samples; beyond it they do not show a reversal, or a wave in the string
_SAME_SPEED = 1e-6  # rad/s
_MIN_SPACING_S = 1e-4  # between two times of one motion
# Differences of the logarithms of two changes of speed: below the first they are similar, below the second equal.
_SIMILAR, _EQUAL = float(np.log(2.0)), 0.1


def fill_drive_gaps(time: Array, angle: Array, speed: Array, max_acceleration: float) -> tuple[Array, Array, Array]:
    """The samples of a top drive, with corners of the motion added in gaps and between samples that are far apart.

    A cubic through a missing reversal would cut its peak in half, and friction remembers how far the string was
    wound. A drive instead changes from one constant speed to another. Given the speeds at both ends of a gap, there is
    one moment for that change which leads to the angle at the end.

    The change takes as long as the logged changes of speed of similar size; where there is none, as the log's fastest;
    where none was logged at all, as the drive's limit allows. A motion that no single change explains keeps the cubic.

    Args:
        time, angle, speed: s, rad and rad/s, (n,).
        max_acceleration: Limit of the drive, rad/s2.

    Returns:
        Time, angle and speed with the corners, (m,) each; the arrays themselves where nothing was added.
    """
    hidden = hidden_speed_changes(time, speed)
    corners: list[tuple[float, float, float]] = []
    if hidden.size:
        sizes, slopes = _logged_changes(time, speed, hidden)
        if sizes.size == 0:
            sizes, slopes = _changes_through_one_sample(time, angle, speed)
        if sizes.size == 0:
            sizes, slopes = np.ones(1), np.full(1, max_acceleration)
        for index in hidden:
            ends = slice(index, index + 2)
            corners += _corners(time[ends], angle[ends], speed[ends], sizes, slopes)
    if not corners:
        return time, angle, speed
    whole = np.vstack([np.column_stack([time, angle, speed]), corners])
    rows = whole[np.argsort(whole[:, 0])]
    return rows[:, 0], rows[:, 1], rows[:, 2]


def is_undersampled(time: Array) -> bool:
    """Whether samples (n,) are so far apart that a drive can reverse, or a pump change its flow, between two."""
    return bool(time.size > 1 and np.median(np.diff(time)) > _MAX_INTERVAL_S)


def hidden_speed_changes(time: Array, speed: Array) -> NDArray[np.int_]:
    """Indices of the samples (n,) after which the speed may have changed unseen.

    These are the gaps. In undersampled records they are all samples, except where the speed was changing before and
    still is after, at least half as fast: there the change is visible.
    """
    if not is_undersampled(time):
        return gap_indices(time)
    slopes = np.diff(speed) / np.diff(time)
    before, after = np.r_[0.0, slopes[:-1]], np.r_[slopes[1:], 0.0]
    return np.flatnonzero(np.minimum(before * slopes, after * slopes) <= 0.5 * slopes**2)


def _logged_changes(time: Array, speed: Array, hidden: NDArray[np.int_]) -> tuple[Array, Array]:
    """Size (rad/s) and largest slope (rad/s2) of every monotonic change of speed, (k,); none across a hidden one."""
    steps = np.diff(speed)
    direction = np.sign(steps)
    direction[hidden] = 0.0
    first = np.flatnonzero(np.diff(direction, prepend=np.nan) != 0.0)
    sizes = np.abs(np.add.reduceat(steps, first))
    slopes = np.maximum.reduceat(np.abs(steps / np.diff(time)), first)
    real = (direction[first] != 0.0) & (sizes > _SAME_SPEED)
    return sizes[real], slopes[real]


def _changes_through_one_sample(time: Array, angle: Array, speed: Array) -> tuple[Array, Array]:
    """As `_logged_changes`, for changes during which a single sample was taken.

    Angle and speed at that sample give the start of the change, since the motion before it is even, and its end, since
    the motion after it is. It counts as one change where its slope is similar on both sides of the sample.
    """
    length, turned, change = np.diff(time), np.diff(angle), np.diff(speed)
    first, second = change[:-1], change[1:]
    met = np.flatnonzero(first * second > _SAME_SPEED**2)
    first, second = first[met], second[met]
    elapsed = 2.0 * (turned[met] - speed[met] * length[met]) / first
    remaining = 2.0 * (speed[met + 2] * length[met + 1] - turned[met + 1]) / second
    inside = (elapsed > 0.0) & (elapsed < length[met]) & (remaining > 0.0) & (remaining < length[met + 1])
    slope_before, slope_after = first / np.where(inside, elapsed, 1.0), second / np.where(inside, remaining, 1.0)
    single = inside & (np.abs(np.log(slope_before / slope_after)) < _SIMILAR)
    sizes = np.abs(first + second)[single]
    return sizes, sizes / (elapsed + remaining)[single]


def _corners(time: Array, angle: Array, speed: Array, sizes: Array, slopes: Array) -> list[tuple[float, float, float]]:
    """Start and end (s, rad, rad/s) of the change of speed between two samples; sizes, slopes: of logged changes."""
    length, change = float(time[1] - time[0]), float(speed[1] - speed[0])
    if abs(change) < _SAME_SPEED:
        return []
    # The two even motions, extended, meet in the middle of the change.
    middle = (float(angle[1] - angle[0]) - speed[1] * length) / -change
    if not 0.0 <= middle <= length:
        return []
    difference = np.abs(np.log(sizes / abs(change)))
    nearest = float(difference.min())
    slope = float(np.median(slopes[difference < nearest + _EQUAL]) if nearest < _SIMILAR else slopes.max())
    half = max(min(0.5 * abs(change) / slope, middle, length - middle), _MIN_SPACING_S)
    begin, end = middle - half, middle + half
    corners = [
        (time[0] + begin, angle[0] + speed[0] * begin, speed[0]),
        (time[0] + end, angle[1] - speed[1] * (length - end), speed[1]),
    ]
    return [corner for corner in corners if time[0] + _MIN_SPACING_S < corner[0] < time[1] - _MIN_SPACING_S]
