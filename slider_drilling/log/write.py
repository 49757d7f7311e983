"""From a running rig or simulation to an MCAP file; no ROS needed."""

from __future__ import annotations

import contextlib
import datetime
import math
import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from slider_drilling import __version__
from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import commit_part_file, create_part_file
from slider_drilling.log.mcap_writer import CHUNK_BYTES, McapWriter
from slider_drilling.messages import cdr
from slider_drilling.messages.health import Status
from slider_drilling.messages.message_types import (
    DIAGNOSTIC_ARRAY,
    FLUID_PRESSURE,
    JOINT_STATE,
    MESSAGE_TYPES,
    WRENCH_STAMPED,
)
from slider_drilling.messages.topics import Topic

# What a killed recording may lose, s of wall time: messages are written out at least this often.
FLUSH_PERIOD = 0.5
# A damaged chunk is lost as a whole: this much is some three seconds of a rig's channels at 10 Hz. A recording's are
# smaller than its limit by FLUSH_PERIOD, unless so much comes in that they are shorter than that.
WHOLE_CHUNK = 16 * 1024


@dataclass(frozen=True)
class MessageCounts:
    """What a file holds: log times of its first and last message, ns, and how many there are of each topic."""

    first: int
    last: int
    counts: dict[str, int]


def nanoseconds(seconds: float) -> int:
    """Whole ns of a time in s."""
    return round(seconds * 1e9)


