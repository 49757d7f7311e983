"""What `slider-drilling watch` reads from."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from slider_drilling.commands.watch_output import print_note
from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.log.follow_recording import RecordingFollower
from slider_drilling.log.log_files import holds_logs
from slider_drilling.log.topic_map import NO_TOPICS, read_topic_map
from slider_drilling.rig import Rig, load_rig
from slider_drilling.table_import.live_wits import is_live, open_stream
from slider_drilling.twin.checked_feed import CheckedFeed
from slider_drilling.twin.feed import Feed, LogFeed, RecordingFeed, Samples, recording_grows
from slider_drilling.twin.wits_feed import WitsFeed

_WAIT_FOR_RIG_S = 30.0
_IDLE_S = 0.1  # between two looks


def source_name(source: str) -> str:
    """What messages call a source."""
    return "standard input" if source == "-" else source


@contextmanager
def open_feed(
    source: str, rig_path: Path | None, namespace: str | None, topics_path: Path | None, follow: bool, wits_units: str
) -> Iterator[tuple[Feed, Rig, bool]]:
    """The samples of a source, its rig, and whether they are of the past.

    Raises:
        InputError: The source cannot be read, or there is no rig file.
    """
    if is_live(source):
        if rig_path is None:
            raise InputError(f"{source}: WITS holds no rig file; give --rig")
        rig = load_rig(rig_path)
        with open_stream(source) as receive:
            feed = WitsFeed(receive, source_name(source), wits_units, rig, print_note)
            yield CheckedFeed(feed, source_name(source), print_note), rig, False
        return
    if wits_units:
        raise InputError(f"--wits-units: {source} is no stream of WITS; leave it out")
    path = Path(source)
    if follow or recording_grows(path):
        _await_first_file(path)
        topics = NO_TOPICS if topics_path is None else read_topic_map(topics_path)
        recording = RecordingFeed(RecordingFollower(path, namespace, topics), follow, print_note)
        first: list[Samples] = []
        rig = load_rig(rig_path) if rig_path is not None else _rig_of(recording, source, first)
        yield CheckedFeed(_WithFirst(recording, first), source, print_note), rig, False
        return
    log = read_log(path, rig_path, namespace, topics_path)
    for note in log.notes:
        print_note(note)
    yield LogFeed(log), log.rig(), True


def _await_first_file(path: Path) -> None:
    """Wait until a folder holds a log; anything else is tried at once."""
    if not path.is_dir() or holds_logs(path):
        return
    print_note(f"{path} holds no log yet: waiting for the first one; Ctrl-C ends it")
    while not holds_logs(path):
        time.sleep(_IDLE_S)


class _WithFirst:
    """A feed whose first samples were read already."""

    def __init__(self, feed: Feed, first: list[Samples]) -> None:
        self._feed, self._first = feed, first
        self.ended = False

    def poll(self) -> list[Samples]:
        if self._first:
            first, self._first = self._first, []
            return first
        found = self._feed.poll()
        self.ended = self._feed.ended
        return found


def _rig_of(feed: RecordingFeed, source: str, first: list[Samples]) -> Rig:
    """The rig file in a recording, which is near its begin; what is read on the way goes into `first`."""
    until = math.inf  # for the first samples it waits as long as it takes
    while time.monotonic() < until and not feed.ended:
        first += feed.poll()
        rig = feed.rig()
        if rig is not None:
            return rig
        if len(first) > 3:
            break
        if first:
            until = min(until, time.monotonic() + _WAIT_FOR_RIG_S)
        time.sleep(_IDLE_S)
    raise InputError(f"{source}: shows no rig.yaml attachment so far; give the rig file with --rig")
