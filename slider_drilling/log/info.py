"""Statistics of every topic of a log, of any type: rates, gaps, steps of the clock, lost messages."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mcap.records import Channel

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.log.log_files import find_log_files, open_readers
from slider_drilling.log.log_reader import LogReader
from slider_drilling.log.timestamps import MAX_STEP_BACK, SECOND
from slider_drilling.log.topic_map import NO_TOPICS, TopicMap
from slider_drilling.log.topic_samples import FILE_CHANNEL, match_series
from slider_drilling.messages.decoder import ENCODINGS, Array, Integers, header_stamps
from slider_drilling.messages.topics import canonical_type

NAN = float("nan")
_NONE = np.empty(0, dtype=np.int64)
# A gap is longer than so many usual steps, and than so many s.
GAP_STEPS = 5.0
MIN_GAP_S = 1.0


@dataclass(frozen=True)
class TopicInfo:
    """One topic.

    Attributes:
        topic: Its name.
        message_type: ``package/msg/Name``.
        messages: Number of messages.
        first: Log time of the first message, s since the log's first message.
        last: Log time of the last message, s likewise.
        rate: From the median step between messages, Hz; NaN for fewer than two.
        longest_gap: s.
        gaps: Number of gaps longer than GAP_STEPS median steps and MIN_GAP_S.
        lost: Number of messages that the recorder missed, by their sequence numbers.
        stamp_steps_back: How often stamps of a rig's topic step back by more than a second.
        largest_step_back: s.
        lag: Median delay from the stamp to the log time, s; NaN where there is no stamp.
        channels: Ids of its channels in the file: one for each publisher, as some recorders write them.
    """

    topic: str
    message_type: str
    messages: int
    first: float
    last: float
    rate: float
    longest_gap: float
    gaps: int
    lost: int
    stamp_steps_back: int
    largest_step_back: float
    lag: float
    channels: tuple[int, ...]


@dataclass(frozen=True)
class LogInfo:
    """A log.

    Attributes:
        files: Its files.
        bytes: Size of all of them.
        start_ns: Log time of the first message, ns.
        seconds: From the first message to the last.
        topics: Every topic, by name.
        attachments: Their names.
        metadata: Names of the metadata records.
        notes: What is damaged or lost.
    """

    files: tuple[Path, ...]
    bytes: int
    start_ns: int
    seconds: float
    topics: tuple[TopicInfo, ...]
    attachments: tuple[str, ...]
    metadata: tuple[str, ...]
    notes: tuple[str, ...]


@dataclass
class ChannelMessages:
    """Columns of the messages of one channel, block by block; stamps of those that have a header, ns."""

    logged: list[Integers] = field(default_factory=list)
    sequence: list[Integers] = field(default_factory=list)
    stamp: list[Integers] = field(default_factory=list)
    stamp_logged: list[Integers] = field(default_factory=list)


@dataclass
class TopicMessages:
    """The messages of one topic, by the ids of its channels; `has_stamp`: its type begins with a header."""

    kind: str
    has_stamp: bool
    channels: dict[int, ChannelMessages] = field(default_factory=dict)

    def column(self, name: str) -> Integers:
        """One column of all channels."""
        return np.concatenate([*(part for own in self.channels.values() for part in getattr(own, name)), _NONE])


def log_info(path: Path, topics: TopicMap = NO_TOPICS) -> LogInfo:
    """Statistics of a log, or of the folder of a bag; `topics`: of a topics file.

    Raises:
        InputError: It cannot be read.
    """
    found = find_log_files(path)
    files = found.files
    readers = open_readers(files)
    by_topic: dict[str, TopicMessages] = {}
    for reader in readers:
        _collect(reader, by_topic, topics)
    if all(reader.is_skipped for reader in readers):
        reasons = "; ".join(f"{reader.path.name}: {reader.notes[-1]}" for reader in readers)
        raise InputError(printable(f"{path}: no file of this log can be read; {reasons}"))
    # Channels without a message count as topics, too.
    for reader in readers:
        for channel in reader.channels.values():
            by_topic.setdefault(printable(channel.topic), _topic_messages(reader, channel, topics))
    filled = [logged for messages in by_topic.values() if len(logged := messages.column("logged"))]
    start = min((int(logged.min()) for logged in filled), default=0)
    end = max((int(logged.max()) for logged in filled), default=0)
    return LogInfo(
        files=files,
        bytes=sum(file.stat().st_size for file in files),
        start_ns=start,
        seconds=(end - start) / SECOND,
        topics=tuple(_topic_info(topic, messages, start) for topic, messages in sorted(by_topic.items())),
        attachments=_names(attachment.name for reader in readers for attachment in reader.attachments),
        metadata=_names(record.name for reader in readers for record in reader.metadata),
        notes=tuple(
            printable(note)
            for note in (*found.notes, *(f"{reader.path.name}: {note}" for reader in readers for note in reader.notes))
        ),
    )


def _names(names: Iterable[str]) -> tuple[str, ...]:
    """Different names in their order."""
    return tuple(printable(name) for name in dict.fromkeys(names))


def _topic_messages(reader: LogReader, channel: Channel, topics: TopicMap) -> TopicMessages:
    kind = reader.type_of(channel)
    matches = match_series(channel.topic, kind, topics)
    is_stamped = isinstance(matches, list) and bool(matches) and channel.message_encoding in ENCODINGS
    return TopicMessages(printable(canonical_type(kind)) if kind else "unknown", is_stamped)


def _collect(reader: LogReader, by_topic: dict[str, TopicMessages], topics: TopicMap) -> None:
    """Sort the messages of a file by topic and channel."""
    for block in reader.blocks():
        for number in np.unique(block.channel).tolist():
            channel = reader.channels[number]
            topic = printable(channel.topic)
            if topic not in by_topic:
                by_topic[topic] = _topic_messages(reader, channel, topics)
            messages, own = by_topic[topic], block.select(block.channel == number)
            columns = messages.channels.setdefault(number & FILE_CHANNEL, ChannelMessages())
            columns.logged.append(own.log_time.astype(np.int64))
            columns.sequence.append(own.sequence)
            if messages.has_stamp:
                stamped, stamp = header_stamps(own.data, own.start, own.end, channel.message_encoding)
                columns.stamp.append(stamp)
                columns.stamp_logged.append(columns.logged[-1][stamped])


def _topic_info(topic: str, messages: TopicMessages, start: int) -> TopicInfo:
    logged = messages.column("logged")
    if not len(logged):
        return TopicInfo(topic, messages.kind, 0, NAN, NAN, NAN, 0.0, 0, 0, 0, 0.0, NAN, ())
    steps: Array = np.diff(np.sort(logged)).astype(np.float64) / SECOND
    usual = _median_step(steps)
    stamp = messages.column("stamp")
    lags: Array = messages.column("stamp_logged").astype(np.float64) - stamp
    falls = np.concatenate([
        -np.diff(np.concatenate(own.stamp).astype(np.float64)) for own in messages.channels.values() if own.stamp
    ] or [np.empty(0)])  # fmt: skip
    back = int(np.count_nonzero(falls > MAX_STEP_BACK))
    return TopicInfo(
        topic=topic,
        message_type=messages.kind,
        messages=len(logged),
        first=(int(logged.min()) - start) / SECOND,
        last=(int(logged.max()) - start) / SECOND,
        rate=1.0 / usual if usual > 0.0 else NAN,
        longest_gap=float(steps.max(initial=0.0)),
        gaps=int(np.count_nonzero(steps > max(GAP_STEPS * usual, MIN_GAP_S))),
        lost=_lost_of_topic(messages),
        stamp_steps_back=back,
        largest_step_back=float(falls.max(initial=0.0)) / SECOND if back else 0.0,
        lag=float(np.median(lags)) / SECOND if len(lags) else NAN,
        channels=tuple(sorted(messages.channels)),
    )


def _median_step(steps: Array) -> float:
    """The median of the steps between messages that do not come at the same time; NaN where there is none."""
    apart = steps[steps > 0.0]
    return float(np.median(apart)) if apart.size else NAN


def _lost_of_topic(messages: TopicMessages) -> int:
    """Number of lost messages. Recorders number the messages of each channel, or those of all channels of a topic."""
    order = np.argsort(messages.column("logged"), kind="stable")
    together = messages.column("sequence")[order]
    if (np.diff(together) > 0).all():
        return _lost_count([together])
    return sum(_lost_count(own.sequence) for own in messages.channels.values())


def _lost_count(parts: list[Integers]) -> int:
    """Number of gaps in the sequence numbers; 0 where they do not only grow, as with some recorders."""
    total = 0
    for sequence in parts:
        steps = np.diff(sequence)
        if steps.size and (steps <= 0).any():
            return 0
        total += int((steps - 1).sum())
    joins = [int(after[0]) - int(before[-1]) - 1 for before, after in itertools.pairwise(parts)]
    return total + sum(gap for gap in joins if gap > 0)
