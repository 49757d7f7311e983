"""Follows a recording while a program writes it: an MCAP file, or the folder of a bag that gets more of them."""

from __future__ import annotations

from pathlib import Path

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.log.being_written import is_being_written
from slider_drilling.log.log_files import find_log_files
from slider_drilling.log.mcap_reader import McapReader, McapSection
from slider_drilling.log.mcap_records import MAGIC, FileBytes
from slider_drilling.log.timestamps import StampedSamples
from slider_drilling.log.topic_map import NO_TOPICS, TopicMap
from slider_drilling.log.topic_samples import SampleCollector


class RecordingFollower:
    """Reads what has been added since it last looked.

    Args:
        path: The file or folder.
        namespace, topics: As in `slider_drilling.log.read_log`.

    Attributes:
        path: The file or folder.
        rig_text: The rig file's text, once the recording shows it; None before.
    """

    def __init__(self, path: Path, namespace: str | None = None, topics: TopicMap = NO_TOPICS) -> None:
        self.path, self._namespace = path, namespace
        self._collector = SampleCollector(topics)
        self._files: dict[Path, _FollowedFile] = {}
        self.rig_text: str | None = None

    @property
    def being_written(self) -> bool:
        """Whether a program of this machine is writing to it."""
        return is_being_written(_parts(self.path)[-1])

    @property
    def ended(self) -> bool:
        """Whether the last of its files is complete."""
        return bool(self._files) and next(reversed(self._files.values())).ended

    def poll(self) -> dict[str, StampedSamples]:
        """New samples by their keys in the registry of topics.

        Raises:
            InputError: It cannot be read, or holds two rigs.
        """
        for part in _parts(self.path):
            file = self._files.setdefault(part, _FollowedFile(part))
            if not file.ended:
                file.read(self._collector)
            self.rig_text = self.rig_text or file.rig_text()
        found = {}
        for key, samples in self._collector.choose(self._namespace, printable(str(self.path))).items():
            if samples.parts:
                found[key] = samples.track()
        for every in self._collector.samples.values():
            every.parts, every.order = [], []
        return found


class _FollowedFile:
    """One file, and how far it was read."""

    def __init__(self, path: Path) -> None:
        self.ended = False
        self._reader = McapReader(path)
        self._section: McapSection | None = None
        self._at = len(MAGIC)

    def read(self, collector: SampleCollector) -> None:
        """Give the collector the messages of the records that are whole by now."""
        path = self._reader.path
        try:
            with path.open("rb") as file:
                source = FileBytes(file)
                if source.size < len(MAGIC):
                    return
                if source.read(0, len(MAGIC)) != MAGIC:
                    raise InputError(f"{path}: not an MCAP file; only MCAP can be watched while it is recorded")
                self._section = self._section or McapSection(self._reader, source, self._at)
                blocks, self._at, self.ended = self._section.read_whole_records(source, self._at)
        except OSError as error:
            raise InputError(f"{path}: cannot read this log: {error.strerror}") from None
        for block in blocks:
            collector.add(self._reader, block)

    def rig_text(self) -> str | None:
        """The attachment rig.yaml, as text."""
        for attachment in self._reader.attachments:
            if Path(attachment.name).name == "rig.yaml":
                return attachment.data.decode("utf-8", "replace")
        return None


def _parts(path: Path) -> tuple[Path, ...]:
    """The files so far. Raises InputError where there is none."""
    if not path.exists():
        raise InputError(f"{path}: no such log; check the path")
    return find_log_files(path).files
