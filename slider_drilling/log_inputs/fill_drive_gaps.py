"""What a top drive did while its motion was not logged: the one change of speed that joins what is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.sample_gaps import gap_indices

_SELDOM_S = 0.25  # between samples, longer than which a reversal, or a wave in the string, does not show in them
_SAME = 1e-6  # rad/s
_SHORTEST = 1e-4  # s, between two times of one motion
_ALIKE, _EQUAL = float(np.log(2.0)), 0.1  # of the logarithms of two changes of speed


def fill_drive_gaps(time: Array, angle: Array, speed: Array, steepest: float) -> tuple[Array, Array, Array]:
    """The samples (n,), s, rad, rad/s, and where some were lost, or come too seldom, the corners of the motion between.

    A cubic through a lost reversal cuts its peak in half, and friction remembers how far the string was wound. A drive
    changes from one even speed to another instead: between the speeds at both ends there is one moment at which that
    gives the angle at the end. It takes as long as the logged changes of speed that are most like it, or as the log's
    fastest where none is, or as steepest (rad/s2) allows where none was met; a motion that no single change explains
    is left to the cubic.
    """
    hidden, found = hidden_speed_changes(time, speed), []
    if hidden.size:
        sizes, slopes = _logged_changes(time, speed, hidden)
        if sizes.size == 0:
            sizes, slopes = _changes_met(time, angle, speed)
        if sizes.size == 0:
            sizes, slopes = np.ones(1), np.full(1, steepest)
        for index in hidden:
            ends = slice(index, index + 2)
            found += _corners(time[ends], angle[ends], speed[ends], sizes, slopes)
    if not found:
        return time, angle, speed
    whole = np.vstack([np.column_stack([time, angle, speed]), found])
    rows = whole[np.argsort(whole[:, 0])]
    return rows[:, 0], rows[:, 1], rows[:, 2]


def is_undersampled(time: Array) -> bool:
    """Whether a rig does things between two samples (n,): a drive turns round, a pump is set to another flow."""
    return bool(time.size > 1 and np.median(np.diff(time)) > _SELDOM_S)


def hidden_speed_changes(time: Array, speed: Array) -> NDArray[np.int_]:
    """Indices of the samples (n,) after which the speed may have become another unseen: where some were lost, and where
    they come too seldom after each unless the speed was changing before and still is behind, half as fast at least.
    """
    if not is_undersampled(time):
        return gap_indices(time)
    slopes = np.diff(speed) / np.diff(time)
    before, behind = np.r_[0.0, slopes[:-1]], np.r_[slopes[1:], 0.0]
    return np.flatnonzero(np.minimum(before * slopes, behind * slopes) <= 0.5 * slopes**2)


def _logged_changes(time: Array, speed: Array, gone: NDArray[np.int_]) -> tuple[Array, Array]:
    """(k,) rad/s by how much the speed changed in one go, and (k,) rad/s2 how steeply at most; none over a loss."""
    steps = np.diff(speed)
    way = np.sign(steps)
    way[gone] = 0.0
    first = np.flatnonzero(np.diff(way, prepend=np.nan) != 0.0)
    sizes = np.abs(np.add.reduceat(steps, first))
    slopes = np.maximum.reduceat(np.abs(steps / np.diff(time)), first)
    real = (way[first] != 0.0) & (sizes > _SAME)
    return sizes[real], slopes[real]


def _changes_met(time: Array, angle: Array, speed: Array) -> tuple[Array, Array]:
    """As `_logged_changes`, of changes that a single sample met on their way.

    Angle and speed there say when the change had begun, given the even motion before it, and when it ended, given that
    behind it: where it was one change, as steep on both sides.
    """
    length, turned, change = np.diff(time), np.diff(angle), np.diff(speed)
    first, second = change[:-1], change[1:]
    met = np.flatnonzero(first * second > _SAME**2)
    first, second = first[met], second[met]
    begun = 2.0 * (turned[met] - speed[met] * length[met]) / first
    to_come = 2.0 * (speed[met + 2] * length[met + 1] - turned[met + 1]) / second
    inside = (begun > 0.0) & (begun < length[met]) & (to_come > 0.0) & (to_come < length[met + 1])
    before, behind = first / np.where(inside, begun, 1.0), second / np.where(inside, to_come, 1.0)
    one = inside & (np.abs(np.log(before / behind)) < _ALIKE)
    sizes = np.abs(first + second)[one]
    return sizes, sizes / (begun + to_come)[one]


def _corners(time: Array, angle: Array, speed: Array, sizes: Array, slopes: Array) -> list[tuple[float, float, float]]:
    """Where the speed begins and ends to change between two samples, (s, rad, rad/s) each."""
    length, change = float(time[1] - time[0]), float(speed[1] - speed[0])
    if abs(change) < _SAME:
        return []
    # The middle of the change, by where both even motions meet.
    middle = (float(angle[1] - angle[0]) - speed[1] * length) / -change
    if not 0.0 <= middle <= length:
        return []
    unlike = np.abs(np.log(sizes / abs(change)))
    nearest = float(unlike.min())
    slope = float(np.median(slopes[unlike < nearest + _EQUAL]) if nearest < _ALIKE else slopes.max())
    half = max(min(0.5 * abs(change) / slope, middle, length - middle), _SHORTEST)
    begin, end = middle - half, middle + half
    corners = [
        (time[0] + begin, angle[0] + speed[0] * begin, speed[0]),
        (time[0] + end, angle[1] - speed[1] * (length - end), speed[1]),
    ]
    return [corner for corner in corners if time[0] + _SHORTEST < corner[0] < time[1] - _SHORTEST]
