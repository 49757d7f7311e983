"""A feed whose stamps are checked: wrong ones are left out, and a clock that is set back ends it."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.log.timestamps import MAX_STEP_BACK, SECOND
from slider_drilling.twin.feed import Feed, Samples
from slider_drilling.twin.samples import Array

MAX_GAP_S = 600.0
"""s by which a stamp may be ahead of those before; one further ahead is wrong, unless the next one is as far."""
_BACK_IN_A_ROW = 3  # pieces whose stamps are all too old, after which the clock was set back


class CheckedFeed:
    """Passes on what a feed brings beside a rig; the top drive's stamps give the time.

    Args:
        feed: The feed.
        source: Its name, for messages.
        note: Called with a sentence for each stamp that is left out.
    """

    def __init__(self, feed: Feed, source: str, note: Callable[[str], None]) -> None:
        self._feed, self._source, self._note = feed, source, note
        self._newest = -math.inf  # s, of the top drive
        self._ahead = math.inf  # s, stamp that was left out last
        self._back = 0  # pieces in a row whose stamps are all too old
        self._waiting: deque[Samples] = deque()
        self.ended = False

    def poll(self) -> list[Samples]:
        """See `Feed`: one piece, so that what comes before a fault is used.

        Raises:
            InputError: The clock was set back.
        """
        if not self._waiting:
            self._waiting.extend(self._feed.poll())
        pieces = [self._checked(self._waiting.popleft())] if self._waiting else []
        self.ended = self._feed.ended and not self._waiting
        return pieces

    def _checked(self, piece: Samples) -> Samples:
        stamps = [piece[name][0] for name in ("top_drive_angle", "top_drive_speed") if name in piece]
        drive = np.unique(np.concatenate([times[np.isfinite(times)] for times in stamps])) if stamps else np.empty(0)
        drive = self._without_wrong(drive)
        if drive.size:
            self._check_back(float(drive[-1]))
            self._newest = max(self._newest, float(drive[-1]))
        if not math.isfinite(self._newest):
            return piece
        latest = self._newest + MAX_GAP_S
        return {name: (times[times <= latest], values[times <= latest]) for name, (times, values) in piece.items()}

    def _without_wrong(self, drive: Array) -> Array:
        """Stamps of the top drive (n,), rising, without a single last one that is far ahead."""
        before = np.concatenate([[self._newest], drive])
        if not drive.size or not math.isfinite(before[-2]) or before[-1] - before[-2] <= MAX_GAP_S:
            return drive
        last = float(drive[-1])
        confirmed, self._ahead = abs(last - self._ahead) <= MAX_GAP_S, last
        if confirmed:
            return drive
        self._note(f"{self._source}: a sample stamped {last - before[-2]:.0f} s after those before it is left out")
        return drive[:-1]

    def _check_back(self, last: float) -> None:
        """Raise InputError where the clock was set back."""
        behind = self._newest - last
        self._back = self._back + 1 if behind > MAX_STEP_BACK / SECOND else 0
        if self._back >= _BACK_IN_A_ROW:
            raise InputError(
                f"{self._source}: its clock was set back by {behind:.0f} s at {self._newest:.0f} s; start the watch "
                "again, for a twin follows one run"
            )
