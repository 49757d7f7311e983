"""The mapping of a table whose heads are known: which column is which channel, in which unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import yaml

from slider_drilling.errors import InputError
from slider_drilling.table_import.delimited_text import split_brackets, split_head
from slider_drilling.table_import.mapping import (
    EXCEL_DAYS,
    IMPORT_CHANNELS,
    ISO_TIME,
    RATE_OF,
    SCHEMA,
    TableMapping,
    parse_mapping,
)
from slider_drilling.table_import.mnemonics import (
    DATE_HEADS,
    HEADS,
    IMPLIED_UNITS,
    MAGNETIC,
    TIME_HEADS,
    is_pump,
    plain_head,
    rank,
)
from slider_drilling.table_import.numbers import NULL_WORDS
from slider_drilling.table_import.rocking_signs import looks_unsigned
from slider_drilling.table_import.source import Table, TableSource
from slider_drilling.units import KINDS, unit_factor

# Range of seconds since 1970 of any table: 1990 to 2100.
_EPOCH_RANGE = (6.3e8, 4.1e9)
_EXCEL_RANGE = (30_000.0, 80_000.0)  # days since 1900: 1982 to 2119


@dataclass
class Recognised:
    """A mapping that was found, and what was assumed for it.

    Attributes:
        tree: As a mapping file holds it.
        notes: One sentence for each thing that was chosen or assumed.
    """

    tree: dict[str, Any]
    notes: list[str] = field(default_factory=list)

    def mapping(self, source: str) -> TableMapping:
        """The mapping. Raises InputError."""
        return parse_mapping(self.tree, source)


def mapping_text(tree: Mapping[str, Any], source: str) -> str:
    """A mapping as the text of a mapping file."""
    body = yaml.safe_dump(dict(tree), sort_keys=False, allow_unicode=True, default_flow_style=None, width=110)
    return f"# How `slider-drilling import` read {source}. Correct it and give it back with --mapping.\n{body}"


def recognise(table: TableSource, source: str, units: Mapping[str, str], has_rig: bool) -> Recognised:
    """The mapping of a table by its heads.

    Args:
        table: The table.
        source: Its name, for messages.
        units: Units of columns that the table does not give, by the columns' names.
        has_rig: Whether there is a rig file, which a flow needs.

    Raises:
        InputError: No head is known, a unit is missing, or there is no column of times.
    """
    sample = table.sample()
    named = _Columns(table, sample, dict(units), source)
    found = Recognised({"schema": SCHEMA})
    found.tree["time"] = _time(named, found)
    if table.heads.nulls:
        found.tree["null_values"] = [-999.25, *(null for null in table.heads.nulls if null != -999.25)]
    channels = _channels(named, found, has_rig)
    if not channels:
        raise InputError(
            f"{source}: no column is a channel of a rig; it has {named.listed()}; name them in a mapping file "
            "(--mapping, see config/import.example.yaml)"
        )
    missing = [(entry["column"], channel) for channel, entry in channels.items() if not entry["unit"]]
    if missing:
        column, channel = missing[0]
        kinds = KINDS[_column_kind(channel, channels[channel])]
        others = "".join(f", {name!r}" for name, _ in missing[1:])
        raise InputError(
            f"{source}: column {column!r} ({channel}){others}: no unit in the table; add --unit '{column}=UNIT', with "
            f"UNIT one of {', '.join(kinds)}"
        )
    found.tree["channels"] = channels
    found.notes += _unknown_units(named, channels)
    return found


def _unknown_units(table: _Columns, channels: Mapping[str, Any]) -> list[str]:
    """A sentence for each column that is no channel only because its head has something unknown in brackets."""
    notes = []
    for name in table.names:
        bare, unit = split_brackets(name)
        if unit and bare != table.bare[name] and not table.is_empty(name):
            could_be = [channel for channel in HEADS if channel not in channels and rank(channel, bare) is not None]
            if could_be:
                kind = IMPORT_CHANNELS[could_be[0]].kind
                notes.append(
                    f"{name!r} is not used: {unit!r} is not a known unit of {kind}; if it is {could_be[0]}, give its "
                    f"unit with --unit '{name}=UNIT'"
                )
    return notes


class _Columns:
    """The columns of a table with their bare names and units."""

    def __init__(self, table: TableSource, sample: Table, units: dict[str, str], source: str) -> None:
        self.names = table.heads.names
        self.sample = sample
        self.source = source
        self.date_order = table.heads.date_order
        if not table.heads.named:
            raise InputError(f"{source}: has no heads; name its columns in a mapping file (--mapping, key names)")
        self.bare: dict[str, str] = {}
        self.units: dict[str, str] = {}
        for name, unit in zip(self.names, table.heads.units, strict=True):
            bare, own = split_head(name)
            given = units.pop(name, units.pop(bare, ""))
            if given and bare == name:
                bare = split_brackets(name.removesuffix(" (2)"))[0]  # a unit of the table's that is not known
            before, _, letter = name.rpartition("_")
            if bare == name and not any(rank(channel, name) is not None for channel in HEADS):
                channel = next((channel for channel in HEADS if rank(channel, before) is not None), "")
                if channel and unit_factor(letter, IMPORT_CHANNELS[channel].kind) is not None:
                    bare, own = before, letter  # "block_position_m", but not "mud_t"
            self.bare[name] = bare.removesuffix(" (2)")
            self.units[name] = given or unit or own
        if units:
            raise InputError(f"--unit {next(iter(units))}: no such column; the table has {self.listed()}")

    def listed(self) -> str:
        """The heads, for a message."""
        return " ".join(", ".join(self.names).split())[:300]

    def words(self, name: str) -> list[str]:
        """The first cells of a column as text, without nulls."""
        return [text for cell in self.sample.columns[name] if (text := str(cell).strip()).lower() not in NULL_WORDS]

    def numbers(self, name: str) -> np.ndarray:
        """The first cells of a column that are numbers."""
        values = []
        for word in self.words(name):
            try:
                values.append(float(word.replace(",", ".")))
            except ValueError:
                continue
        return np.array(values)

    def is_empty(self, name: str) -> bool:
        """Whether the first rows hold no value but nulls."""
        values = self.numbers(name)
        return bool(values.size == 0) and not self.words(name)

    def unit_of(self, name: str, channel: str, kind: str) -> str:
        """The unit of a column; empty where nothing gives one of this kind. Raises InputError for another kind's."""
        unit = self.units[name]
        if unit and unit_factor(unit, kind) is not None:
            return unit
        implied = IMPLIED_UNITS.get(channel)
        if implied and implied[1].search(plain_head(self.bare[name]).replace(" ", "")):
            return implied[0]
        if unit and unit.lower() not in (*NULL_WORDS, "unitless", "dimensionless"):
            raise InputError(
                f"{self.source}: column {name!r} ({channel}): unit {unit!r}: not a known unit of {kind}; add "
                f"--unit '{name}=UNIT', with UNIT one of {', '.join(KINDS[kind])}"
            )
        return ""


