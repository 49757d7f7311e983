"""Collects the samples of a rig's topics from the files of a log, whatever the topics are called."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mcap.records import Channel

from slider_drilling.errors import InputError
from slider_drilling.log.log_reader import LogReader
from slider_drilling.log.mcap_chunk import MessageBlock
from slider_drilling.log.timestamps import StampedSamples
from slider_drilling.log.topic_map import TopicMap
from slider_drilling.messages.decoder import ENCODINGS, Integers, TopicDecoder
from slider_drilling.messages.message_types import JOINT_STATE
from slider_drilling.messages.topics import DRIVES_COMMAND, TOPICS, canonical_type, fitting_keys, namespace_of

# Approximate limit of samples: a week at 10 Hz, in a bit more than 1 GB of memory.
MAX_SAMPLES = 25_000_000
# Topics of these names may hold several joints, each under the name that the registry has for it: their series.
SHARED_TOPICS = {
    "joint_states": ("top_drive", "draw_works", "mud_pump"),
    DRIVES_COMMAND.name: ("top_drive_command", "draw_works_command"),
}
FILE_CHANNEL = 0xFFFF  # the bits of a channel's id that are its id in the file


@dataclass(frozen=True)
class SeriesMatch:
    """A series of a rig that a topic holds.

    Attributes:
        key: Of the series in the registry of topics.
        topic: Name of the topic in the log.
        joint: Name or index of its joint, where a topics file or a shared topic needs one.
        channel: The only channel to read; None for all.
        is_shared: Whether the topic is one for several joints, recognised by their names.
    """

    key: str
    topic: str
    joint: str | int | None = None
    channel: int | None = None
    is_shared: bool = False

    @property
    def namespace(self) -> str | None:
        """In front of the topic's name; None where the topic is named by a topics file."""
        shared = next((name for name, keys in SHARED_TOPICS.items() if self.key in keys), "")
        return namespace_of(self.topic, shared if self.is_shared else TOPICS[self.key].name)


@dataclass
class TopicSamples:
    """Samples of one series as they are read.

    Attributes:
        match: What is read.
        parts: The samples, block by block.
        order: Position of each sample in the log, block by block.
        count: Number of samples so far.
        ends: Number of samples after each file.
    """

    match: SeriesMatch
    parts: list[StampedSamples] = field(default_factory=list)
    order: list[Integers] = field(default_factory=list)
    count: int = 0
    ends: dict[Path, int] = field(default_factory=dict)
    _decoders: dict[tuple[int, str], TopicDecoder] = field(default_factory=dict)

    @property
    def unreadable(self) -> Counter[str]:
        """Number of messages that could not be read, by the reason."""
        return sum((decoder.unreadable for decoder in self._decoders.values()), Counter[str]())

    @property
    def left_out(self) -> Counter[str]:
        """Number of messages of which an array could not be read, by the reason."""
        return sum((decoder.left_out for decoder in self._decoders.values()), Counter[str]())

    def add(self, block: MessageBlock, position: Integers, channel: Channel, file: Path) -> None:
        """Read messages of one channel; `position` is the place of each in the log."""
        number = channel.id & FILE_CHANNEL
        if self.match.channel not in (None, number):
            return
        decoder = self._decoders.setdefault(
            (number, channel.message_encoding),
            TopicDecoder(TOPICS[self.match.key], self.match.joint, channel.message_encoding),
        )
        decoded = decoder.decode(block.data, block.start, block.end)
        if not len(decoded.stamp):
            return
        chosen = decoded.readable
        self.parts.append(StampedSamples(
            decoded.stamp, block.log_time[chosen].astype(np.int64), decoded.values,
            np.full(len(decoded.stamp), number), decoded.layout, block.sequence[chosen],
        ))  # fmt: skip
        self.order.append(position[chosen])
        self.count += len(decoded.stamp)
        self.ends[file] = self.count

    def track(self) -> StampedSamples:
        """All samples, in the order of the files."""
        track, position = StampedSamples.join(self.parts), np.concatenate(self.order)
        # Several channels of a topic alternate within a block.
        return track if (np.diff(position) > 0).all() else track.select(np.argsort(position, kind="stable"))

    def positions(self) -> Integers:
        """Where in the log each sample of the track stands, (n,)."""
        return np.sort(np.concatenate(self.order))


