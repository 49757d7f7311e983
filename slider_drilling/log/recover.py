"""Writes a damaged log, a folder of parts, or several runs in one log as whole logs of one run each."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.records import Channel, Message
from numpy.typing import NDArray

from slider_drilling import __version__
from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import commit_part_file, create_part_file
from slider_drilling.log.log_files import find_log_files, open_readers
from slider_drilling.log.log_reader import LogReader
from slider_drilling.log.mcap_writer import McapWriter
from slider_drilling.log.publishers import split_signals
from slider_drilling.log.timestamps import (
    MAX_LEAP,
    MAX_STEP_BACK,
    SECOND,
    StampedSamples,
    largest_step_back,
    stamp_outliers,
)
from slider_drilling.log.topic_samples import SampleCollector
from slider_drilling.messages.topics import CLOCK_TOPICS

RECOVERED = "slider_drilling_recovered"
# Messages that must be sorted by time are held in memory, up to this many bytes.
MAX_SORTED_BYTES = 1_000_000_000
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class RecoveredLog:
    """One log that was written.

    Attributes:
        path: Its file.
        messages: Number of messages.
        seconds: From the first log time to the last.
    """

    path: Path
    messages: int
    seconds: float


@dataclass(frozen=True)
class _LogSurvey:
    """What a first pass through a log finds.

    Attributes:
        run_starts: Index of the first message of each run but the first.
        notes: What is damaged or lost.
        count: Number of messages.
        is_sorted: Whether the order of the files is that of recording.
    """

    run_starts: list[int]
    notes: list[str]
    count: int
    is_sorted: bool


def recover(path: Path, output: Path) -> tuple[list[RecoveredLog], list[str]]:
    """Write what a log still holds to a whole log: messages, channels, attachments and metadata as they are.

    Args:
        path: A log, or a folder of its parts.
        output: The file to write. Where the log holds several runs, each is written to a file of its own, output_1 and
            so on.

    Returns:
        What was written, and one sentence for each thing that was lost.

    Raises:
        InputError: Nothing can be recovered, or a file cannot be written; that file is removed then.
    """
    found = find_log_files(path)
    files = found.files
    survey = _survey(files)
    notes = [*found.notes, *survey.notes]
    if survey.count == 0:
        reasons = "".join(f"; {note}" for note in notes)
        raise InputError(f"{path}: holds no message that can be recovered{printable(reasons)}")
    ends = [*survey.run_starts, survey.count]
    names = [output] if len(ends) == 1 else [
        output.with_name(f"{output.stem}_{number}{output.suffix}") for number in range(1, len(ends) + 1)
    ]  # fmt: skip
    if len(ends) > 1:
        notes.append(f"held {len(ends)} runs; each is a log of its own now")
    readers = open_readers(files)
    messages = enumerate(_messages(readers, survey.is_sorted))
    written = [_write(name, path, messages, end, notes, readers) for name, end in zip(names, ends, strict=True)]
    return written, [printable(note) for note in notes]


def _survey(files: Sequence[Path]) -> _LogSurvey:
    """Go through a log once. Raises InputError where it must be sorted and is too large for that."""
    readers = open_readers(files)
    collector = SampleCollector()
    times: list[Integers] = []
    size = 0
    for reader in readers:
        for block in reader.blocks():
            collector.add(reader, block)
            size += len(block.data)
            times.append(block.log_time.astype(np.int64))
    notes = [f"{reader.path.name}: {note}" for reader in readers for note in reader.notes]
    is_sorted = not any(reader.chunks_out_of_order for reader in readers)
    if not is_sorted and size > MAX_SORTED_BYTES:
        raise InputError(
            f"{files[0]}: chunks are out of order, and {size / 1e9:.1f} GB are too much to sort; use `mcap sort`"
        )
    filled = {samples.match.key: samples for samples in reversed(collector.samples.values()) if samples.count}
    clock_key = next((key for key in CLOCK_TOPICS if key in filled), None)
    if clock_key is None or not is_sorted:
        return _LogSurvey([], notes, collector.count, is_sorted)
    starts = _run_starts(filled[clock_key].track(), filled[clock_key].positions(), np.concatenate(times))
    return _LogSurvey(starts, notes, collector.count, is_sorted)


def _run_starts(clock: StampedSamples, index: Integers, times: Integers) -> list[int]:
    """Index of the first message of every run but the first.

    Args:
        clock: Samples of the topic that separates runs, in the order of the log.
        index: Number of messages in the log before each of them.
        times: Log times of all messages, ns.
    """
    signals = split_signals(clock)
    main, own = clock.select(signals[0]), index[signals[0]]
    if largest_step_back(main) <= MAX_STEP_BACK:
        # Channels of one signal may be in the log one after another.
        order = np.argsort(main.logged, kind="stable")
        main, own = main.select(order), own[order]
    stamp = main.stamp if main.stamp.any() else main.logged
    if main.stamp.any():
        right = ~stamp_outliers(stamp, main.logged)
        stamp, own = stamp[right], own[right]
    steps = np.diff(stamp.astype(np.float64))
    pairs = [(int(own[at]), int(own[at + 1])) for at in np.flatnonzero((steps < -MAX_STEP_BACK) | (steps > MAX_LEAP))]
    # A run whose channel is another one follows, or went before.
    for other in signals[1:]:
        first, last = index[other][[0, -1]].tolist()
        if first > own[-1]:
            pairs.append((int(own[-1]), first))
        elif last < own[0]:
            pairs.append((last, int(own[0])))
    return sorted({_first_of_run(last, first, times) for last, first in pairs})


def _first_of_run(last: int, first: int, times: Integers) -> int:
    """Index of the first message of a run: after the last sample of the clock before it, up to its first.

    Other messages of the new run may come before its clock's. Their log times tell, if these step, too.
    """
    lag = times[last + 1 : first + 1] - times[last]
    stepped = np.flatnonzero((lag < -MAX_STEP_BACK) | (lag > MAX_LEAP))
    return last + 1 + int(stepped[0]) if stepped.size else first


def _messages(readers: list[LogReader], is_sorted: bool) -> Iterator[tuple[LogReader, Channel, Message]]:
    """All messages in the order of the files, or sorted by log time where that is not the order of recording."""
    messages = ((reader, *pair) for reader in readers for pair in reader.messages())
    yield from messages if is_sorted else sorted(messages, key=lambda entry: entry[2].log_time)


def _write(
    output: Path, origin: Path, messages: Iterator[tuple[int, tuple[LogReader, Channel, Message]]], end: int,
    notes: list[str], readers: list[LogReader],
) -> RecoveredLog:  # fmt: skip
    """Write the messages up to index `end`, completely or not at all."""
    first = next(messages)
    profile = first[1][0].profile
    try:
        descriptor, part = create_part_file(output)
        try:
            file = McapWriter(descriptor, f"slider_drilling {__version__}", profile=profile)
            with contextlib.closing(file):
                copy = _LogCopier(file)
                for number, (reader, channel, message) in itertools.chain([first], messages):
                    copy.message(reader, channel, message)
                    if number + 1 == end:
                        break
                for reader in readers:
                    copy.rest(reader)
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
    """Copies what files hold into one file; equal channels and schemas are written once."""

    def __init__(self, file: McapWriter) -> None:
        self._file = file
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._channels: dict[tuple[str, str, int, tuple[tuple[str, str], ...]], int] = {}
        self._numbers: dict[tuple[Path, int], int] = {}
        self._seen: set[tuple[str, ...]] = set()

    def message(self, reader: LogReader, channel: Channel, message: Message) -> None:
        """Copy a message. Raises OSError."""
        number = self._numbers.get((reader.path, channel.id))
        if number is None:
            number = self._numbers[reader.path, channel.id] = self._channel(reader, channel)
        self._file.message(number, message.sequence, message.log_time, message.publish_time, message.data)

    def rest(self, reader: LogReader) -> None:
        """Copy attachments and metadata that the reader has met so far. Raises OSError."""
        for attachment in reader.attachments:
            key = ("attachment", attachment.name, str(hash(attachment.data)))
            if key not in self._seen:
                self._seen.add(key)
                self._file.attachment(
                    attachment.name, attachment.media_type, attachment.data, attachment.log_time,
                    attachment.create_time,
                )  # fmt: skip
        for metadata in reader.metadata:
            key = ("metadata", metadata.name, str(sorted(metadata.metadata.items())))
            if key not in self._seen:
                self._seen.add(key)
                self._file.metadata(metadata.name, metadata.metadata)

    def _channel(self, reader: LogReader, channel: Channel) -> int:
        schema = reader.schemas.get(channel.schema_id)
        schema_id = 0
        if schema is not None:
            content = (schema.name, schema.encoding, schema.data)
            if content not in self._schemas:
                self._schemas[content] = self._file.schema(*content)
            schema_id = self._schemas[content]
        key = (channel.topic, channel.message_encoding, schema_id, tuple(sorted(channel.metadata.items())))
        if key not in self._channels:
            self._channels[key] = self._file.channel(channel.topic, channel.message_encoding, schema_id,
                                                     channel.metadata)  # fmt: skip
        return self._channels[key]
