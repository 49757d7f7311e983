"""Writes a recording as a rosbag2 bag: a folder of MCAP files and the metadata.yaml that lists them."""

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
from slider_drilling.log.log_files import METADATA
from slider_drilling.log.write import LogWriter, MessageCounts

EMPTY = MessageCounts(0, 0, {})
VERSION = 9  # of the format of metadata.yaml in ROS 2 Jazzy and later


@dataclass(frozen=True)
class RecordedTopic:
    """One topic of a bag.

    Attributes:
        topic: Its name.
        message_type: ``package/msg/Name``.
        schema: The ros2msg definition of the type.
        qos: Quality of service that its publishers offer.
        type_hash: Hash of the type's description, "RIHS01_..."; empty where unknown.
    """

    topic: str
    message_type: str
    schema: str
    qos: tuple[dict[str, Any], ...] = ()
    type_hash: str = ""

    def channel_metadata(self) -> dict[str, str]:
        """Metadata of its MCAP channel, as rosbag2 writes it."""
        profiles = yaml.safe_dump([*self.qos], sort_keys=False) if self.qos else ""
        return {"offered_qos_profiles": profiles, "topic_type_hash": self.type_hash}


@dataclass(frozen=True)
class BagSettings:
    """How a bag is written.

    Attributes:
        rig_text: The rig file to attach.
        recorded_by: What records it, for the metadata.
        notes: Free text for the metadata.
        split_bytes: Size at which a new file starts; 0 for never.
        split_s: Duration after which a new file starts, s; 0 for never.
        programme_text: The programme to attach.
    """

    rig_text: str | None = None
    recorded_by: str = ""
    notes: str = ""
    split_bytes: int = 0
    split_s: float = 0.0
    programme_text: str | None = None


@dataclass
class BagFile:
    """One file of a bag, and what it held when metadata.yaml was written last."""

    name: str
    written: MessageCounts = EMPTY


