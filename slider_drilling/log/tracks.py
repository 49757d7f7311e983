"""One topic's samples in order: repeated stamps, stamps that are no time of the log's, several runs in one log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from slider_drilling.errors import InputError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

SECOND = 1_000_000_000
# A log whose clock differs from its stamps' by more was recorded on another clock (wall against simulated time).
OTHER_CLOCK = 10 * SECOND
# A surface channel whose stamps step back by more holds two runs.
STEP_BACK = SECOND
# One whose stamps leap ahead by more has had its clock set, or holds two runs.
LEAP = 86_400 * SECOND
# Stamps so far before or after all of the log's clock are of another clock, or of none.
FAR = 3_600 * SECOND
# As many stamps in a row as half of this may be wrong among right ones; a larger share of all makes another run.
WINDOW = 11
WRONG_SHARE = 0.1


@dataclass(frozen=True)
class Track:
    """One series in the stamps' clock: stamps and log times, ns, stamps strictly increasing; values, shape (n, 3)."""

    stamp: Integers
    logged: Integers
    values: Array

    def only(self, chosen: Mask | Integers) -> Track:
        """Those samples alone, or in that order."""
        return Track(self.stamp[chosen], self.logged[chosen], self.values[chosen])


def ordered(track: Track, topic: str, is_surface: bool, moved: bool, source: str, notes: list[str]) -> Track:
    """The samples of one topic in the order of their stamps, one a stamp.

    track: in the order of the file; moved: which says nothing, the file's parts having changed places. Raises
    InputError for two runs in one log. What is done to the samples is noted.
    """
    back = -np.diff(track.logged, prepend=track.logged[:1])
    if moved or (back.size and back.max() <= STEP_BACK):
        track = track.only(np.argsort(track.logged, kind="stable"))
    if not track.stamp.any() and track.logged.any():
        notes.append(f"{topic}: no stamps in its headers; log times taken instead")
        track = Track(track.logged.copy(), track.logged, track.values)
    track = _without_outliers(_with_stamps(track, topic, notes), topic, notes)
    if is_surface:
        _check_one_run(track, topic, source)
    track = track.only(np.argsort(track.stamp, kind="stable"))
    last = np.append(np.diff(track.stamp) > 0, True)
    if not last.all():
        notes.append(f"{topic}: {np.count_nonzero(~last)} repeated stamps; the last message of each kept")
    return track.only(last)


def within(track: Track, clock: Track, topic: str, is_surface: bool, notes: list[str]) -> Track | None:
    """The samples stamped within the time of the log's clock, or about; None where none is left."""
    # A target may have been set long before the log began.
    early = FAR if is_surface else LEAP
    inside = (track.stamp >= clock.stamp[0] - early) & (track.stamp <= clock.stamp[-1] + FAR)
    if inside.all():
        return track
    if not inside.any():
        far = (int(track.stamp[0]) - int(clock.stamp[0])) / SECOND
        notes.append(f"{topic}: stamped {far:.0f} s off the other channels, by another clock; left out")
        return None
    notes.append(f"{topic}: {np.count_nonzero(~inside)} samples stamped an hour and more outside the log left out")
    return track.only(inside)


def _with_stamps(track: Track, topic: str, notes: list[str]) -> Track:
    """Without samples whose stamp is 0, as of a publisher that sets none, where the others are of another time."""
    unset = track.stamp == 0
    if not unset.any() or unset.all() or np.abs(track.stamp[~unset]).min() < FAR:
        return track
    notes.append(f"{topic}: {np.count_nonzero(unset)} samples without a stamp left out")
    return track.only(~unset)


def _without_outliers(track: Track, topic: str, notes: list[str]) -> Track:
    """Without samples whose stamps do not fit in with those before and after them."""
    wrong = outliers(track.stamp, track.logged)
    count = np.count_nonzero(wrong)
    if count == 0 or count > WRONG_SHARE * len(wrong):
        return track
    first = int(track.stamp[np.flatnonzero(wrong)[0]])
    notes.append(f"{topic}: {count} samples with stamps out of all order (the first: {first / SECOND:.3f} s) left out")
    return track.only(~wrong)


def outliers(stamp: Integers, logged: Integers) -> Mask:
    """Which stamps lie off those around them, (n,), in the order of recording; none where there are few.

    Within the log the middle of the stamps around tells: it is the stamp itself where they only grow. At the log's
    ends it is not, and a stamp must be off by FAR, by the log's clock as well, to be taken for wrong.
    """
    half = WINDOW // 2
    wrong = np.zeros(len(stamp), dtype=np.bool_)
    if len(stamp) < WINDOW:
        return wrong
    # Differences to the first: numbers of 1e18 ns lose their last digits as floats, and int64 may overflow.
    from_first = stamp.astype(np.float64) - float(stamp[0])
    middle = np.median(sliding_window_view(from_first, WINDOW), axis=1)
    usual = np.median(np.abs(np.diff(from_first)))
    wrong[half:-half] = np.abs(from_first[half:-half] - middle) > max(STEP_BACK, 3.0 * usual)
    lag = from_first - (logged.astype(np.float64) - float(logged[0]))
    for edge, reference in ((slice(0, half), slice(half, WINDOW)), (slice(-half, None), slice(-WINDOW, -half))):
        off = np.abs(from_first[edge] - np.median(from_first[reference]))
        lagging = np.abs(lag[edge] - np.median(lag[reference]))
        wrong[edge] = (off > FAR) & (lagging > FAR)
    return wrong


def _check_one_run(track: Track, topic: str, source: str) -> None:
    """Raises InputError where stamps step back, or leap ahead by more than a slide lasts."""
    steps = np.diff(track.stamp.astype(np.float64))
    if not steps.size:
        return
    for at, what in ((int(steps.argmin()), "step back"), (int(steps.argmax()), "leap ahead")):
        size = -steps[at] if what == "step back" else steps[at]
        if size > (STEP_BACK if what == "step back" else LEAP):
            after = (int(track.stamp[at]) - int(track.stamp[0])) / SECOND
            raise InputError(
                f"{source}: {topic}: stamps {what} by {size / SECOND:.1f} s after {after:.1f} s: "
                "two runs in one log; `slider-drilling recover` splits it"
            )
