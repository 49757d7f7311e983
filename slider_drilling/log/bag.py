"""A recording as a rosbag2 bag: a folder of MCAP parts and the metadata.yaml that lists them."""

from __future__ import annotations

import contextlib
import datetime
import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import write_atomically
from slider_drilling.log.write import LogWriter, MessageCounts

METADATA = "metadata.yaml"
NOTHING = MessageCounts(0, 0, {})
VERSION = 9  # of metadata.yaml: ROS 2 Jazzy and later


@dataclass(frozen=True)
class RecordedTopic:
    """One topic of a bag. kind: `package/msg/Name`; schema: its ros2msg definition; qos: what its publishers offer.

    type_hash: of the type's description, "RIHS01_...", empty where it is not known.
    """

    topic: str
    message_type: str
    schema: str
    qos: tuple[dict[str, Any], ...] = ()
    type_hash: str = ""

    def channel_metadata(self) -> dict[str, str]:
        """As rosbag2 writes it into an MCAP file."""
        profiles = yaml.safe_dump([*self.qos], sort_keys=False) if self.qos else ""
        return {"offered_qos_profiles": profiles, "topic_type_hash": self.type_hash}


@dataclass(frozen=True)
class BagSettings:
    """How a bag is written. split_bytes, split_s: size and duration at which a new part begins; 0 for never."""

    rig_text: str | None = None
    recorded_by: str = ""
    notes: str = ""
    split_bytes: int = 0
    split_s: float = 0.0


@dataclass
class BagFile:
    """One file of a bag; written: what is in it, as of the last time that metadata.yaml was written."""

    name: str
    written: MessageCounts = NOTHING


