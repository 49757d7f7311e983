"""A message type's definition and a publisher's quality of service as a log stores them."""

from __future__ import annotations

import re
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import QoSProfile

from slider_drilling.messages.message_types import MESSAGE_TYPES, join_definitions
from slider_drilling.nodes.raw_topics import message_class

# Basic types whose names differ between IDL and .msg files.
_NAMES = {"boolean": "bool", "octet": "byte", "float": "float32", "double": "float64"}
_BOUND = re.compile(r"(sequence)<(.+?)(?:, (\d+))?>|(.+)\[(\d+)\]|(w?string)<(\d+)>")


def message_definition(kind: str) -> str:
    """The ros2msg definition of `package/msg/Name`, followed by those of the types that it uses.

    Raises:
        ImportError: The type's package is not installed.
        AttributeError: The package has no such type.
    """
    if kind in MESSAGE_TYPES:
        return MESSAGE_TYPES[kind].definition
    found: dict[str, str] = {}
    _collect(kind, found)
    own = found.pop(kind)
    return join_definitions(own, {name.replace("/msg/", "/"): text for name, text in found.items()})


def _collect(kind: str, found: dict[str, str]) -> None:
    """Add the definitions of the type and of those it uses."""
    lines = []
    used = []
    for name, idl in message_class(kind).get_fields_and_field_types().items():
        base, written = _field(idl)
        lines.append(f"{written} {name}\n")
        if "/" in base:
            package, _, message = base.partition("/")
            used.append(f"{package}/msg/{message.removeprefix('msg/')}")
    found[kind] = "".join(lines)
    for other in used:
        if other not in found:
            _collect(other, found)


def _field(idl: str) -> tuple[str, str]:
    """A field's element type, and its type as a .msg file writes it."""
    match = _BOUND.fullmatch(idl)
    if match is None:
        return idl, _NAMES.get(idl, idl)
    _, item, bound, element, length, text, size = match.groups()
    if text:
        return text, f"{text}<={size}"
    base, written = _field(item or element)
    if element:
        return base, f"{written}[{length}]"
    return base, f"{written}[<={bound}]" if bound else f"{written}[]"


def qos_as_metadata(profile: QoSProfile) -> dict[str, Any]:
    """A publisher's quality of service as metadata.yaml writes it."""
    return {
        "history": profile.history.short_key,
        "depth": profile.depth,
        "reliability": profile.reliability.short_key,
        "durability": profile.durability.short_key,
        "deadline": _time(profile.deadline),
        "lifespan": _time(profile.lifespan),
        "liveliness": profile.liveliness.short_key,
        "liveliness_lease_duration": _time(profile.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": profile.avoid_ros_namespace_conventions,
    }


def _time(duration: Duration) -> dict[str, int]:
    sec, nsec = divmod(duration.nanoseconds, 1_000_000_000)
    return {"sec": sec, "nsec": nsec}