class BagWriter:
    """Writes messages to a bag. What has been recorded is kept, whatever ends the recording.

    Methods raise InputError where the bag cannot be written.

    Args:
        directory: Folder that becomes the bag; it is made if missing. If it is a bag already, a recording with a file
            name is written beside that bag and is not in its metadata.yaml; one without becomes a bag in a subfolder.
        file: Name of the first file, ending in .mcap; empty for slide_ and the time.
        settings: How to write it.

    Attributes:
        folder: The folder of the files.
        is_bag: Whether metadata.yaml in it is written for this recording.
    """

    def __init__(self, directory: Path, file: str, settings: BagSettings) -> None:
        self._settings = settings
        self._rig_text = settings.rig_text
        self._topics: dict[str, RecordedTopic] = {}
        self._stem = Path(file).stem if file else f"slide_{datetime.datetime.now().astimezone():%Y%m%d_%H%M%S}"
        self.folder, self.is_bag = _claim_folder(directory, self._stem, named=bool(file))
        self._made_subfolder = self.folder != directory
        self._files: list[BagFile] = []
        self._declared: set[str] = set()
        self._file_start_ns: int | None = None
        try:
            self._writer = self._open_next_file()
        except BaseException:
            self._release_names()
            raise
        try:
            self._write_metadata()
        except BaseException:
            self.discard()
            raise

    @property
    def path(self) -> Path:
        """The file that is being written."""
        return self.folder / self._files[-1].name

    def declare(self, topic: RecordedTopic) -> None:
        """Add a topic, or replace its description."""
        self._topics[topic.topic] = topic

    def message(self, topic: str, data: bytes, log_time: int, sequence: int | None = None) -> None:
        """Add a message of a declared topic as CDR; `log_time` in ns; `sequence` counts lost messages, too."""
        if self._is_full(log_time):
            self.split()
        recorded = self._topics[topic]
        if topic not in self._declared:
            self._declared.add(topic)
            self._writer.declare(topic, recorded.message_type, recorded.schema, recorded.channel_metadata())
        self._writer.message(topic, recorded.message_type, data, log_time, log_time, sequence)

    def attach_rig(self, rig_text: str) -> None:
        """Attach the rig file to this file and to those that follow."""
        self._rig_text = rig_text
        self._writer.attach_rig(rig_text)

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Add a metadata record to this file."""
        self._writer.add_metadata(name, values)

    def flush(self) -> None:
        """Write out the messages so far."""
        self._writer.flush()

    def split(self) -> None:
        """Continue in a new file."""
        self._writer.close()
        self._files[-1].written = self._writer.message_counts()
        self._writer = self._open_next_file()
        self._write_metadata()

    def close(self) -> None:
        """Finish the bag. An InputError says what is saved."""
        try:
            self._writer.close()
        finally:
            self._files[-1].written = self._writer.message_counts()
            # On a full disk metadata.yaml stays as it was written when the file was opened.
            with contextlib.suppress(InputError):
                self._write_metadata()

    def discard(self) -> None:
        """Delete the files: nothing was recorded."""
        self._writer.discard()
        self._release_names()

    def _is_full(self, log_time: int) -> bool:
        limits = self._settings
        if self._file_start_ns is None:
            self._file_start_ns = log_time
            return False
        return bool(limits.split_bytes and self._writer.size >= limits.split_bytes) or bool(
            limits.split_s and log_time - self._file_start_ns >= limits.split_s * 1e9
        )

    def _open_next_file(self) -> LogWriter:
        """The writer of the next file."""
        number = len(self._files)
        name = f"{self._stem}_{number}.mcap" if number else f"{self._stem}.mcap"
        settings = self._settings
        writer = LogWriter(self.folder / name, self._rig_text, settings.recorded_by, settings.notes)
        if settings.programme_text is not None:
            writer.attach_programme(settings.programme_text)
        self._files.append(BagFile(name))
        self._declared.clear()
        self._file_start_ns = None
        return writer

    def _write_metadata(self) -> None:
        if self.is_bag:
            text = yaml.safe_dump(_metadata(self._files, self._topics), sort_keys=False)
            write_atomically(self.folder / METADATA, text.encode())

    def _release_names(self) -> None:
        """Remove metadata.yaml and the subfolder that were made."""
        if self.is_bag:
            (self.folder / METADATA).unlink(missing_ok=True)
        if self._made_subfolder:
            with contextlib.suppress(OSError):
                self.folder.rmdir()


def _claim_folder(directory: Path, stem: str, named: bool) -> tuple[Path, bool]:
    """The folder for the files, and whether this recording owns metadata.yaml in it: the one that created it does."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
        if _claim_metadata(directory):
            return directory, True
        if named:
            return directory, False
        for number in range(1, 1000):
            folder = directory / (stem if number == 1 else f"{stem}_{number}")
            with contextlib.suppress(FileExistsError):
                folder.mkdir()
                return folder, _claim_metadata(folder)
    except OSError as error:
        raise InputError(f"{directory}: cannot make this folder for logs: {error.strerror}") from None
    raise InputError(f"{directory}: holds a thousand recordings named {stem} already; give another folder")


def _claim_metadata(folder: Path) -> bool:
    """Create metadata.yaml; whether it was not there before."""
    try:
        os.close(os.open(folder / METADATA, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
    except FileExistsError:
        return False
    return True


def _metadata(files: list[BagFile], topics: dict[str, RecordedTopic]) -> dict[str, Any]:
    """The content of metadata.yaml."""
    filled = [file.written for file in files if file.written.counts]
    first = min((written.first for written in filled), default=0)
    last = max((written.last for written in filled), default=0)
    counts = sum((Counter(written.counts) for written in filled), Counter[str]())
    listed = [
        {
            "topic_metadata": {
                "name": topic, "type": described.message_type, "serialization_format": "cdr",
                "offered_qos_profiles": [*described.qos], "type_description_hash": described.type_hash,
            },
            "message_count": counts[topic],
        }
        for topic, described in topics.items()
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
            "relative_file_paths": [file.name for file in files],
            "files": [
                {
                    "path": file.name,
                    "starting_time": {"nanoseconds_since_epoch": file.written.first},
                    "duration": {"nanoseconds": file.written.last - file.written.first},
                    "message_count": sum(file.written.counts.values()),
                }
                for file in files
            ],
            "custom_data": None,
            "ros_distro": os.environ.get("ROS_DISTRO", "jazzy"),
        }
    }