def _time(table: _Columns, found: Recognised) -> dict[str, Any]:
    """The entry of the times."""
    times = [name for name in table.names if _plain(table, name) in TIME_HEADS or plain_head(name) in TIME_HEADS]
    dates = [name for name in table.names if _plain(table, name) in DATE_HEADS or plain_head(name) in DATE_HEADS]
    times = sorted((name for name in times if not table.is_empty(name)), key=lambda name: _time_rank(table, name))
    dates = [name for name in dates if not table.is_empty(name)]
    if not times and not dates:
        stamped = [
            name for name in table.names if getattr(table.sample.columns[name], "dtype", np.dtype("O")).kind == "M"
        ]
        times = stamped[:1]
    if not times and not dates:
        raise InputError(
            f"{table.source}: no column of times; it has {table.listed()}; name it in a mapping file (--mapping)"
        )
    column = times[0] if times else dates[0]
    entry: dict[str, Any] = {"column": column, "unit": _time_unit(table, column, found)}
    if entry["unit"] == ISO_TIME and times and dates and not _has_date(table, column):
        entry["date_column"] = dates[0]
    order = table.date_order or _order_of_unit(table.units[column] or plain_head(column))
    if order:
        entry["date_order"] = order
    return entry


def _plain(table: _Columns, name: str) -> str:
    return plain_head(table.bare[name])


def _time_rank(table: _Columns, name: str) -> int:
    plain = _plain(table, name)
    return TIME_HEADS.index(plain) if plain in TIME_HEADS else len(TIME_HEADS)


def _order_of_unit(unit: str) -> str:
    """The order of the date's parts in a unit such as DD/MM/YYYY-HH:MM:SS."""
    date = unit.upper().split("H")[0]
    places = {letter: date.find(letter * 2) for letter in "YMD"}
    return "".join(sorted(places, key=lambda letter: places[letter])) if min(places.values()) >= 0 else ""


def _has_date(table: _Columns, column: str) -> bool:
    cells = table.sample.columns[column]
    if isinstance(cells, np.ndarray):
        return bool(cells.dtype.kind == "M" and len(cells) and cells[0] > np.datetime64("1971-01-01"))
    return any("-" in word or "/" in word or word.count(".") > 1 for word in table.words(column)[:5])


def _time_unit(table: _Columns, column: str, found: Recognised) -> str:
    """The unit of the times: text, or numbers whose size or unit says what they count."""
    cells = table.sample.columns[column]
    if isinstance(cells, np.ndarray) and cells.dtype.kind == "M":
        return ISO_TIME
    words, values = table.words(column), table.numbers(column)
    if len(values) < len(words):
        return ISO_TIME
    unit = table.units[column]
    if unit and unit_factor(unit, "time") is not None:
        return unit
    if unit.lower().lstrip("d. ") in ("excel", "days since 1900") or (
        values.size and _EXCEL_RANGE[0] < values.min() and values.max() < _EXCEL_RANGE[1]
    ):
        found.notes.append(f"{column!r} is read as a spreadsheet's days since 1900")
        return EXCEL_DAYS
    for name, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if values.size and _EPOCH_RANGE[0] < values[0] * size < _EPOCH_RANGE[1]:
            found.notes.append(f"{column!r} is read as {name} since 1970")
            return name
    found.notes.append(f"{column!r} has no unit: read as s; correct it with --unit '{column}=min'")
    return "s"


