"""Runs a twin on a feed until that ends."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from slider_drilling.errors import InputError
from slider_drilling.twin.feed import Feed, Samples
from slider_drilling.twin.needed_samples import too_short
from slider_drilling.twin.report import TwinReport
from slider_drilling.twin.twin import Twin

_IDLE_S = 0.1  # between two looks at a feed that has nothing new
_LONGEST_WAIT_S = 900.0  # for the last diagnosis


def watch(twin: Twin, feed: Feed, show: Callable[[TwinReport], None], source: str) -> None:
    """Give the twin what comes, and show each report.

    Args:
        twin: The twin.
        feed: Its samples.
        show: Called with every report; after the feed has ended once more with the last, if a diagnosis came late.
        source: Name of what is watched, for messages.
    """
    while not feed.ended:
        pieces = feed.poll()
        for samples in pieces:
            for report in _take(twin, samples):
                show(report)
        if not pieces and not feed.ended:
            time.sleep(_IDLE_S)
            twin.advance()
    for report in twin.finish():
        show(report)
    if twin.report is None:
        raise InputError("; ".join((too_short(source, twin.span), *twin.left_out)))
    _await_answer(twin, show)


def reports_of(twin: Twin, feed: Feed) -> Iterator[TwinReport]:
    """Every report of a feed that never waits."""
    while not feed.ended:
        for samples in feed.poll():
            yield from _take(twin, samples)


def _take(twin: Twin, samples: Samples) -> list[TwinReport]:
    """Give the twin samples of its channels; returns the reports of the seconds that they complete."""
    for channel, (times, values) in samples.items():
        twin.add(channel, times, values)
    return twin.advance()


def _await_answer(twin: Twin, show: Callable[[TwinReport], None]) -> None:
    if not twin.asking or twin.report is None:
        return
    twin.take_held_answer()
    until = time.monotonic() + _LONGEST_WAIT_S
    while twin.asking and time.monotonic() < until:
        time.sleep(_IDLE_S)
        twin.advance()
    last = twin.latest_report()
    if last is not None:
        show(last)
