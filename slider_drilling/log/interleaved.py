"""Distinguishes two publishers in one channel by their values: every so many samples are another one's.

A bag has one channel for all publishers of a topic, and most recorders number no messages. What is left are the values:
an angle that jumps away and back with nearly every sample is two angles, and so is a reading whose stamps alternate,
too, as those of two clocks do.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.log.timestamps import MAX_STEP_BACK, Array, StampedSamples

_MIN_SAMPLES = 20  # of the rarer publisher
_AWAY = 10.0  # an excursion is so many times longer than the step between its neighbours
_FAR = 0.1  # of the channel's range (5 to 95 %): the noise of a reading is less
_SHARE = 0.8  # of the gaps between excursions that are as long as usual
_USUAL = (0.6, 1.5)
_MIN_VALUES = 10  # different ones; a coarse number that changes between two levels has two
_FEW_ZEROS = 0.2  # of the values; a publisher of zeros has a rule of its own
_UNEVEN, _EVEN = 0.1, 0.05  # of two intervals: how much they differ in turn, and every other one at most


def keep_one_of_interleaved(
    track: StampedSamples, continuous: Sequence[int], topic: str, source: str, notes: list[str]
) -> StampedSamples:
    """The samples of one publisher; those of another one whose values never change are left out.

    Args:
        track: Samples of a topic in the order of the log.
        continuous: Columns that cannot jump: angles and positions.
        topic: Its name, for messages.
        source: The log, for messages.
        notes: Gets a sentence for what is left out.

    Raises:
        InputError: The values of both publishers change.
    """
    order = np.lexsort((track.logged, track.stamp))
    values, stamps = track.values[order], track.stamp[order]
    is_one_run = np.diff(track.stamp).min(initial=0) >= -MAX_STEP_BACK
    if not is_one_run or not _is_of_two(values, stamps, continuous):
        return track
    rows, inverse, counts = np.unique(np.nan_to_num(values), axis=0, return_inverse=True, return_counts=True)
    usual = int(counts.argmax())
    same = inverse.reshape(-1) == usual
    if counts[usual] < _MIN_SAMPLES or _is_of_two(values[~same], stamps[~same], continuous):
        raise InputError(
            f"{source}: {topic}: two publishers in one channel: its values jump away and back all along; "
            "record one of them, or each on a topic of its own"
        )
    if not rows[usual].any():
        return track  # zeros, which have a rule of their own
    notes.append(
        f"{topic}: {counts[usual]} samples that never change, between the others, were left out: a second publisher "
        "sends them"
    )
    return track.select(~(np.nan_to_num(track.values) == rows[usual]).all(axis=1))


def _is_of_two(values: Array, stamps: NDArray[np.int64], continuous: Sequence[int]) -> bool:
    """Whether samples (n, columns) in the order of their stamps (n,), ns, are two publishers' in turn.

    A reading may swing at half the sampling rate. An angle or a position does not, nor do two readings alike, nor does
    the clock of one publisher.
    """
    apart = {k for k in range(values.shape[1]) if _is_interleaved(values[:, k])}
    if apart & set(continuous) or len(apart) > 1:
        return True
    few_zeros = any(np.mean(values[:, k] == 0.0) < _FEW_ZEROS for k in apart)
    return few_zeros and _is_of_two_clocks(stamps)


def _is_of_two_clocks(stamps: NDArray[np.int64]) -> bool:
    """Whether short and long intervals alternate all along."""
    interval = np.diff(stamps).astype(np.float64)
    two = interval[:-1] + interval[1:]
    uneven = np.abs(np.diff(interval)) > _UNEVEN * two
    repeats = np.abs(interval[2:] - interval[:-2]) < _EVEN * two[1:]
    return bool(np.mean(uneven) > _SHARE and np.mean(repeats) > _SHARE)


def _is_interleaved(values: Array) -> bool:
    """Whether single values (n,), in the order of time, jump away and back all along, every so many samples."""
    value = values[np.isfinite(values)]
    if value.size < 3 * _MIN_SAMPLES:
        return False
    step = np.abs(np.diff(value))
    far = _FAR * float(np.subtract(*np.percentile(value, [95.0, 5.0])))
    away = np.minimum(step[:-1], step[1:]) > np.maximum(_AWAY * np.abs(value[2:] - value[:-2]), far)
    if np.count_nonzero(away) < _MIN_SAMPLES or np.unique(value).size < _MIN_VALUES:
        return False
    gaps = np.diff(np.flatnonzero(away)).astype(np.float64)
    usual = float(np.median(gaps))
    regular = gaps[(gaps >= _USUAL[0] * usual) & (gaps <= _USUAL[1] * usual)]
    return bool(regular.size >= _SHARE * gaps.size and regular.sum() > 0.5 * value.size)
