"""The mapping file: which node of a rig's server holds what, and in which unit."""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.schema.yaml_tree import parse_yaml, shorten
from slider_drilling.units import si_factor


@dataclass(frozen=True)
class Quantity:
    """A quantity that a rig gives or takes.

    Attributes:
        topic: Key of its topic.
        place: 0 position, 1 velocity, 2 effort in a joint state.
        kind: Of its unit, a key of `units.KINDS`.
    """

    topic: str
    place: int
    kind: str


READ = {
    "top_drive_angle": Quantity("top_drive", 0, "angle"),
    "top_drive_speed": Quantity("top_drive", 1, "angular speed"),
    "surface_torque": Quantity("top_drive", 2, "torque"),
    "block_position": Quantity("draw_works", 0, "length"),
    "block_speed": Quantity("draw_works", 1, "speed"),
    "hook_load": Quantity("draw_works", 2, "force"),
    "standpipe_pressure": Quantity("standpipe_pressure", 0, "pressure"),
    "pump_speed": Quantity("mud_pump", 1, "angular speed"),
    "mwd_tool_face": Quantity("mwd_tool_face", 0, "angle"),
}
WRITE = {
    "top_drive_angle": Quantity("top_drive_command", 0, "angle"),
    "top_drive_speed": Quantity("top_drive_command", 1, "angular speed"),
    "block_speed": Quantity("draw_works_command", 1, "speed"),
    "pump_speed": Quantity("pump_command", 1, "angular speed"),
}
KEEP, ZERO, HOLD = "keep", "zero", "hold"
# What is written when commands end. A pump that stops buries the string, so it goes on, as in the simulator.
AT_END = {"top_drive_angle": HOLD, "top_drive_speed": ZERO, "block_speed": ZERO, "pump_speed": KEEP}
_TOP_KEYS = ("url", "period", "heartbeat", "heartbeat_timeout", "command_timeout", "user", "password_file", "security",
             "read", "write")  # fmt: skip


@dataclass(frozen=True)
class Point:
    """One value on the server.

    Attributes:
        node: Its node id.
        factor: SI units in one of its units.
        low: Smallest command, SI.
        high: Largest command, SI.
        at_end: What is written when commands end: "zero", "hold" (the measured value) or "keep" (nothing).
    """

    node: str
    factor: float
    low: float = -math.inf
    high: float = math.inf
    at_end: str = KEEP


@dataclass(frozen=True)
class RigMapping:
    """A mapping file.

    Attributes:
        url: Of the server, ``opc.tcp://HOST:PORT/PATH``.
        period: Time between two samples, s.
        heartbeat: Node whose value changes while the rig is alive; "" for none.
        heartbeat_timeout: Time after which a heartbeat that stands still is dead, s.
        command_timeout: Time after which a command is too old, s.
        user: Name for the server; "" for none.
        password_file: File with the user's password.
        security: ``Policy,Mode,certificate file,key file`` as asyncua takes it; "" for none.
        read: What the rig gives.
        write: What it takes.
    """

    url: str
    period: float = 0.1
    heartbeat: str = ""
    heartbeat_timeout: float = 1.0
    command_timeout: float = 0.5
    user: str = ""
    password_file: str = ""
    security: str = ""
    read: dict[str, Point] = field(default_factory=dict)
    write: dict[str, Point] = field(default_factory=dict)


def load_mapping(path: Path) -> RigMapping:
    """Read a mapping file. Raises InputError that names file, key and value."""
    where = str(path)
    tree = _table(parse_yaml(read_text(path, "mapping file"), where), where, "top level", _TOP_KEYS)
    url = _text(tree, where, "url")
    if not url.startswith("opc.tcp://"):
        raise InputError(f"{where}: url = {shorten(url)}: must start with opc.tcp://")
    read = {name: _point(where, f"read.{name}", raw, READ[name]) for name, raw in _part(tree, where, "read", READ)}
    if not read:
        raise InputError(f"{where}: read: missing; name at least one node that the rig gives")
    write = {
        name: _point(where, f"write.{name}", raw, WRITE[name], AT_END[name])
        for name, raw in _part(tree, where, "write", WRITE)
    }
    held = [name for name, point in write.items() if point.at_end == HOLD and name not in read]
    if held:
        raise InputError(f"{where}: write.{held[0]}: at_end = hold needs read.{held[0]}; add it, or use keep")
    return RigMapping(
        url=url,
        period=_number(tree, where, "period", 0.1, 0.01, 10.0),
        heartbeat=_text(tree, where, "heartbeat", ""),
        heartbeat_timeout=_number(tree, where, "heartbeat_timeout", 1.0, 0.05, 60.0),
        command_timeout=_number(tree, where, "command_timeout", 0.5, 0.05, 60.0),
        user=_text(tree, where, "user", ""),
        password_file=_text(tree, where, "password_file", ""),
        security=_text(tree, where, "security", ""),
        read=read,
        write=write,
    )


def _part(tree: dict[str, Any], where: str, name: str, known: dict[str, Quantity]) -> list[tuple[str, Any]]:
    return list(_table(tree.get(name) or {}, where, name, tuple(known)).items())


def _point(where: str, key: str, raw: Any, quantity: Quantity, at_end: str | None = None) -> Point:
    """One entry; at_end: the default of a command, None for a measured value."""
    keys = ("node", "unit") if at_end is None else ("node", "unit", "low", "high", "at_end")
    entry = _table(raw, where, key, keys)
    factor = si_factor(_text(entry, where, "unit", key=key), quantity.kind, f"{where}: {key}")
    node = _text(entry, where, "node", key=key)
    if at_end is None:
        return Point(node, factor)
    low = _number(entry, where, "low", -math.inf, key=key) * factor
    high = _number(entry, where, "high", math.inf, key=key) * factor
    if low > high:
        raise InputError(f"{where}: {key}: low = {entry['low']} is above high = {entry['high']}; exchange them")
    chosen = _text(entry, where, "at_end", at_end, key=key)
    allowed = (HOLD, KEEP) if at_end == HOLD else (ZERO, KEEP)
    if chosen not in allowed:
        raise InputError(f"{where}: {key}.at_end = {chosen!r}: must be {' or '.join(allowed)}")
    return Point(node, factor, low, high, chosen)


def _table(raw: Any, where: str, key: str, known: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(raw, dict):
        raise InputError(f"{where}: {key} = {shorten(raw)}: expected keys and values")
    for name in raw:
        if name not in known:
            near = difflib.get_close_matches(str(name), known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"
            raise InputError(f"{where}: {key}: unknown {name}; {hint}")
    return raw


def _text(tree: dict[str, Any], where: str, name: str, default: str | None = None, key: str = "") -> str:
    full = f"{key}.{name}" if key else name
    value = tree.get(name, default)
    if value is None:
        raise InputError(f"{where}: {full}: missing; add it")
    if not isinstance(value, str):
        raise InputError(f"{where}: {full} = {shorten(value)}: must be text")
    return value


def _number(
    tree: dict[str, Any],
    where: str,
    name: str,
    default: float,
    low: float = -math.inf,
    high: float = math.inf,
    key: str = "",
) -> float:
    full = f"{key}.{name}" if key else name
    value = tree.get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or math.isnan(value):
        raise InputError(f"{where}: {full} = {shorten(value)}: must be a number")
    if not low <= value <= high:
        raise InputError(f"{where}: {full} = {value:g}: must be within {low:g} to {high:g}")
    return float(value)
