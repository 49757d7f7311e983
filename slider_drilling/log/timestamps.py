"""Puts the samples of a topic in order; removes repeated and wrong stamps; refuses several runs in one log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from slider_drilling.errors import InputError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

SECOND = 1_000_000_000
# Log times and stamps that differ by more are of different clocks (wall and simulated time), ns.
MAX_CLOCK_OFFSET = 10 * SECOND
# A surface topic whose stamps step back by more holds two runs, ns. Samples may be late by as much: the twin waits so
# long for them (`twin.settings.TwinSettings.patience`).
MAX_STEP_BACK = 2 * SECOND
# One whose stamps leap ahead by more holds two runs, or its clock was set, ns.
MAX_LEAP = 86_400 * SECOND
# Stamps so far outside the time of the log are of another clock, or invalid, ns.
FOREIGN_STAMP_DISTANCE = 3_600 * SECOND
# Samples of the running median that finds wrong stamps: up to half as many in a row are found.
OUTLIER_WINDOW = 11
# More wrong stamps than this fraction are not outliers but another run.
MAX_OUTLIER_FRACTION = 0.1


@dataclass(frozen=True)
class StampedSamples:
    """Samples of one topic.

    Attributes:
        stamp: When each was measured, ns, (n,).
        logged: When each was logged, ns, (n,).
        values: Logged numbers of the topic's type, (n, fields).
        channel: Id of the channel in its file, (n,).
        layout: Number of the message's layout, (n,): of texts and array lengths.
        sequence: Sequence number, (n,); 0 from many recorders.
    """

    stamp: Integers
    logged: Integers
    values: Array
    channel: Integers
    layout: Integers
    sequence: Integers

    def select(self, chosen: Mask | Integers) -> StampedSamples:
        """The chosen samples, by a mask (n,) or by indices in their order."""
        return StampedSamples(*(getattr(self, part.name)[chosen] for part in fields(self)))

    @classmethod
    def join(cls, parts: Sequence[StampedSamples]) -> StampedSamples:
        """The samples of all parts, one after another."""
        return cls(*(np.concatenate([getattr(part, name.name) for part in parts]) for name in fields(cls)))


def time_order(times: Integers) -> Integers | None:
    """Indices that sort times, stably; None where they are sorted."""
    return None if (np.diff(times) >= 0).all() else np.argsort(times, kind="stable")


def in_time_order(track: StampedSamples, times: Integers) -> StampedSamples:
    """The samples in the order of these times, (n,)."""
    order = time_order(times)
    return track if order is None else track.select(order)


def sort_by_stamp(
    track: StampedSamples, topic: str, is_surface: bool, moved: bool, source: str, notes: list[str]
) -> StampedSamples:
    """The samples of a topic in the order of their stamps, with one sample for each stamp.

    Args:
        track: Samples in the order of the file.
        topic: Name of the topic, for notes.
        is_surface: Whether samples are stamped in the order in which they arrive.
        moved: Whether chunks of the file are out of order, so that its order means nothing.
        source: The log, for messages.
        notes: Gets a sentence for each correction.

    Raises:
        InputError: The log holds two runs.
    """
    if moved or largest_step_back(track) <= MAX_STEP_BACK:
        track = in_time_order(track, track.logged)
    if not track.stamp.any() and track.logged.any():
        notes.append(f"{topic}: no stamps in its headers; log times taken instead")
        track = replace(track, stamp=track.logged.copy())
    track = _without_outliers(_with_stamps(track, topic, notes), topic, notes)
    if is_surface:
        _check_one_run(track, topic, source)
    track = in_time_order(track, track.stamp)
    last = np.append(np.diff(track.stamp) > 0, True)
    if last.all():
        return track
    notes.append(f"{topic}: {np.count_nonzero(~last)} repeated stamps; the last message of each was kept")
    return replace(track.select(last), values=_last_given(track.values, last))


def _last_given(values: Array, last: Mask) -> Array:
    """The last value that is given of each run of samples that ends at a `last` one; NaN where none is."""
    start = np.concatenate([[0], np.flatnonzero(last)[:-1] + 1])
    given = np.where(np.isnan(values), -1, np.arange(len(values))[:, None])
    index = np.maximum.reduceat(given, start, axis=0)
    return np.where(index < 0, np.nan, np.take_along_axis(values, np.maximum(index, 0), axis=0))


def largest_step_back(track: StampedSamples) -> int:
    """The largest step back of the log times within one channel, ns."""
    steps = np.diff(track.logged)
    if (track.channel != track.channel[0]).any():
        order = np.argsort(track.channel, kind="stable")
        steps = np.diff(track.logged[order])[np.diff(track.channel[order]) == 0]
    return int(-steps.min(initial=0))


def drop_foreign_stamps(
    track: StampedSamples, clock: StampedSamples, topic: str, is_surface: bool, notes: list[str]
) -> StampedSamples | None:
    """The samples stamped within the time of the log, or near it; None where none is left.

    Args:
        track: Samples of a topic.
        clock: Samples of the topic that gives the log's time.
        topic: Name of the topic, for notes.
        is_surface: Whether samples are stamped in the order in which they arrive.
        notes: Gets a sentence on what is left out.
    """
    # A target may have been set long before the log started.
    early = FOREIGN_STAMP_DISTANCE if is_surface else MAX_LEAP
    inside = (track.stamp >= clock.stamp[0] - early) & (track.stamp <= clock.stamp[-1] + FOREIGN_STAMP_DISTANCE)
    if inside.all():
        return track
    if not inside.any():
        far = (int(track.stamp[0]) - int(clock.stamp[0])) / SECOND
        notes.append(f"{topic}: stamped {far:.0f} s off the other topics, by another clock; left out")
        return None
    count = np.count_nonzero(~inside)
    notes.append(f"{topic}: {count} samples stamped more than an hour outside the log were left out")
    return track.select(inside)


def _with_stamps(track: StampedSamples, topic: str, notes: list[str]) -> StampedSamples:
    """Without samples whose stamp is 0, as of a publisher that sets none, unless the others are near 0, too."""
    unset = track.stamp == 0
    if not unset.any() or unset.all() or np.abs(track.stamp[~unset]).min() < FOREIGN_STAMP_DISTANCE:
        return track
    notes.append(f"{topic}: {np.count_nonzero(unset)} samples without a stamp were left out")
    return track.select(~unset)


def _without_outliers(track: StampedSamples, topic: str, notes: list[str]) -> StampedSamples:
    """Without samples whose stamps do not fit those around them."""
    wrong = stamp_outliers(track.stamp, track.logged)
    count = np.count_nonzero(wrong)
    if count == 0 or count > MAX_OUTLIER_FRACTION * len(wrong):
        return track
    first = int(track.stamp[np.flatnonzero(wrong)[0]])
    notes.append(f"{topic}: {count} samples with wrong stamps (the first: {first / SECOND:.3f} s) were left out")
    return track.select(~wrong)


def stamp_outliers(stamp: Integers, logged: Integers) -> Mask:
    """Which stamps do not fit those around them, (n,); none where there are fewer than OUTLIER_WINDOW.

    Inside the log a stamp is compared with the running median, which is the stamp itself where stamps only grow. At the
    log's ends a stamp must be off by FOREIGN_STAMP_DISTANCE, and by the log times as well.

    Args:
        stamp: ns, (n,), in the order of recording.
        logged: Log times, ns, (n,).
    """
    half = OUTLIER_WINDOW // 2
    wrong = np.zeros(len(stamp), dtype=np.bool_)
    if len(stamp) < OUTLIER_WINDOW:
        return wrong
    # Differences to the first stamp: 1e18 ns lose their last digits as floats, and int64 may overflow.
    from_first = stamp.astype(np.float64) - float(stamp[0])
    middle = np.median(sliding_window_view(from_first, OUTLIER_WINDOW), axis=1)
    usual = np.median(np.abs(np.diff(from_first)))
    wrong[half:-half] = np.abs(from_first[half:-half] - middle) > max(MAX_STEP_BACK, 3.0 * usual)
    lag = from_first - (logged.astype(np.float64) - float(logged[0]))
    first, last = slice(0, half), slice(-half, None)
    for edge, reference in ((first, slice(half, OUTLIER_WINDOW)), (last, slice(-OUTLIER_WINDOW, -half))):
        off = np.abs(from_first[edge] - np.median(from_first[reference]))
        lagging = np.abs(lag[edge] - np.median(lag[reference]))
        wrong[edge] = (off > FOREIGN_STAMP_DISTANCE) & (lagging > FOREIGN_STAMP_DISTANCE)
    return wrong


def _check_one_run(track: StampedSamples, topic: str, source: str) -> None:
    """Raise InputError where stamps step back, or leap ahead by more than a slide lasts."""
    steps = np.diff(track.stamp.astype(np.float64))
    if not steps.size:
        return
    for at, what in ((int(steps.argmin()), "step back"), (int(steps.argmax()), "leap ahead")):
        size = -steps[at] if what == "step back" else steps[at]
        if size > (MAX_STEP_BACK if what == "step back" else MAX_LEAP):
            after = (int(track.stamp[at]) - int(track.stamp[0])) / SECOND
            raise InputError(
                f"{source}: {topic}: stamps {what} by {size / SECOND:.1f} s after {after:.1f} s: "
                "two runs in one log; `slider-drilling recover` splits it"
            )