@dataclass
class SampleCollector:
    """Reads files into the series of a rig.

    Attributes:
        topics: A topics file's choices; a series that it names is read from there only.
        samples: What was read so far.
        ignored: Topic -> why it is not read although its name fits.
        count: Number of messages so far, of any topic.
    """

    topics: TopicMap = field(default_factory=dict)
    samples: dict[SeriesMatch, TopicSamples] = field(default_factory=dict)
    ignored: dict[str, str] = field(default_factory=dict)
    count: int = 0
    _of_channel: dict[tuple[Path, int], list[TopicSamples]] = field(default_factory=dict)

    def collect(self, reader: LogReader) -> None:
        """Read a file. Raises InputError for more than MAX_SAMPLES."""
        for block in reader.blocks():
            self.add(reader, block)
            if sum(samples.count for samples in self.samples.values()) > MAX_SAMPLES:
                raise InputError(
                    f"{reader.path}: holds more than {MAX_SAMPLES:,} samples of a rig's channels; "
                    "split it with another tool, such as `mcap filter`"
                )

    def add(self, reader: LogReader, block: MessageBlock) -> None:
        """Read the next block of a file."""
        position = np.arange(self.count, self.count + len(block.channel))
        self.count += len(block.channel)
        for number in np.unique(block.channel).tolist():
            key = (reader.path, number)
            if key not in self._of_channel:
                self._of_channel[key] = list(self._samples_of(reader, reader.channels[number]))
            if self._of_channel[key]:
                chosen = block.channel == number
                own = block.select(chosen)
                for samples in self._of_channel[key]:
                    samples.add(own, position[chosen], reader.channels[number], reader.path)

    def _samples_of(self, reader: LogReader, channel: Channel) -> Iterator[TopicSamples]:
        """The series that a channel's messages belong to."""
        matches = match_series(channel.topic, reader.type_of(channel), self.topics)
        if isinstance(matches, str):
            self.ignored[channel.topic] = matches
        elif matches and channel.message_encoding not in ENCODINGS:
            self.ignored[channel.topic] = f"its messages are encoded as {channel.message_encoding!r}, not cdr"
        else:
            yield from (self.samples.setdefault(match, TopicSamples(match)) for match in matches)

    def choose(self, namespace: str | None, source: str) -> dict[str, TopicSamples]:
        """One topic for each series. Raises InputError where topics of two rigs fit, or one of a topics file does not.

        Args:
            namespace: The rig whose topics to read; None for the only one.
            source: The log, for messages.
        """
        chosen: dict[str, TopicSamples] = {}
        wanted = None if namespace is None else f"/{namespace.strip('/')}".rstrip("/")
        filled = [samples for samples in self.samples.values() if samples.count]
        for samples in sorted(filled, key=lambda samples: samples.match.is_shared):
            match = samples.match
            if wanted is not None and match.key not in self.topics and match.namespace != wanted:
                continue
            if match.key not in chosen:
                chosen[match.key] = samples
            elif not match.is_shared or chosen[match.key].match.is_shared:
                raise InputError(
                    f"{source}: holds both {chosen[match.key].match.topic} and {match.topic}; "
                    "choose one with --namespace"
                )
        self._check_all_chosen(chosen, source)
        return chosen

    def remarks(self, chosen: dict[str, TopicSamples]) -> list[str]:
        """Sentences on messages that could not be read, and on joints that share a topic."""
        notes: dict[str, None] = {}
        read = {samples.match.topic for samples in chosen.values()}
        for samples in self.samples.values():
            match = samples.match
            if match.is_shared and (match.topic in read or match.key in chosen):
                continue  # it holds other joints, or nothing that is missing
            notes |= dict.fromkeys(_not_read(samples))
        for samples in chosen.values():
            partly = samples.left_out.items()
            notes |= dict.fromkeys(f"{samples.match.topic}: {count} messages: {why}" for why, count in partly)
        shared: dict[str, list[str]] = {}
        for samples in chosen.values():
            if samples.match.is_shared:
                shared.setdefault(samples.match.topic, []).append(str(samples.match.joint))
        return [*notes, *(f"{topic}: holds the joints {', '.join(joints)}" for topic, joints in shared.items())]

    def missing(self, chosen: dict[str, TopicSamples]) -> dict[str, str]:
        """Why series are missing, by their keys, where the log holds messages that could be theirs."""
        absent = [samples for samples in self.samples.values() if samples.match.key not in chosen]
        reasons = {samples.match.key: "; ".join(_not_read(samples)) for samples in absent if samples.unreadable}
        partly = {key: samples for key, samples in chosen.items() if samples.left_out}
        return reasons | {
            key: "; ".join(f"{samples.match.topic}: {why}" for why in samples.left_out)
            for key, samples in partly.items()
        }

    def _check_all_chosen(self, chosen: dict[str, TopicSamples], source: str) -> None:
        """Raise InputError where the log lacks a series that the topics file names."""
        for key, choice in self.topics.items():
            if key in chosen:
                continue
            which = [samples for samples in self.samples.values() if samples.match.key == key]
            why = [f"{count} unreadable: {reason}" for samples in which for reason, count in samples.unreadable.items()]
            why += [self.ignored[choice.topic]] if choice.topic in self.ignored else []
            raise InputError(
                f"{source}: {key}: no sample in topic {choice.topic}, which the topics file names"
                f"{': ' if why else ''}{'; '.join(why)}"
            )


