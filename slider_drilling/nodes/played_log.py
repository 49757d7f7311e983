"""Reads a log's messages into memory for publishing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.log.log_files import find_log_files, open_readers
from slider_drilling.log.log_reader import LogReader
from slider_drilling.messages.topics import (
    DRIVES_COMMAND,
    TOPICS,
    canonical_type,
    fitting_keys,
    is_of_twin,
    namespace_of,
)
from slider_drilling.nodes import raw_topics

# Topics that are not played: the clock follows from the log times, the description is the log's attachment.
REGENERATED = ("clock", raw_topics.RIG_DESCRIPTION.name)


@dataclass(frozen=True)
class LoggedMessage:
    """One message.

    Attributes:
        time_ns: Its log time.
        topic: Relative to the rig's namespace.
        data: Its bytes.
    """

    time_ns: int
    topic: str
    data: bytes


@dataclass
class PlayedLog:
    """A log to play.

    Attributes:
        messages: In the order of their log times.
        types: `package/msg/Name` by relative topic.
        notes: What is not played, and why.
        rig_text: The attached rig file.
    """

    messages: list[LoggedMessage] = field(default_factory=list)
    types: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    rig_text: str | None = None

    @property
    def begin_ns(self) -> int:
        """Log time of the first message."""
        return self.messages[0].time_ns

    @property
    def length_ns(self) -> int:
        """Log time from the first message to the last."""
        return self.messages[-1].time_ns - self.messages[0].time_ns


def load(path: Path, topics: Iterable[str], twin_topics: bool = True) -> PlayedLog:
    """Read a log for playing.

    Args:
        path: An MCAP file, or the folder of a bag.
        topics: Topics to play, without the rig's namespace; none: all.
        twin_topics: Whether to play what a twin said.

    Raises:
        InputError: The path is not a log, holds nothing to play or lacks one of the topics.
    """
    wanted = {name.strip("/") for name in topics if name}
    played = PlayedLog()
    found = find_log_files(path)
    played.notes += [f"{path}: {note}" for note in found.notes]
    for reader in open_readers(found.files):
        _read(reader, wanted, twin_topics, played)
    absent = wanted - {message.topic for message in played.messages}
    if absent:
        raise InputError(f"{path}: has no {' and no '.join(sorted(absent))} to play")
    if not played.messages:
        raise InputError(f"{path}: no message that can be played")
    played.messages.sort(key=lambda message: message.time_ns)
    return played


def _read(container: LogReader, wanted: set[str], twin_topics: bool, played: PlayedLog) -> None:
    messages = [(channel.id, message.log_time, message.data) for channel, message in container.messages()]
    own = _namespace(channel.topic for channel in container.channels.values())
    names: dict[int, str] = {}
    for channel in container.channels.values():
        name = channel.topic.removeprefix(own + "/").lstrip("/")
        schema = container.schemas.get(channel.schema_id)
        kind = "" if schema is None else schema.name
        if name in REGENERATED or (wanted and name not in wanted) or (is_of_twin(name) and not twin_topics):
            continue
        if channel.message_encoding != "cdr" or not kind:
            played.notes.append(f"{channel.topic}: not played: encoded as {channel.message_encoding!r}, type {kind!r}")
            continue
        names[channel.id] = name
        played.types[name] = canonical_type(kind)
    played.messages += [
        LoggedMessage(time_ns, names[channel], data) for channel, time_ns, data in messages if channel in names
    ]
    played.notes += [f"{container.path}: {note}" for note in container.notes]
    rig = next((item.data for item in container.attachments if item.name == "rig.yaml"), None)
    if rig is not None:
        played.rig_text = rig.decode("utf-8", "replace")


def _namespace(topics: Iterable[str]) -> str:
    """The namespace that the rig's topics of a log share; "" if there is none, or several rigs'."""
    commands = (raw_topics.PUMP_COMMAND.name, DRIVES_COMMAND.name)
    namespaces = {
        namespace
        for topic in topics
        for name in (*(TOPICS[key].name for key in fitting_keys(topic)), *commands)
        if (namespace := namespace_of(topic, name)) is not None
    }
    return namespaces.pop() if len(namespaces) == 1 else ""
