"""A log's messages in memory, ready to be published: which topics, of which types, when."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.log.mcap_reader import McapReader
from slider_drilling.log.read import log_files
from slider_drilling.messages.topics import TOPICS, canonical_type, namespace_of
from slider_drilling.nodes import raw_topics

MADE_ANEW = (
    "clock",
    raw_topics.RIG_DESCRIPTION.name,
)  # the clock from the log times, the rig from the log's attachment


@dataclass(frozen=True)
class LoggedMessage:
    """One message: ns of its log time, its topic relative to the rig's namespace, its bytes."""

    time_ns: int
    topic: str
    data: bytes


@dataclass
class PlayedLog:
    """messages: in the order of their times; types: relative topic -> `package/msg/Name`; notes: what was left out."""

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
        """From the first message to the last."""
        return self.messages[-1].time_ns - self.messages[0].time_ns


def load(path: Path, topics: Iterable[str]) -> PlayedLog:
    """Read an MCAP file, or every one of a bag's folder. topics: those to play, without the rig's namespace; none: all.

    Raises InputError for what is no log, holds nothing to play, or lacks a topic that was asked for.
    """
    wanted = {name.strip("/") for name in topics if name}
    played = PlayedLog()
    for file in log_files(path):
        _read(file, wanted, played)
    absent = wanted - {message.topic for message in played.messages}
    if absent:
        raise InputError(f"{path}: has no {' and no '.join(sorted(absent))} to play")
    if not played.messages:
        raise InputError(f"{path}: no message that can be played")
    played.messages.sort(key=lambda one: one.time_ns)
    return played


def _read(path: Path, wanted: set[str], played: PlayedLog) -> None:
    container = McapReader(path)
    found = [(channel.id, message.log_time, message.data) for channel, message in container.messages()]
    own = _namespace(channel.topic for channel in container.channels.values())
    names: dict[int, str] = {}
    for channel in container.channels.values():
        name = channel.topic.removeprefix(own + "/").lstrip("/")
        schema = container.schemas.get(channel.schema_id)
        kind = "" if schema is None else schema.name
        if name in MADE_ANEW or (wanted and name not in wanted):
            continue
        if channel.message_encoding != "cdr" or not kind:
            played.notes.append(f"{channel.topic}: not played: encoded as {channel.message_encoding!r}, type {kind!r}")
            continue
        names[channel.id] = name
        played.types[name] = canonical_type(kind)
    played.messages += [
        LoggedMessage(time_ns, names[channel], data) for channel, time_ns, data in found if channel in names
    ]
    played.notes += [f"{path}: {note}" for note in container.notes]
    rig = next((one.data for one in container.attachments if one.name == "rig.yaml"), None)
    if rig is not None:
        played.rig_text = rig.decode("utf-8", "replace")


def _namespace(topics: Iterable[str]) -> str:
    """The namespace that the rig's topics of a log share; "" where there is none, or several rigs'."""
    found = {
        namespace
        for topic in topics
        for known in (*TOPICS.values(), raw_topics.PUMP_COMMAND)
        if (namespace := namespace_of(topic, known.name)) is not None
    }
    return found.pop() if len(found) == 1 else ""
