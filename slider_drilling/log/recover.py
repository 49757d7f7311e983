"""A damaged log, a folder of parts or several runs in one, written again as whole logs of one run each."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.records import Channel, Message
from numpy.typing import NDArray

from slider_drilling import __version__
from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import commit_part_file, create_part_file
from slider_drilling.log.mcap_reader import McapReader
from slider_drilling.log.mcap_writer import McapWriter
from slider_drilling.log.read import log_files, series_of_topic
from slider_drilling.log.timestamps import MAX_LEAP, MAX_STEP_BACK, SECOND, stamp_outliers
from slider_drilling.messages.decoder import TopicDecoder
from slider_drilling.messages.topics import CLOCK_TOPICS, TOPICS

RECOVERED = "slider_drilling_recovered"
# Messages whose order of time has to be restored are held in memory: bytes of them, at most.
MOST_SORTED = 1_000_000_000
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class RecoveredLog:
    """One log that was written: how many messages it holds, over how many seconds by its log times."""

    path: Path
    messages: int
    seconds: float


@dataclass
class _ClockSamples:
    """The topic that tells the runs apart: of each sample its stamp, its log time, how many messages came before."""

    topic: str
    stamp: list[Integers]
    logged: list[Integers]
    place: list[Integers]


def recover(path: Path, output: Path) -> tuple[list[RecoveredLog], list[str]]:
    """Write what a log still holds to `output`, whole: its messages as they are, their channels, files and metadata.

    path: a log, or a folder of its parts. Where it holds several runs each gets a file of its own, output_1 and so
    on. Returns what was written, and a sentence for each thing that was lost. Raises InputError where there is
    nothing to recover or a file cannot be written; nothing is left of that file then.
    """
    files = log_files(path)
    boundaries, notes, count, is_sorted = _survey(files)
    if count == 0:
        why = "".join(f"; {note}" for note in notes)
        raise InputError(f"{path}: holds no message that can be recovered{printable(why)}")
    bounds = [*boundaries, count]
    names = [output] if len(bounds) == 1 else [
        output.with_name(f"{output.stem}_{number}{output.suffix}") for number in range(1, len(bounds) + 1)
    ]  # fmt: skip
    if len(bounds) > 1:
        notes.append(f"held {len(bounds)} runs; each is a log of its own now")
    containers = [McapReader(file) for file in files]
    messages = enumerate(_messages(containers, is_sorted))
    written = []
    for name, end in zip(names, bounds, strict=True):
        written.append(_write(name, path, messages, end, notes, containers))
    return written, [printable(note) for note in notes]


def _survey(files: list[Path]) -> tuple[list[int], list[str], int, bool]:
    """Where a new run begins, by the number of its first message; notes; how many there are; whether in order."""
    containers = [McapReader(file) for file in files]
    clocks: dict[str, _ClockSamples] = {}
    decoders: dict[str, TopicDecoder] = {}
    times: list[Integers] = []
    count = size = 0
    for container in containers:
        for block in container.blocks():
            places = np.arange(count, count + len(block.channel))
            count += len(block.channel)
            size += len(block.data)
            times.append(block.log_time.astype(np.int64))
            for number in np.unique(block.channel).tolist():
                channel = container.channels[number]
                schema = container.schemas.get(channel.schema_id)
                key = series_of_topic(channel.topic, schema.name if schema else None)
                if key not in CLOCK_TOPICS:
                    continue
                clock = clocks.setdefault(key, _ClockSamples(channel.topic, [], [], []))
                if clock.topic != channel.topic:
                    continue
                chosen = block.channel == number
                own = block.select(chosen)
                decoder = decoders.setdefault(key, TopicDecoder(TOPICS[key]))
                readable, stamp, _ = decoder.decode(own.data, own.start, own.end)
                clock.stamp.append(stamp)
                clock.logged.append(own.log_time[readable].astype(np.int64))
                clock.place.append(places[chosen][readable])
    notes = [f"{container.path.name}: {note}" for container in containers for note in container.notes]
    is_sorted = not any(container.chunks_out_of_order for container in containers)
    if not is_sorted:
        if size > MOST_SORTED:
            raise InputError(
                f"{files[0]}: its chunks have changed places, and {size / 1e9:.1f} GB are more than are put in order; "
                "use `mcap sort`"
            )
        return [], notes, count, is_sorted
    clock_key = next((key for key in CLOCK_TOPICS if key in clocks), None)
    if clock_key is None:
        return [], notes, count, is_sorted
    return _boundaries(clocks[clock_key], np.concatenate(times)), notes, count, is_sorted


def _boundaries(clock: _ClockSamples, times: Integers) -> list[int]:
    """Numbers of the first messages of every run but the first; times: log times of all messages, ns."""
    stamp, logged, place = (np.concatenate(parts) for parts in (clock.stamp, clock.logged, clock.place))
    right = ~stamp_outliers(stamp, logged) if stamp.any() else np.ones(len(stamp), dtype=np.bool_)
    stamp, place = (stamp if stamp.any() else logged)[right], place[right]
    steps = np.diff(stamp.astype(np.float64))
    found = []
    for at in np.flatnonzero((steps < -MAX_STEP_BACK) | (steps > MAX_LEAP)).tolist():
        last, first = int(place[at]), int(place[at + 1])
        # The new run's other messages may come before its clock's, which their log times tell if they step, too.
        lag = times[last + 1 : first + 1] - times[last]
        stepped = np.flatnonzero((lag < -MAX_STEP_BACK) | (lag > MAX_LEAP))
        found.append(last + 1 + int(stepped[0]) if stepped.size else first)
    return found


def _messages(containers: list[McapReader], is_sorted: bool) -> Iterator[tuple[McapReader, Channel, Message]]:
    """All messages in the order of the files, or by log time where that is not the order of recording."""
    if is_sorted:
        for container in containers:
            for channel, message in container.messages():
                yield container, channel, message
        return
    held = [(message.log_time, container, channel, message) for container in containers
            for channel, message in container.messages()]  # fmt: skip
    for _, container, channel, message in sorted(held, key=lambda one: one[0]):
        yield container, channel, message


def _write(
    output: Path, origin: Path, messages: Iterator[tuple[int, tuple[McapReader, Channel, Message]]], end: int,
    notes: list[str], containers: list[McapReader],
) -> RecoveredLog:  # fmt: skip
    """Write the messages up to number `end`, as a whole or not at all."""
    try:
        descriptor, part = create_part_file(output)
        try:
            file = McapWriter(descriptor, f"slider_drilling {__version__}")
            with contextlib.closing(file):
                copy = _LogCopier(file)
                for number, (container, channel, message) in messages:
                    copy.message(container, channel, message)
                    if number + 1 == end:
                        break
                for container in containers:
                    copy.rest(container)
                file.metadata(RECOVERED, {"from": str(origin), "lost": "; ".join(notes), "version": __version__})
                file.finish()
            commit_part_file(part, output)
        except BaseException:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(f"{output}: cannot write this log: {error.strerror}") from None
    return RecoveredLog(output, file.messages, (file.until - file.first) / SECOND)


class _LogCopier:
    """Puts what containers hold into one file, channels and schemas that are the same only once."""

    def __init__(self, file: McapWriter) -> None:
        self._file = file
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._channels: dict[tuple[str, str, int, tuple[tuple[str, str], ...]], int] = {}
        self._numbers: dict[tuple[Path, int], int] = {}
        self._seen: set[tuple[str, ...]] = set()

    def message(self, container: McapReader, channel: Channel, message: Message) -> None:
        """Add a message as it is. Raises OSError."""
        number = self._numbers.get((container.path, channel.id))
        if number is None:
            number = self._numbers[container.path, channel.id] = self._channel(container, channel)
        self._file.message(number, message.sequence, message.log_time, message.publish_time, message.data)

    def rest(self, container: McapReader) -> None:
        """Add what the container has found besides messages so far. Raises OSError."""
        for attachment in container.attachments:
            key = ("attachment", attachment.name, str(hash(attachment.data)))
            if key not in self._seen:
                self._seen.add(key)
                self._file.attachment(attachment.name, attachment.media_type, attachment.data)
        for metadata in container.metadata:
            key = ("metadata", metadata.name, str(sorted(metadata.metadata.items())))
            if key not in self._seen:
                self._seen.add(key)
                self._file.metadata(metadata.name, metadata.metadata)

    def _channel(self, container: McapReader, channel: Channel) -> int:
        schema = container.schemas.get(channel.schema_id)
        schema_id = 0
        if schema is not None:
            made = (schema.name, schema.encoding, schema.data)
            if made not in self._schemas:
                self._schemas[made] = self._file.schema(*made)
            schema_id = self._schemas[made]
        key = (channel.topic, channel.message_encoding, schema_id, tuple(sorted(channel.metadata.items())))
        if key not in self._channels:
            self._channels[key] = self._file.channel(channel.topic, channel.message_encoding, schema_id,
                                                     channel.metadata)  # fmt: skip
        return self._channels[key]