def _channels(table: _Columns, found: Recognised, has_rig: bool) -> dict[str, dict[str, Any]]:
    """Entries of all channels that the heads show."""
    channels: dict[str, dict[str, Any]] = {}
    for channel in HEADS:
        name = _best(table, channel, found)
        if name is not None:
            channels[channel] = {"column": name, "unit": table.unit_of(name, channel, IMPORT_CHANNELS[channel].kind)}
    pumps = [name for name in table.names if is_pump(_plain(table, name)) and not table.is_empty(name)
             and (not table.units[name] or unit_factor(table.units[name], "angular speed") is not None)]  # fmt: skip
    if pumps and "pump_speed" not in channels:
        unit = table.unit_of(pumps[0], "pump_speed", "angular speed")
        channels["pump_speed"] = {"column": pumps[0], "unit": unit or "spm"}
        if len(pumps) > 1:
            channels["pump_speed"]["plus"] = pumps[1:]
            found.notes.append(f"pump_speed is the sum of {', '.join(pumps)}")
    _one_of_flow_and_speed(channels, found, has_rig)
    _angle_from_speed(channels)
    _conventions(table, channels, found)
    return {name: channels[name] for name in IMPORT_CHANNELS if name in channels}


def _best(table: _Columns, channel: str, found: Recognised) -> str | None:
    ranked = [(place, name) for name in table.names if (place := rank(channel, table.bare[name])) is not None]
    ranked = sorted(pair for pair in ranked if not table.is_empty(pair[1]))
    if not ranked:
        return None
    others = [name for _, name in ranked[1:]]
    if others:
        found.notes.append(f"{channel} is {ranked[0][1]!r}, not {' or '.join(map(repr, others))}")
    return ranked[0][1]


def _one_of_flow_and_speed(channels: dict[str, dict[str, Any]], found: Recognised, has_rig: bool) -> None:
    """Strokes show the pump better than a flow, which may be computed; without strokes the flow needs the rig file."""
    if "pump_flow" not in channels:
        return
    if "pump_speed" in channels:
        column = channels.pop("pump_flow")["column"]
        found.notes.append(f"pump_speed is {channels['pump_speed']['column']!r}; the flow {column!r} is not used")
    elif not has_rig:
        column = channels.pop("pump_flow")["column"]
        found.notes.append(
            f"the flow {column!r} is left out: it needs the rig file's mud_pump.displacement, give --rig"
        )


def _angle_from_speed(channels: dict[str, dict[str, Any]]) -> None:
    if "top_drive_speed" in channels and "top_drive_angle" not in channels:
        speed = channels["top_drive_speed"]
        channels["top_drive_angle"] = {"column": speed["column"], "unit": speed["unit"], "integral": True}


def _conventions(table: _Columns, channels: dict[str, dict[str, Any]], found: Recognised) -> None:
    """Signs and starts that differ between recorders and logs."""
    if "block_position" in channels:
        channels["block_position"] |= {"sign": -1, "from_first": True}
        found.notes.append("block heights are taken to count up from the floor: sign -1, from the first row")
    if "tool_face" in channels:
        channels["tool_face"] |= {"on_change": True}
        if _plain(table, channels["tool_face"]["column"]) in MAGNETIC:
            found.notes.append(
                f"{channels['tool_face']['column']!r} is the magnetic toolface: right near vertical only"
            )


def mark_unsigned(tree: dict[str, Any], values: Mapping[str, np.ndarray], notes: list[str]) -> list[str]:
    """Mark the channels of a recognised mapping that have lost their sign; returns their names.

    Args:
        tree: The mapping, which is changed.
        values: Numbers of each channel's column.
        notes: Get a sentence each.
    """
    marked: list[str] = []
    if "surface_torque" in values and "top_drive_speed" in values:
        speed, torque = values["top_drive_speed"], values["surface_torque"]
        if looks_unsigned(speed, torque, of_speed=True):
            marked += ["top_drive_speed", *(["top_drive_angle"] if "top_drive_angle" in values else [])]
        if looks_unsigned(torque, speed, of_speed=False):
            marked.append("surface_torque")
    for name in marked:
        tree["channels"][name]["unsigned"] = True
    if marked:
        notes.append(f"{' and '.join(marked)} rock without a sign: restored from the other of speed and torque")
    return marked


def _column_kind(channel: str, entry: Mapping[str, Any]) -> str:
    kind = IMPORT_CHANNELS[channel].kind
    return RATE_OF[kind] if entry.get("integral") else kind
