"""Writes a log of a running rig or simulation to an MCAP file. Needs no ROS."""

from __future__ import annotations

import contextlib
import datetime
import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np

from slider_drilling import __version__
from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import commit_part_file, create_part_file
from slider_drilling.log.mcap_writer import CHUNK_BYTES, McapWriter
from slider_drilling.messages import cdr
from slider_drilling.messages.decoder import Array, Integers
from slider_drilling.messages.health import Status
from slider_drilling.messages.message_types import (
    DIAGNOSTIC_ARRAY,
    FLUID_PRESSURE,
    JOINT_STATE,
    MESSAGE_TYPES,
    WRENCH_STAMPED,
)
from slider_drilling.messages.topics import Topic

# Messages are written out at least this often, s of wall time: a killed recording loses no more.
FLUSH_PERIOD = 0.5
# Chunk size of a log that is made from another, bytes: three seconds of a rig's channels at 10 Hz, since a damaged
# chunk is lost as a whole. Chunks of a recording are bounded by FLUSH_PERIOD, too.
WHOLE_CHUNK = 16 * 1024
_BATCH = 5000  # messages between two reports of progress


@dataclass(frozen=True)
class MessageCounts:
    """What a file holds.

    Attributes:
        first: Log time of its first message, ns.
        last: Log time of its last message, ns.
        counts: Number of messages by topic.
    """

    first: int
    last: int
    counts: dict[str, int]


def nanoseconds(seconds: float) -> int:
    """Whole ns of a time in s."""
    return round(seconds * 1e9)


PROGRAMME = "programme.yaml"
"""Name of the attachment that holds the programme of a run."""