class LogWriter:
    """Writes one log, under its name from the start: what has come in is kept, whatever ends the recording.

    Use it as a context manager: leaving it closes the log, by an error or an interrupt too. A run that is killed
    leaves a file without an end, which read_log and `slider-drilling recover` read up to the last FLUSH_PERIOD
    before the kill; where messages may stay away, call `flush` now and then. The name must not be taken.

    whole: for a log that is made from another: it gets its name when it is closed, in place of whatever had that
    name; an error or an interrupt leaves nothing.

    Stamps are s of the rig's (or the simulation's) clock; log_time_s is when the message arrived, the stamp if not
    given; started is when the recording began, now if not given. Topics get a leading slash if they have none. Raises
    InputError where the file cannot be written, and says what is safe in it.
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
            descriptor, self._part = create_part_file(self.path) if whole else (_take(self.path), self.path)
        except FileExistsError:
            raise InputError(f"{self.path}: is there already; give another name") from None
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
            # Nothing has been recorded yet: an empty log explains nothing.
            if file is not None:
                file.close()
            self._part.unlink(missing_ok=True)
            if isinstance(error, OSError):
                raise InputError(f"{self.path}: cannot write this log: {error.strerror}") from None
            raise

    @property
    def size(self) -> int:
        """Bytes so far, about."""
        return self._file.size

    def message_counts(self) -> MessageCounts:
        """What is safe in the file."""
        file, topics = self._file, {number: topic for topic, number in self._channels.items()}
        return MessageCounts(file.first, file.until, {topics[number]: count for number, count in file.counts.items()})

    def attach_rig(self, rig_text: str) -> None:
        """Add the rig file, where it was not known when the log was begun."""
        with self._failing():
            self._file.attachment("rig.yaml", "application/yaml", rig_text.encode("utf-8"))

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Add a file of any kind."""
        with self._failing():
            self._file.attachment(name, media_type, data)

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Add a metadata record, beside the one named slider_drilling that every log has."""
        with self._failing():
            self._file.metadata(name, values)

    def _describe(
        self, rig_text: str | None, recorded_by: str, notes: str, started: datetime.datetime | None
    ) -> None:
        """The rig file and the metadata record, at the front so that a broken-off file has them too."""
        if rig_text is not None:
            self._file.attachment("rig.yaml", "application/yaml", rig_text.encode("utf-8"))
        begun = (started or datetime.datetime.now(datetime.timezone.utc)).isoformat(timespec="seconds")
        record = {"version": __version__, "recorded_by": recorded_by, "start_time": begun, "notes": notes}
        self._file.metadata("slider_drilling", {name: printable(text) for name, text in record.items()})

    def sample(self, topic: Topic, stamp_s: float, numbers: Sequence[float], log_time_s: float | None = None) -> None:
        """A message of a topic of the registry.

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
        """One joint: rad or m, rad/s or m/s, N m or N; None leaves a quantity out."""
        stamp = nanoseconds(stamp_s)
        data = cdr.encode_joint_state(stamp, name, position, velocity, effort)
        self._write(topic, JOINT_STATE, data, stamp, log_time_s)

    def fluid_pressure(
        self, topic: str, stamp_s: float, pressure: float, variance: float = 0.0, log_time_s: float | None = None
    ) -> None:
        """A pressure, Pa, and its variance, Pa2; 0 says that the variance is not known."""
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
        """A force (x, y, z), N, and a torque, N m."""
        stamp = nanoseconds(stamp_s)
        self._write(topic, WRENCH_STAMPED, cdr.encode_wrench_stamped(stamp, force, torque), stamp, log_time_s)

    def diagnostics(
        self, topic: str, stamp_s: float, status: Sequence[Status], log_time_s: float | None = None
    ) -> None:
        """The health of one node's parts."""
        stamp = nanoseconds(stamp_s)
        rows = [(one.level, one.name, one.message, one.hardware_id, one.values) for one in status]
        self._write(topic, DIAGNOSTIC_ARRAY, cdr.encode_diagnostic_array(stamp, rows), stamp, log_time_s)

    def message(
        self, topic: str, kind: str, data: bytes, log_time_ns: int, publish_time_ns: int, sequence: int | None = None
    ) -> None:
        """A message as it came, CDR bytes; times are ns, of its arrival and of its sending.

        kind: a type in MESSAGE_TYPES, or any for a topic that was declared. sequence: counts the topic's messages,
        those that were lost too; how many there are if not given.
        """
        name = _absolute(topic)
        if not 0 <= log_time_ns < 2**63:
            raise InputError(f"{self.path}: {name}: logged at {log_time_ns * 1e-9:g} s, not a time of any clock")
        if name not in self._channels:
            self.declare(name, kind, MESSAGE_TYPES[kind].definition)
        if sequence is None:
            sequence = self._sequence.get(name, 0)
            self._sequence[name] = sequence + 1
        if not self._open:
            raise self._closed()
        try:
            self._file.message(self._channels[name], sequence, log_time_ns, publish_time_ns, data)
        except OSError as error:
            raise self._failed(error) from None
        if time.monotonic() >= self._next_flush:
            self.flush()

    def declare(
        self, topic: str, kind: str, schema: str, metadata: dict[str, str] | None = None, encoding: str = "ros2msg"
    ) -> None:
        """Add a topic: its type as `package/msg/Name`, that type's definition, metadata of its channel."""
        with self._failing():
            if kind not in self._schemas:
                self._schemas[kind] = self._file.schema(kind, encoding, schema.encode())
            self._channels[_absolute(topic)] = self._file.channel(
                _absolute(topic), "cdr", self._schemas[kind], metadata or {}
            )

    def flush(self) -> None:
        """Write out what has come in: a kill, later, loses nothing of it. Raises InputError where that fails."""
        with self._failing():
            self._file.flush()
        if not self._whole:
            self._next_flush = time.monotonic() + FLUSH_PERIOD

    def close(self) -> None:
        """Finish the log. Raises InputError where that fails, saying what is safe; a second time does nothing."""
        if not self._open:
            return
        try:
            self._file.finish()
            if self._whole:
                commit_part_file(self._part, self.path)
        except OSError as error:
            raise self._failed(error) from None
        except BaseException:
            self.discard()
            raise
        self._open = False

    def discard(self) -> None:
        """Remove what was written; the log gets no file."""
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
    def _failing(self) -> Iterator[None]:
        """Turns a write that fails into the end of the log, and one line about it."""
        if not self._open:
            raise self._closed()
        try:
            yield
        except OSError as error:
            raise self._failed(error) from None

    def _closed(self) -> InputError:
        return InputError(self._failure or f"{self.path}: this log is closed already")

    def _failed(self, error: OSError) -> InputError:
        """End the log as far as it goes; why it goes no further, and what is safe."""
        why = f"{self.path}: cannot write this log: {error.strerror}"
        if self._whole:
            self.discard()
            self._failure = why
            return InputError(why)
        self._open = False
        with contextlib.suppress(OSError):
            self._file.finish()
        span = (self._file.until - self._file.first) * 1e-9
        self._failure = (
            f"{why}; {self._file.messages} messages over {span:.1f} s are safe in it, "
            f"the {self._file.pending} after them are lost"
        )
        return InputError(self._failure)


def _take(path: Path) -> int:
    """A new file of this name, open for writing. Raises FileExistsError where it is taken, OSError."""
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)


def _absolute(topic: str) -> str:
    return topic if topic.startswith("/") else f"/{topic}"
