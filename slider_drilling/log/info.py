"""What a log holds, topic by topic, of whatever type: rates, gaps, steps of its clock, losses."""

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
# Longer than so many usual steps, and than this, is a gap.
GAP_STEPS = 5.0
GAP_LEAST = 1.0


@dataclass(frozen=True)
class TopicInfo:
    """One topic. Times in s since the log's first message, by log times.

    rate: Hz, over the usual step between messages, NaN for fewer than two; longest_gap: s; gaps: how many are longer
    than GAP_STEPS usual steps and GAP_LEAST; lost: messages that the recorder knows to have missed, by the sequence
    numbers; clock_back: how often, and by how many s at most, stamps of a rig's channel step back by more than a
    second; lag: s from the stamp to the log time, usually, NaN where there is no stamp.
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
    """A log. bytes: of all its files; seconds: from its first message to its last; start_ns: of the first.

    attachments, metadata: names; notes: what of it is damaged or lost.
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
    """Columns of one topic, part by part."""

    kind: str
    decoder: TopicDecoder | None
    logged: list[Integers] = field(default_factory=list)
    sequence: list[Integers] = field(default_factory=list)
    stamp: list[Integers] = field(default_factory=list)
    stamp_logged: list[Integers] = field(default_factory=list)


def log_info(path: Path) -> LogInfo:
    """Look through a log, or a folder of its parts. Raises InputError where it cannot be read at all."""
    files = log_files(path)
    containers = [McapReader(file) for file in files]
    seen: dict[str, TopicMessages] = {}
    for container in containers:
        _look_through(container, seen)
    # Channels without a message count as topics, too.
    for container in containers:
        for channel in container.channels.values():
            seen.setdefault(printable(channel.topic), _begin(container, channel))
    filled = [np.concatenate(one.logged) for one in seen.values() if one.logged]
    start = min((int(logged.min()) for logged in filled), default=0)
    end = max((int(logged.max()) for logged in filled), default=0)
    return LogInfo(
        files=tuple(files),
        bytes=sum(file.stat().st_size for file in files),
        start_ns=start,
        seconds=(end - start) / SECOND,
        topics=tuple(_topic(topic, one, start) for topic, one in sorted(seen.items())),
        attachments=_names(attachment.name for container in containers for attachment in container.attachments),
        metadata=_names(record.name for container in containers for record in container.metadata),
        notes=tuple(printable(f"{one.path.name}: {note}") for one in containers for note in one.notes),
    )


def _names(found: Iterable[str]) -> tuple[str, ...]:
    return tuple(printable(name) for name in dict.fromkeys(found))


def _begin(container: McapReader, channel: Channel) -> TopicMessages:
    schema = container.schemas.get(channel.schema_id)
    key = series_of_topic(channel.topic, schema.name if schema else None)
    kind = canonical_type(schema.name) if schema and schema.name else "unknown"
    is_decoded = key and channel.message_encoding == "cdr"
    return TopicMessages(printable(kind), TopicDecoder(TOPICS[key]) if is_decoded else None)


def _look_through(container: McapReader, seen: dict[str, TopicMessages]) -> None:
    for block in container.blocks():
        for number in np.unique(block.channel).tolist():
            channel = container.channels[number]
            topic = printable(channel.topic)
            if topic not in seen:
                seen[topic] = _begin(container, channel)
            one, own = seen[topic], block.select(block.channel == number)
            one.logged.append(own.log_time.astype(np.int64))
            one.sequence.append(own.sequence)
            if one.decoder is not None:
                readable, stamp, _ = one.decoder.decode(own.data, own.start, own.end)
                one.stamp.append(stamp)
                one.stamp_logged.append(one.logged[-1][readable])


def _topic(topic: str, seen: TopicMessages, start: int) -> TopicInfo:
    if not seen.logged:
        return TopicInfo(topic, seen.kind, 0, NAN, NAN, NAN, 0.0, 0, 0, 0, 0.0, NAN)
    logged = np.concatenate(seen.logged)
    steps: Array = np.diff(np.sort(logged)).astype(np.float64) / SECOND
    usual = _usual(steps)
    back, furthest, lag = 0, 0.0, NAN
    if seen.stamp and sum(map(len, seen.stamp)):
        stamp = np.concatenate(seen.stamp)
        falls: Array = -np.diff(stamp.astype(np.float64))
        back = int(np.count_nonzero(falls > MAX_STEP_BACK))
        furthest = float(falls.max(initial=0.0)) / SECOND if back else 0.0
        lag = float(np.median(np.concatenate(seen.stamp_logged).astype(np.float64) - stamp)) / SECOND
    return TopicInfo(
        topic, seen.kind, len(logged), (int(logged.min()) - start) / SECOND, (int(logged.max()) - start) / SECOND,
        1.0 / usual if usual > 0.0 else NAN, float(steps.max(initial=0.0)),
        int(np.count_nonzero(steps > max(GAP_STEPS * usual, GAP_LEAST))), _lost(seen.sequence), back, furthest, lag,
    )  # fmt: skip


def _usual(steps: Array) -> float:
    """The middle of the steps; messages that come several at a time do not count. NaN where there is none."""
    apart = steps[steps > 0.0]
    return float(np.median(apart)) if apart.size else NAN


def _lost(parts: list[Integers]) -> int:
    """How many numbers are left out of a sequence that only grows; 0 for one that does not, as of other recorders."""
    total = 0
    for sequence in parts:
        steps = np.diff(sequence)
        if steps.size and (steps <= 0).any():
            return 0
        total += int((steps - 1).sum())
    joins = [int(after[0]) - int(before[-1]) - 1 for before, after in itertools.pairwise(parts)]
    return total + sum(gap for gap in joins if gap > 0)