class BagWriter:
    """Writes messages to a bag. What has come in is kept, whatever ends the recording.

    directory: becomes the bag, made where it is missing. Where it is one already, a recording with a name of its own
    stands beside it, its parts not in metadata.yaml; one without a name becomes a bag in a folder within. file: name
    of the first part, ending in .mcap; empty for slide_ and the time. Raises InputError where any of that fails.
    """

    def __init__(self, directory: Path, file: str, settings: BagSettings) -> None:
        self._settings = settings
        self._rig_text = settings.rig_text
        self._topics: dict[str, RecordedTopic] = {}
        self._stem = Path(file).stem if file else f"slide_{datetime.datetime.now().astimezone():%Y%m%d_%H%M%S}"
        self.folder, self.is_bag = _take_folder(directory, self._stem, named=bool(file))
        self._inside = self.folder != directory
        self._parts: list[BagFile] = []
        self._declared: set[str] = set()
        self._part_began: int | None = None
        try:
            self._writer = self._begin_part()
        except BaseException:
            self._forget()
            raise
        try:
            self._write_metadata()
        except BaseException:
            self.discard()
            raise

    @property
    def path(self) -> Path:
        """The part that is being written."""
        return self.folder / self._parts[-1].name

    def declare(self, topic: RecordedTopic) -> None:
        """Add a topic, or replace what is known of it. Raises InputError."""
        self._topics[topic.topic] = topic

    def message(self, topic: str, data: bytes, log_time: int, sequence: int | None = None) -> None:
        """Add a message of a declared topic as it came; log_time: ns; sequence: counts lost ones too."""
        if self._is_full(log_time):
            self.split()
        recorded = self._topics[topic]
        if topic not in self._declared:
            self._declared.add(topic)
            self._writer.declare(topic, recorded.message_type, recorded.schema, recorded.channel_metadata())
        self._writer.message(topic, recorded.message_type, data, log_time, log_time, sequence)

    def attach_rig(self, rig_text: str) -> None:
        """Add the rig file, to this part and to those that follow. Raises InputError."""
        self._rig_text = rig_text
        self._writer.attach_rig(rig_text)

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Add a metadata record to this part. Raises InputError."""
        self._writer.add_metadata(name, values)

    def flush(self) -> None:
        """Write out what has come in. Raises InputError."""
        self._writer.flush()

    def split(self) -> None:
        """Go on in a new part. Raises InputError."""
        self._writer.close()
        self._parts[-1].written = self._writer.message_counts()
        self._writer = self._begin_part()
        self._write_metadata()

    def close(self) -> None:
        """Finish the bag. Raises InputError where that fails, saying what is safe."""
        try:
            self._writer.close()
        finally:
            self._parts[-1].written = self._writer.message_counts()
            # The messages are what counts: where the disk is full, metadata.yaml stays as the part's beginning left it.
            with contextlib.suppress(InputError):
                self._write_metadata()

    def discard(self) -> None:
        """Leave nothing: what was to be recorded never began."""
        self._writer.discard()
        self._forget()

    def _is_full(self, log_time: int) -> bool:
        limits = self._settings
        if self._part_began is None:
            self._part_began = log_time
            return False
        return bool(limits.split_bytes and self._writer.size >= limits.split_bytes) or bool(
            limits.split_s and log_time - self._part_began >= limits.split_s * 1e9
        )

    def _begin_part(self) -> LogWriter:
        """The next part, open for writing."""
        number = len(self._parts)
        name = f"{self._stem}_{number}.mcap" if number else f"{self._stem}.mcap"
        settings = self._settings
        writer = LogWriter(self.folder / name, self._rig_text, settings.recorded_by, settings.notes)
        self._parts.append(BagFile(name))
        self._declared.clear()
        self._part_began = None
        return writer

    def _write_metadata(self) -> None:
        if self.is_bag:
            text = yaml.safe_dump(_metadata(self._parts, self._topics), sort_keys=False)
            write_atomically(self.folder / METADATA, text.encode())

    def _forget(self) -> None:
        """Give back the names that were taken."""
        if self.is_bag:
            (self.folder / METADATA).unlink(missing_ok=True)
        if self._inside:
            with contextlib.suppress(OSError):
                self.folder.rmdir()


def _take_folder(directory: Path, stem: str, named: bool) -> tuple[Path, bool]:
    """The folder for the parts, and whether metadata.yaml in it is ours to write: whoever makes that file has it."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
        if _take_metadata(directory):
            return directory, True
        if named:
            return directory, False
        for number in range(1, 1000):
            folder = directory / (stem if number == 1 else f"{stem}_{number}")
            with contextlib.suppress(FileExistsError):
                folder.mkdir()
                return folder, _take_metadata(folder)
    except OSError as error:
        raise InputError(f"{directory}: cannot make this folder for logs: {error.strerror}") from None
    raise InputError(f"{directory}: holds a thousand recordings named {stem} already; give another folder")


def _take_metadata(folder: Path) -> bool:
    """Whether metadata.yaml was not there and is now."""
    try:
        os.close(os.open(folder / METADATA, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
    except FileExistsError:
        return False
    return True


def _metadata(parts: list[BagFile], topics: dict[str, RecordedTopic]) -> dict[str, Any]:
    """What metadata.yaml says."""
    filled = [part.written for part in parts if part.written.counts]
    first, last = min((one.first for one in filled), default=0), max((one.last for one in filled), default=0)
    counts = sum((Counter(one.counts) for one in filled), Counter[str]())
    listed = [
        {
            "topic_metadata": {
                "name": topic, "type": one.message_type, "serialization_format": "cdr",
                "offered_qos_profiles": [*one.qos], "type_description_hash": one.type_hash,
            },
            "message_count": counts[topic],
        }
        for topic, one in topics.items()
    ]  # fmt: skip
    return {
        "rosbag2_bagfile_information": {
            "version": VERSION,
            "storage_identifier": "mcap",
            "duration": {"nanoseconds": last - first},
            "starting_time": {"nanoseconds_since_epoch": first},
            "message_count": sum(counts.values()),
            "topics_with_message_count": listed,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [part.name for part in parts],
            "files": [
                {
                    "path": part.name,
                    "starting_time": {"nanoseconds_since_epoch": part.written.first},
                    "duration": {"nanoseconds": part.written.last - part.written.first},
                    "message_count": sum(part.written.counts.values()),
                }
                for part in parts
            ],
            "custom_data": None,
            "ros_distro": os.environ.get("ROS_DISTRO", "jazzy"),
        }
    }
