"""Statistics of every topic of a log, of any type: rates, gaps, steps of the clock, lost messages."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mcap.records import Channel

from slider_drilling.console.printable import printable
from slider_drilling.log.mcap_reader import McapReader
from slider_drilling.log.read import log_files, series_of_topic
from slider_drilling.log.timestamps import MAX_STEP_BACK, SECOND
from slider_drilling.messages.decoder import Array, Integers, TopicDecoder
from slider_drilling.messages.topics import TOPICS, canonical_type

NAN = float("nan")
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
class TopicMessages:
    """The messages of one topic, block by block; `decoder` is None for one that is not a rig's."""

    kind: str
    decoder: TopicDecoder | None
    logged: list[Integers] = field(default_factory=list)
    sequence: list[Integers] = field(default_factory=list)
    stamp: list[Integers] = field(default_factory=list)
    stamp_logged: list[Integers] = field(default_factory=list)


def log_info(path: Path) -> LogInfo:
    """Statistics of a log, or of the folder of a bag. Raises InputError where it cannot be read."""
    files = log_files(path)
    readers = [McapReader(file) for file in files]
    by_topic: dict[str, TopicMessages] = {}
    for reader in readers:
        _collect(reader, by_topic)
    # Channels without a message count as topics, too.
    for reader in readers:
        for channel in reader.channels.values():
            by_topic.setdefault(printable(channel.topic), _topic_messages(reader, channel))
    filled = [np.concatenate(messages.logged) for messages in by_topic.values() if messages.logged]
    start = min((int(logged.min()) for logged in filled), default=0)
    end = max((int(logged.max()) for logged in filled), default=0)
    return LogInfo(
        files=tuple(files),
        bytes=sum(file.stat().st_size for file in files),
        start_ns=start,
        seconds=(end - start) / SECOND,
        topics=tuple(_topic_info(topic, messages, start) for topic, messages in sorted(by_topic.items())),
        attachments=_names(attachment.name for reader in readers for attachment in reader.attachments),
        metadata=_names(record.name for reader in readers for record in reader.metadata),
        notes=tuple(printable(f"{reader.path.name}: {note}") for reader in readers for note in reader.notes),
    )


def _names(names: Iterable[str]) -> tuple[str, ...]:
    """Different names in their order."""
    return tuple(printable(name) for name in dict.fromkeys(names))


def _topic_messages(reader: McapReader, channel: Channel) -> TopicMessages:
    schema = reader.schemas.get(channel.schema_id)
    key = series_of_topic(channel.topic, schema.name if schema else None)
    kind = canonical_type(schema.name) if schema and schema.name else "unknown"
    is_decoded = key and channel.message_encoding == "cdr"
    return TopicMessages(printable(kind), TopicDecoder(TOPICS[key]) if is_decoded else None)


def _collect(reader: McapReader, by_topic: dict[str, TopicMessages]) -> None:
    """Sort the messages of a file by topic."""
    for block in reader.blocks():
        for number in np.unique(block.channel).tolist():
            channel = reader.channels[number]
            topic = printable(channel.topic)
            if topic not in by_topic:
                by_topic[topic] = _topic_messages(reader, channel)
            messages, own = by_topic[topic], block.select(block.channel == number)
            messages.logged.append(own.log_time.astype(np.int64))
            messages.sequence.append(own.sequence)
            if messages.decoder is not None:
                readable, stamp, _ = messages.decoder.decode(own.data, own.start, own.end)
                messages.stamp.append(stamp)
                messages.stamp_logged.append(messages.logged[-1][readable])


def _topic_info(topic: str, messages: TopicMessages, start: int) -> TopicInfo:
    if not messages.logged:
        return TopicInfo(topic, messages.kind, 0, NAN, NAN, NAN, 0.0, 0, 0, 0, 0.0, NAN)
    logged = np.concatenate(messages.logged)
    steps: Array = np.diff(np.sort(logged)).astype(np.float64) / SECOND
    usual = _median_step(steps)
    back, furthest, lag = 0, 0.0, NAN
    if messages.stamp and sum(map(len, messages.stamp)):
        stamp = np.concatenate(messages.stamp)
        falls: Array = -np.diff(stamp.astype(np.float64))
        back = int(np.count_nonzero(falls > MAX_STEP_BACK))
        furthest = float(falls.max(initial=0.0)) / SECOND if back else 0.0
        lag = float(np.median(np.concatenate(messages.stamp_logged).astype(np.float64) - stamp)) / SECOND
    return TopicInfo(
        topic=topic,
        message_type=messages.kind,
        messages=len(logged),
        first=(int(logged.min()) - start) / SECOND,
        last=(int(logged.max()) - start) / SECOND,
        rate=1.0 / usual if usual > 0.0 else NAN,
        longest_gap=float(steps.max(initial=0.0)),
        gaps=int(np.count_nonzero(steps > max(GAP_STEPS * usual, MIN_GAP_S))),
        lost=_lost_count(messages.sequence),
        stamp_steps_back=back,
        largest_step_back=furthest,
        lag=lag,
    )


def _median_step(steps: Array) -> float:
    """The median of the steps between messages that do not come at the same time; NaN where there is none."""
    apart = steps[steps > 0.0]
    return float(np.median(apart)) if apart.size else NAN


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