def _not_read(samples: TopicSamples) -> list[str]:
    """A sentence for each reason why messages of a series could not be read."""
    match = samples.match
    sentences = []
    for why, count in samples.unreadable.items():
        # Which series looked for the joints of a shared topic does not matter.
        found = why.rpartition(", none named")[0] or why if match.is_shared else why
        needed = f" (needs {' or '.join(_joints(match))})" if match.is_shared else ""
        hint = "; say which is which in a file for --topics" if "joint" in why else ""
        sentences.append(f"{match.topic}: {count} unreadable messages: {found}{needed}{hint}")
    return sentences


def _joints(match: SeriesMatch) -> list[str]:
    """Names of the joints that a shared topic may hold."""
    keys = next(keys for keys in SHARED_TOPICS.values() if match.key in keys)
    return [TOPICS[key].joint for key in keys]


def match_series(topic: str, type_name: str | None, topics: TopicMap) -> list[SeriesMatch] | str:
    """The series that a topic may hold; the reason where only its name fits.

    Args:
        topic: Name in the log, with any namespace.
        type_name: Its message type in any spelling; None where the log does not say.
        topics: A topics file's choices.
    """
    absolute = f"/{topic.strip('/')}"
    named = [
        SeriesMatch(key, topic, choice.joint, choice.channel)
        for key, choice in topics.items()
        if choice.topic == absolute
    ]
    own = [
        SeriesMatch(key, topic)
        for key in fitting_keys(topic)
        if key not in topics
    ]
    for match in named + own:
        if type_name is not None and canonical_type(type_name) != TOPICS[match.key].type:
            return f"its type is {type_name}, not {TOPICS[match.key].type}"
    if not own and type_name is not None and canonical_type(type_name) == JOINT_STATE:
        own = [
            SeriesMatch(key, topic, TOPICS[key].joint, is_shared=True)
            for shared, keys in SHARED_TOPICS.items() if namespace_of(topic, shared) is not None
            for key in keys if key not in topics
        ]  # fmt: skip
    return named + own
