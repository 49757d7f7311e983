"""From a running rig or simulation to an MCAP file; no ROS needed."""

from __future__ import annotations

import datetime
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, cast

from mcap.writer import Writer

from slider_drilling import __version__
from slider_drilling.errors import InputError
from slider_drilling.files import begin_file, end_file
from slider_drilling.messages import cdr
from slider_drilling.messages.schemas import SCHEMAS
from slider_drilling.messages.topics import DIAGNOSTIC_ARRAY, FLUID_PRESSURE, JOINT_STATE, WRENCH_STAMPED

# A killed run loses the open chunk: this much is about five seconds of a rig's channels at 10 Hz.
CHUNK_BYTES = 64 * 1024


@dataclass(frozen=True)
class Status:
    """One diagnostic_msgs/DiagnosticStatus: level 0 ok, 1 warning, 2 error, 3 stale."""

    level: int
    name: str
    message: str
    hardware_id: str = ""
    values: tuple[tuple[str, str], ...] = ()


class DirectFile:
    """A file that holds nothing back: a killed run loses the open chunk, a full disk is heard of once."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._written = 0
        self._open = True

    def write(self, data: bytes) -> int:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(self._descriptor, rest) :]
        self._written += len(data)
        return len(data)

    def tell(self) -> int:
        return self._written

    def close(self) -> None:
        if self._open:
            self._open = False
            os.close(self._descriptor)


def nanoseconds(seconds: float) -> int:
    """Whole ns of a time in s."""
    return round(seconds * 1e9)


class LogWriter:
    """Writes one log. Messages go to a file beside the log, which takes the log's name when closed.

    Use it as a context manager: leaving it closes the log, leaving it through an error (but not through an
    interrupt) removes what was written. A run that is killed leaves the file `.NAME.*.part` beside the log, which
    read_log and `mcap recover` read up to the last complete chunk.

    Stamps are s of the rig's (or the simulation's) clock; log_time_s is when the message arrived, the stamp if not
    given; started is when the recording began, now if not given. Topics get a leading slash if they have none. Raises
    InputError where the file cannot be written.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        rig_text: str | None = None,
        recorded_by: str = "",
        notes: str = "",
        started: datetime.datetime | None = None,
    ) -> None:
        self.path = Path(path)
        if self.path.is_dir():
            raise InputError(f"{self.path}: cannot write this log: it is a folder; name a file in it")
        try:
            descriptor, self._part = begin_file(self.path)
        except OSError as error:
            raise self._unwritable(error) from None
        self._file = DirectFile(descriptor)
        self._open = True
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._sequence: dict[str, int] = {}
        try:
            self._writer = Writer(cast(IO[bytes], self._file), chunk_size=CHUNK_BYTES)
            self._writer.start(profile="ros2", library=f"slider_drilling {__version__}")
            self._describe(rig_text, recorded_by, notes, started)
        except OSError as error:
            raise self._failed(error) from None

    def attach_rig(self, rig_text: str) -> None:
        """Add the rig file, where it was not known when the log was begun."""
        try:
            self._writer.add_attachment(0, 0, "rig.yaml", "application/yaml", rig_text.encode("utf-8"))
        except OSError as error:
            raise self._failed(error) from None

    def _describe(
        self, rig_text: str | None, recorded_by: str, notes: str, started: datetime.datetime | None
    ) -> None:
        """The rig file and the metadata record, at the front so that a broken-off file has them too."""
        if rig_text is not None:
            self.attach_rig(rig_text)
        begun = (started or datetime.datetime.now(datetime.timezone.utc)).isoformat(timespec="seconds")
        record = {"version": __version__, "recorded_by": recorded_by, "start_time": begun, "notes": notes}
        self._writer.add_metadata("slider_drilling", record)

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
        self._write(topic, JOINT_STATE, cdr.joint_state(stamp, name, position, velocity, effort), stamp, log_time_s)

    def fluid_pressure(
        self, topic: str, stamp_s: float, pressure: float, variance: float = 0.0, log_time_s: float | None = None
    ) -> None:
        """A pressure, Pa, and its variance, Pa2; 0 says that the variance is not known."""
        known = 0.0 if math.isnan(variance) else float(variance)
        stamp = nanoseconds(stamp_s)
        self._write(topic, FLUID_PRESSURE, cdr.fluid_pressure(stamp, pressure, known), stamp, log_time_s)

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
        self._write(topic, WRENCH_STAMPED, cdr.wrench_stamped(stamp, force, torque), stamp, log_time_s)

    def diagnostics(
        self, topic: str, stamp_s: float, status: Sequence[Status], log_time_s: float | None = None
    ) -> None:
        """The health of one node's parts."""
        stamp = nanoseconds(stamp_s)
        rows = [(one.level, one.name, one.message, one.hardware_id, one.values) for one in status]
        self._write(topic, DIAGNOSTIC_ARRAY, cdr.diagnostic_array(stamp, rows), stamp, log_time_s)

    def message(self, topic: str, kind: str, data: bytes, log_time_ns: int, publish_time_ns: int) -> None:
        """A message as it came, CDR bytes of a type in SCHEMAS; times are ns, of its arrival and of its sending."""
        name = topic if topic.startswith("/") else f"/{topic}"
        if log_time_ns < 0:
            raise InputError(f"{self.path}: {name}: logged at {log_time_ns * 1e-9:g} s, before the clock's zero")
        sequence = self._sequence.get(name, 0)
        self._sequence[name] = sequence + 1
        try:
            if name not in self._channels:
                self._channels[name] = self._register(name, kind)
            self._writer.add_message(self._channels[name], log_time_ns, data, publish_time_ns, sequence)
        except OSError as error:
            raise self._failed(error) from None

    def _register(self, topic: str, kind: str) -> int:
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", SCHEMAS[kind].encode())
        return self._writer.register_channel(topic, "cdr", self._schemas[kind])

    def close(self) -> None:
        """Finish the log and give it its name. Raises InputError where that fails; nothing is left then."""
        if not self._open:
            return
        try:
            self._writer.finish()
            self._file.close()
            end_file(self._part, self.path)
        except OSError as error:
            raise self._failed(error) from None
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
        if isinstance(error, Exception):
            self.discard()
        else:
            self.close()

    def _write(self, topic: str, kind: str, data: bytes, stamp: int, log_time_s: float | None) -> None:
        logged = stamp if log_time_s is None else nanoseconds(log_time_s)
        self.message(topic, kind, data, logged, logged)

    def _unwritable(self, error: OSError) -> InputError:
        return InputError(f"{self.path}: cannot write this log: {error.strerror}")

    def _failed(self, error: OSError) -> InputError:
        """Remove the unfinished file, then say why the log cannot be written."""
        self.discard()
        return self._unwritable(error)
