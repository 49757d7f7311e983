"""Messages into columns of numbers, by their type's name and not by the schema text in the file."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.log.mcap_chunk import MessageBlock
from slider_drilling.messages.fields import MessageLayout, message_layout
from slider_drilling.messages.topics import FLUID_PRESSURE, Topic

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
# A recorder writes one layout a topic, or a few; what fits none of so many is read a message at a time.
_LAYOUTS = 8
WIDTH = 3  # position, velocity, effort; or value, variance, nothing


@dataclass
class Decoder:
    """Reads one topic's messages. unreadable: why -> how many could not be."""

    topic: Topic
    unreadable: Counter[str] = field(default_factory=Counter)
    _layouts: dict[int, list[MessageLayout]] = field(default_factory=dict)

    def decode(self, block: MessageBlock) -> tuple[NDArray[np.bool_], Integers, Array]:
        """Which messages of the block are readable, and of those: stamps, ns, (n,), and values (n, WIDTH)."""
        raw = np.frombuffer(block.data, dtype=np.uint8)
        count = len(block.start)
        readable = np.zeros(count, dtype=np.bool_)
        stamp, values = np.zeros(count, dtype=np.int64), np.full((count, WIDTH), np.nan)
        lengths = block.end - block.start
        for length in np.unique(lengths).tolist():
            left = np.flatnonzero(lengths == length)
            rows = sliding_window_view(raw, length)[block.start[left]]
            for layout in self._layouts.get(length, ()):
                left, rows = _fill(layout, left, rows, readable, stamp, values)
            while len(left):
                learnt = self._learn(length, rows[0].tobytes())
                if learnt is not None and len(self._layouts[length]) < _LAYOUTS:
                    left, rows = _fill(learnt, left, rows, readable, stamp, values)
                else:
                    if learnt is not None:
                        _fill(learnt, left[:1], rows[:1], readable, stamp, values)
                    left, rows = left[1:], rows[1:]
        if self.topic.type == FLUID_PRESSURE:
            # FluidPressure.msg: a variance of 0 means that it is unknown.
            values[~(values[:, 1] > 0.0), 1] = np.nan
        return readable, stamp[readable], values[readable]

    def _learn(self, length: int, data: bytes) -> MessageLayout | None:
        """The layout of a message that fits none that is known; None, and counted, where it is unreadable."""
        try:
            layout = message_layout(self.topic, data)
        except InputError as error:
            self.unreadable[str(error)] += 1
            return None
        known = self._layouts.setdefault(length, [])
        if len(known) < _LAYOUTS:
            known.append(layout)
        return layout


def _fill(
    layout: MessageLayout, left: NDArray[np.int64], rows: NDArray[np.uint8], readable: NDArray[np.bool_],
    stamp: Integers, values: Array,
) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:  # fmt: skip
    """Read the rows that have the layout into their places; what is left."""
    fits = layout.fits(rows)
    at = left[fits]
    stamp[at], read = layout.read(rows[fits])
    values[at, : read.shape[1]] = read
    readable[at] = True
    return left[~fits], rows[~fits]