class LogWriter:
    """Writes one log. What has been recorded is kept, whatever ends the recording.

    Use it as a context manager: leaving it closes the log, after an error or an interrupt, too. A killed process leaves
    a file without an end, which `read_log` and `slider-drilling recover` read up to the last FLUSH_PERIOD before the
    kill. Where no messages may come for long, call `flush` now and then.

    All methods take stamps in s of the rig's (or the simulation's) clock; `log_time_s` is when the message arrived, the
    stamp if not given. Topics without a leading slash get one. Where the file cannot be written they raise InputError,
    which says what is saved in it.

    Args:
        path: The MCAP file. The name must be free, unless `whole`.
        rig_text: The rig file to attach.
        recorded_by: What recorded the log, for its metadata.
        notes: Free text for its metadata.
        whole: For a log that is made from another. The file gets its name when it is closed, and replaces whatever had
            that name; after an error or an interrupt there is no file.
        started: When the recording started; now if not given.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        rig_text: str | None = None,
        recorded_by: str = "",
        notes: str = "",
        *,
        whole: bool = False,
        started: datetime.datetime | None = None,
    ) -> None:
        self.path = Path(path)
        if self.path.is_dir():
            raise InputError(f"{self.path}: cannot write this log: it is a folder; name a file in it")
        try:
            descriptor, self._part = create_part_file(self.path) if whole else (_create(self.path), self.path)
        except FileExistsError:
            raise InputError(f"{self.path}: exists already; give another name") from None
        except OSError as error:
            raise InputError(f"{self.path}: cannot write this log: {error.strerror}") from None
        self._whole = whole
        self._open = True
        self._failure = ""
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._sequence: dict[str, int] = {}
        self._next_flush = math.inf if whole else time.monotonic() + FLUSH_PERIOD
        file: McapWriter | None = None
        try:
            file = McapWriter(descriptor, f"slider_drilling {__version__}", WHOLE_CHUNK if whole else CHUNK_BYTES)
            self._file = file
            self._describe(rig_text, recorded_by, notes, started)
        except BaseException as error:
            # Nothing has been recorded yet, so no file is left.
            if file is not None:
                file.close()
            self._part.unlink(missing_ok=True)
            if isinstance(error, OSError):
                raise InputError(f"{self.path}: cannot write this log: {error.strerror}") from None
            raise

    @property
    def size(self) -> int:
        """Approximate size, bytes."""
        return self._file.size

    def message_counts(self) -> MessageCounts:
        """The messages that are safe in the file."""
        file, topics = self._file, {number: topic for topic, number in self._channels.items()}
        return MessageCounts(file.first, file.until, {topics[number]: count for number, count in file.counts.items()})

    def attach_rig(self, rig_text: str) -> None:
        """Attach the rig file, where it was not known when the log was opened."""
        with self._ending_on_failure():
            self._file.attachment("rig.yaml", "application/yaml", rig_text.encode("utf-8"))

    def attach_programme(self, text: str) -> None:
        """Attach the programme that is run, as YAML."""
        self.add_attachment(PROGRAMME, "application/yaml", text.encode("utf-8"))

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Attach a file of any kind."""
        with self._ending_on_failure():
            self._file.attachment(name, media_type, data)

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Add a metadata record, beside `slider_drilling` that every log has."""
        with self._ending_on_failure():
            self._file.metadata(name, values)

    def _describe(
        self, rig_text: str | None, recorded_by: str, notes: str, started: datetime.datetime | None
    ) -> None:
        """Write the rig file and the metadata record first, so that an unfinished file has them, too."""
        if rig_text is not None:
            self._file.attachment("rig.yaml", "application/yaml", rig_text.encode("utf-8"))
        start_time = (started or datetime.datetime.now(datetime.timezone.utc)).isoformat(timespec="seconds")
        record = {"version": __version__, "recorded_by": recorded_by, "start_time": start_time, "notes": notes}
        self._file.metadata("slider_drilling", {name: printable(text) for name, text in record.items()})

    def sample(self, topic: Topic, stamp_s: float, numbers: Sequence[float], log_time_s: float | None = None) -> None:
        """Write a message of a registered topic.

        Args:
            topic: Its entry, of `slider_drilling.messages.topics.TOPICS`.
            stamp_s: When it was measured, s.
            numbers: Those that a log keeps of its type, SI: position, velocity and effort of a joint; a pressure and
                its variance; a force. NaN for one that is not given.
            log_time_s: When it arrived, s; the stamp if not given.

        Raises:
            InputError: The topic's type is another one, or the file cannot be written.
        """
        stamp = nanoseconds(stamp_s)
        self._write(topic.name, topic.type, cdr.encode_numbers(topic, stamp, numbers), stamp, log_time_s)

    def samples(
        self,
        parts: Sequence[tuple[Topic, Integers, Array, Integers]],
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        """Write messages of several registered topics, in the order in which they arrived.

        Args:
            parts: For each topic: its entry; when each sample was measured, ns, (n,); the numbers of each as for
                `sample`, (n, k); when each arrived, ns, (n,).
            progress: Called with the number of messages written so far and of all.

        Raises:
            InputError: A topic's type is another one, a time is out of range, or the file cannot be written.
        """
        channels, sequences, times, data = [], [], [], []
        for topic, stamps, numbers, arrivals in parts:
            if len(arrivals) and not 0 <= arrivals.min() <= arrivals.max() < 2**63 - 1:
                raise InputError(f"{self.path}: {topic.name}: log times are out of range; give 0 to 2^63 ns")
            name = _absolute(topic.name)
            if name not in self._channels:
                self.declare(name, topic.type, MESSAGE_TYPES[topic.type].definition)
            first = self._sequence.get(name, 0)
            self._sequence[name] = first + len(stamps)
            channels.append(np.full(len(stamps), self._channels[name]))
            sequences.append(first + np.arange(len(stamps)))
            times.append(arrivals)
            data += cdr.encode_rows(topic, stamps, numbers)
        every = np.concatenate([*times, np.empty(0, dtype=np.int64)])
        order = np.argsort(every, kind="stable")
        channel, sequence = (np.concatenate([*part, np.empty(0, dtype=np.int64)]) for part in (channels, sequences))
        with self._ending_on_failure():
            for start in range(0, len(order), _BATCH):
                batch = order[start : start + _BATCH]
                self._file.messages_in_order(
                    channel[batch].tolist(), sequence[batch].tolist(), every[batch].tolist(),
                    [data[index] for index in batch.tolist()],
                )  # fmt: skip
                if progress is not None:
                    progress(start + len(batch), len(order))

    def joint_state(
        self,
        topic: str,
        stamp_s: float,
        name: str,
        position: float | None = None,
        velocity: float | None = None,
        effort: float | None = None,
        log_time_s: float | None = None,
    ) -> None:
        """Write one joint: rad or m, rad/s or m/s, N m or N; None leaves a quantity out."""
        stamp = nanoseconds(stamp_s)
        data = cdr.encode_joint_state(stamp, name, position, velocity, effort)
        self._write(topic, JOINT_STATE, data, stamp, log_time_s)

    def fluid_pressure(
        self, topic: str, stamp_s: float, pressure: float, variance: float = 0.0, log_time_s: float | None = None
    ) -> None:
        """Write a pressure, Pa, and its variance, Pa2; 0 means unknown."""
        known = 0.0 if math.isnan(variance) else float(variance)
        stamp = nanoseconds(stamp_s)
        self._write(topic, FLUID_PRESSURE, cdr.encode_fluid_pressure(stamp, pressure, known), stamp, log_time_s)

    def wrench(
        self,
        topic: str,
        stamp_s: float,
        force: Sequence[float],
        torque: Sequence[float] = (0.0, 0.0, 0.0),
        log_time_s: float | None = None,
    ) -> None:
        """Write a force (x, y, z), N, and a torque, N m."""
        stamp = nanoseconds(stamp_s)
        self._write(topic, WRENCH_STAMPED, cdr.encode_wrench_stamped(stamp, force, torque), stamp, log_time_s)

    def diagnostics(
        self, topic: str, stamp_s: float, status: Sequence[Status], log_time_s: float | None = None
    ) -> None:
        """Write the statuses of one node."""
        stamp = nanoseconds(stamp_s)
        rows = [(part.level, part.name, part.message, part.hardware_id, part.values) for part in status]
        self._write(topic, DIAGNOSTIC_ARRAY, cdr.encode_diagnostic_array(stamp, rows), stamp, log_time_s)

    def message(
        self, topic: str, kind: str, data: bytes, log_time_ns: int, publish_time_ns: int, sequence: int | None = None
    ) -> None:
        """Write a message as it is.

        Args:
            topic: Name of the topic.
            kind: Its type: one of MESSAGE_TYPES, or any for a topic that was declared.
            data: The message as CDR.
            log_time_ns: When it arrived, ns.
            publish_time_ns: When it was sent, ns.
            sequence: Number of the message, which counts lost ones, too; the next number if not given.
        """
        name = _absolute(topic)
        if not 0 <= log_time_ns < 2**63:
            seconds = f"{log_time_ns * 1e-9:g} s"
            raise InputError(f"{self.path}: {name}: log time {seconds} is out of range; give 0 to 2^63 ns")
        if name not in self._channels:
            self.declare(name, kind, MESSAGE_TYPES[kind].definition)
        if sequence is None:
            sequence = self._sequence.get(name, 0)
            self._sequence[name] = sequence + 1
        if not self._open:
            raise self._closed_error()
        try:
            self._file.message(self._channels[name], sequence, log_time_ns, publish_time_ns, data)
        except OSError as error:
            raise self._end_after(error) from None
        if time.monotonic() >= self._next_flush:
            self.flush()

    def declare(self, topic: str, kind: str, schema: str, metadata: dict[str, str] | None = None) -> None:
        """Add a topic.

        Args:
            topic: Its name.
            kind: Its type, ``package/msg/Name``.
            schema: The definition of the type.
            metadata: Of the MCAP channel.
        """
        with self._ending_on_failure():
            if kind not in self._schemas:
                self._schemas[kind] = self._file.schema(kind, "ros2msg", schema.encode())
            self._channels[_absolute(topic)] = self._file.channel(
                _absolute(topic), "cdr", self._schemas[kind], metadata or {}
            )

    def flush(self) -> None:
        """Write out the messages so far, so that a kill afterwards loses none. Raises InputError where that fails."""
        with self._ending_on_failure():
            self._file.flush()
        if not self._whole:
            self._next_flush = time.monotonic() + FLUSH_PERIOD

    def close(self) -> None:
        """Finish the log; a second call does nothing. Where that fails, the InputError says what is saved."""
        if not self._open:
            return
        try:
            self._file.finish()
            if self._whole:
                commit_part_file(self._part, self.path)
        except OSError as error:
            raise self._end_after(error) from None
        except BaseException:
            self.discard()
            raise
        self._open = False

    def discard(self) -> None:
        """Delete what was written."""
        if self._open:
            self._open = False
            self._file.close()
            self._part.unlink(missing_ok=True)

    def __enter__(self) -> LogWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None and self._whole:
            self.discard()
        else:
            self.close()

    def _write(self, topic: str, kind: str, data: bytes, stamp: int, log_time_s: float | None) -> None:
        logged = stamp if log_time_s is None else nanoseconds(log_time_s)
        self.message(topic, kind, data, logged, logged)

    @contextlib.contextmanager
    def _ending_on_failure(self) -> Iterator[None]:
        """End the log and raise InputError where a write in the block fails."""
        if not self._open:
            raise self._closed_error()
        try:
            yield
        except OSError as error:
            raise self._end_after(error) from None

    def _closed_error(self) -> InputError:
        return InputError(self._failure or f"{self.path}: this log is already closed")

    def _end_after(self, error: OSError) -> InputError:
        """Finish the log as far as possible; returns the error, which says what is saved."""
        reason = f"{self.path}: cannot write this log: {error.strerror}"
        if self._whole:
            self.discard()
            self._failure = reason
            return InputError(reason)
        self._open = False
        with contextlib.suppress(OSError):
            self._file.finish()
        span = (self._file.until - self._file.first) * 1e-9
        self._failure = (
            f"{reason}; {self._file.messages} messages over {span:.1f} s are safe in it, "
            f"the {self._file.pending} after them are lost"
        )
        return InputError(self._failure)


def _create(path: Path) -> int:
    """The descriptor of a new file. Raises FileExistsError where the name is taken, OSError."""
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)


def _absolute(topic: str) -> str:
    return topic if topic.startswith("/") else f"/{topic}"
