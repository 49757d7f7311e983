"""A file that says which topic of a log is which channel of a rig, for logs whose topics have other names."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.messages.message_types import JOINT_STATE
from slider_drilling.messages.topics import TOPICS
from slider_drilling.schema.yaml_tree import parse_yaml

_KEYS = ("topic", "joint", "channel")


@dataclass(frozen=True)
class TopicChoice:
    """Where a log holds one series.

    Attributes:
        topic: Name of the topic in the log.
        joint: Name or index of the joint, where the topic holds several; None for the registry's name.
        channel: Id of the MCAP channel, where several publishers send on the topic; None for all.
    """

    topic: str
    joint: str | int | None = None
    channel: int | None = None


TopicMap = Mapping[str, TopicChoice]
NO_TOPICS: TopicMap = MappingProxyType({})


def read_topic_map(path: str | os.PathLike[str]) -> dict[str, TopicChoice]:
    """Read a topics file: for each key of the registry a topic, or `topic`, `joint` and `channel`.

    Raises:
        InputError: The file cannot be read, or an entry is unknown or invalid.
    """
    tree = parse_yaml(read_text(path, "topics file"), str(path))
    if not isinstance(tree, dict) or not tree:
        raise InputError(f"{path}: no topics; give lines such as `top_drive: {{topic: /joint_states, joint: rotary}}`")
    choices = {str(key): _choice(str(path), str(key), entry) for key, entry in tree.items()}
    for key, choice in choices.items():
        twin = next((other for other in choices if other != key and choices[other] == choice), None)
        if twin is not None:
            raise InputError(f"{path}: {key} and {twin} are the same topic and joint; each needs its own")
    return choices


def _choice(path: str, key: str, entry: Any) -> TopicChoice:
    """One entry. Raises InputError where it is invalid."""
    if key not in TOPICS:
        raise InputError(f"{path}: {key}: no such channel of a rig; use one of {', '.join(TOPICS)}")
    parts = {"topic": entry} if isinstance(entry, str) else entry
    if not isinstance(parts, dict) or not isinstance(parts.get("topic"), str) or not parts["topic"].strip("/"):
        raise InputError(f"{path}: {key}: give the name of its topic, or `topic` and `joint`")
    unknown = [str(name) for name in parts if name not in _KEYS]
    if unknown:
        raise InputError(f"{path}: {key}: unknown key {unknown[0]}; use {', '.join(_KEYS)}")
    joint, channel = parts.get("joint"), parts.get("channel")
    if joint is not None and TOPICS[key].type != JOINT_STATE:
        raise InputError(f"{path}: {key}: joint: a {TOPICS[key].message_type().short_name} has no joints; leave it out")
    if isinstance(joint, bool) or not isinstance(joint, (str, int, type(None))):
        raise InputError(f"{path}: {key}: joint: {joint!r} is neither a name nor an index, which counts from 0")
    if isinstance(channel, bool) or not isinstance(channel, (int, type(None))):
        raise InputError(f"{path}: {key}: channel: {channel!r} is no channel; see `slider-drilling info --json`")
    return TopicChoice(f"/{parts['topic'].strip('/')}", joint, channel)
