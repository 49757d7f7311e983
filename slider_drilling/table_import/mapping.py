"""The mapping file of an import: which column of a table is which channel of a rig, and in which unit."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, fields, replace
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.messages.topics import TOPICS
from slider_drilling.schema.fields import build_dataclass, quantity
from slider_drilling.schema.yaml_tree import parse_yaml
from slider_drilling.table_import.times import ORDERS
from slider_drilling.units import KINDS, si_factor

SCHEMA = "slider_drilling/csv/1"
ISO_TIME = "iso8601"
AUTO = "auto"
EXCEL_DAYS = "excel"
MAX_MAPPING_BYTES = 1_000_000  # bytes of a mapping file


@dataclass(frozen=True)
class ImportChannel:
    """Where an imported channel goes.

    Attributes:
        series: Key of the topic in the registry.
        array: Array of the series.
        kind: Kind of quantity, which its unit must be of.
        is_wrapped: Whether the angle is wrapped into (-pi, pi].
    """

    series: str
    array: str
    kind: str
    is_wrapped: bool = False


def _registered_channels() -> dict[str, ImportChannel]:
    """By name: what the registry of topics says can be imported, and the pump's flow, which gives its speed."""
    # Several kinds may have one SI unit (pressure and stress, Pa): the first is that of a rig's readings.
    kind_of_unit = {next(iter(units)): kind for kind, units in reversed(KINDS.items())}
    channels = {
        quantity.import_name: ImportChannel(key, quantity.array, kind_of_unit[quantity.unit], quantity.is_wrapped)
        for key, topic in TOPICS.items()
        for quantity in topic.quantities
        if quantity.import_name
    }
    return {**channels, "pump_flow": replace(channels["pump_speed"], kind="flow")}


IMPORT_CHANNELS = _registered_channels()
# Channels whose sign the rocking restores.
UNSIGNED = ("top_drive_speed", "top_drive_angle", "surface_torque")
# Kind of a channel -> kind of the column that is integrated to it.
RATE_OF = {"angle": "angular speed", "length": "speed"}


@dataclass(frozen=True)
class ColumnMapping:
    """How one channel is made of columns: sign x (column + offset - tare), in `unit`.

    Attributes:
        column: Name of the column.
        unit: Of its numbers.
        plus: Further columns that are added to it, such as a second pump.
        sign: -1 where the table counts the other way, such as a block position that grows upwards.
        offset: Added to the column, in its unit, such as what the sensor reads at zero, with the other sign.
        tare: Subtracted from the column, in its unit, such as the weight of the block in a hook load.
        abs: Whether to drop the sign of the column.
        unsigned: Whether the column has lost its sign, which the rocking restores: of a speed from the torque, of a
            torque from the speed.
        from_first: Whether the first value is subtracted.
        integral: Whether the column is the rate of the channel, and is integrated from zero.
        on_change: Whether to keep only samples where the value changes: a table repeats a toolface until the next.
        delay: From measuring a value to its line in the table, s.
    """

    column: str
    unit: str
    plus: tuple[str, ...] = ()
    sign: float = quantity("-", 1.0, at_least=-1.0, at_most=1.0)
    offset: float = 0.0
    tare: float = 0.0
    abs: bool = False
    unsigned: bool = False
    from_first: bool = False
    integral: bool = False
    on_change: bool = False
    delay: float = quantity("s", 0.0, at_least=0.0, at_most=3600.0, why="from measuring to the table: seconds")


@dataclass(frozen=True)
class TimeMapping:
    """How the times are made of columns.

    Attributes:
        column: With the times.
        unit: Of numbers; iso8601 for dates and times as text, excel for days since 1900.
        date_column: With the dates, where `column` has only times of day.
        date_order: DMY, MDY or YMD, where dates can be read in two ways.
    """

    column: str
    unit: str = ISO_TIME
    date_column: str = ""
    date_order: str = ""


@dataclass(frozen=True)
class TableLayout:
    """The format of the table. Of what is "auto" or not given, the table itself decides.

    Attributes:
        schema: Version of the mapping file.
        time: The column of the times.
        names: Names of the columns, for a table without a header line.
        delimiter: Between cells; " " for any number of blanks.
        decimal: Mark before the fraction: "." or ",".
        encoding: Of the text, such as utf-8, utf-16 or cp1252.
        null_values: Numbers that mean no value.
        null_words: Words that mean no value, beside the usual ones.
        skip_lines: Number of lines before the header.
        unit_line: Whether a line of units follows the header.
        time_zone: IANA name of the zone of times that name none, such as Europe/Oslo.
        start: Date and time of time 0.
        sheet: Of a workbook; the first if empty.
        given: Keys that the mapping file gives.
    """

    schema: str
    time: TimeMapping
    names: tuple[str, ...] = ()
    delimiter: str = AUTO
    decimal: str = AUTO
    encoding: str = AUTO
    null_values: tuple[float, ...] = (-999.25,)
    null_words: tuple[str, ...] = ()
    skip_lines: int = 0
    unit_line: bool = False
    time_zone: str = ""
    start: str = ""
    sheet: str = ""
    given: frozenset[str] = field(default=frozenset(), init=False)


@dataclass(frozen=True)
class TableMapping:
    """A mapping file.

    Attributes:
        source: The file, for messages.
        layout: The format of the table.
        channels: How each channel is made.
        scale: SI value of one unit of each channel, with its sign.
    """

    source: str
    layout: TableLayout
    channels: dict[str, ColumnMapping]
    scale: dict[str, float]

    def columns(self) -> list[str]:
        """Names of all columns that are read, each once."""
        time = self.layout.time
        names = [time.column, *([time.date_column] if time.date_column else [])]
        for channel in self.channels.values():
            names += [channel.column, *channel.plus]
        return list(dict.fromkeys(names))


def load_mapping(path: str | os.PathLike[str]) -> TableMapping:
    """Read a mapping file; `config/import.example.yaml` documents its keys. Raises InputError."""
    source = str(path)
    return parse_mapping(parse_yaml(read_text(path, "mapping file", MAX_MAPPING_BYTES), source), source)


def parse_mapping(raw: Any, source: str) -> TableMapping:
    """The mapping from parsed YAML. Raises InputError with source, key and value."""
    if not isinstance(raw, dict):
        raise InputError(f"{source}: has no keys; see config/import.example.yaml")
    _check_places(raw, source)
    layout = build_dataclass(TableLayout, {key: value for key, value in raw.items() if key != "channels"}, source)
    if layout.schema != SCHEMA:
        raise InputError(f"{source}: schema = {layout.schema!r}: this version reads {SCHEMA!r}")
    object.__setattr__(layout, "given", frozenset(raw))
    if layout.delimiter != AUTO and (len(layout.delimiter) != 1 or layout.delimiter in '\r\n"\x00'):
        raise InputError(f"{source}: delimiter = {layout.delimiter!r}: must be one character, no quote, or auto")
    if layout.decimal not in (AUTO, ".", ","):
        raise InputError(f"{source}: decimal = {layout.decimal!r}: must be '.', ',' or auto")
    if layout.time.date_order not in ("", *ORDERS):
        raise InputError(f"{source}: time.date_order = {layout.time.date_order!r}: must be {', '.join(ORDERS)}")
    if layout.skip_lines < 0:
        raise InputError(f"{source}: skip_lines = {layout.skip_lines}: must be at least 0")
    channels, scale = {}, {}
    for name, entry in _channel_entries(raw, source):
        column = build_dataclass(ColumnMapping, entry, source, f"channels.{name}")
        if column.sign not in (-1.0, 1.0):
            raise InputError(f"{source}: channels.{name}.sign = {column.sign:g}: must be 1 or -1")
        channels[name] = column
        kind = kind_of_column(name, column, source)
        scale[name] = column.sign * si_factor(column.unit, kind, f"{source}: channels.{name}")
        if column.unsigned and column.abs:
            raise InputError(f"{source}: channels.{name}: abs drops the sign that unsigned restores; keep one")
        if column.unsigned and name not in UNSIGNED:
            raise InputError(f"{source}: channels.{name}.unsigned: only for {' and '.join(UNSIGNED)}")
    if layout.time.unit not in (ISO_TIME, EXCEL_DAYS):
        scale["time"] = si_factor(layout.time.unit, "time", f"{source}: time")
    _check_targets(channels, source)
    return TableMapping(source, layout, channels, scale)


def _check_places(raw: dict[str, Any], source: str) -> None:
    """Raise InputError for a key of the table's layout that stands inside `time`."""
    time = raw.get("time")
    of_layout = {one.name for one in fields(TableLayout)} - {one.name for one in fields(TimeMapping)}
    for key in time if isinstance(time, dict) else ():
        if key in of_layout:
            raise InputError(f"{source}: time.{key}: stands beside time, not in it; write {key} at the top level")


def _channel_entries(raw: dict[str, Any], source: str) -> list[tuple[str, Any]]:
    """Name and entry of each channel. Raises InputError where there is none, or an unknown one."""
    entries = raw.get("channels")
    if not isinstance(entries, dict) or not entries:
        raise InputError(f"{source}: channels: missing; map at least one of {', '.join(IMPORT_CHANNELS)}")
    for name in entries:
        if name not in IMPORT_CHANNELS:
            raise InputError(f"{source}: channels.{name}: unknown channel; known are {', '.join(IMPORT_CHANNELS)}")
    return list(entries.items())


def kind_of_column(name: str, column: ColumnMapping, source: str) -> str:
    """The kind of quantity that a channel's column holds. Raises InputError for an integral of another kind."""
    kind = IMPORT_CHANNELS[name].kind
    if not column.integral:
        return kind
    if kind not in RATE_OF:
        raise InputError(f"{source}: channels.{name}.integral: only angles and positions can be integrated")
    return RATE_OF[kind]


def _check_targets(channels: dict[str, ColumnMapping], source: str) -> None:
    """Raise InputError where two channels fill the same array."""
    seen: dict[tuple[str, str], str] = {}
    for name in channels:
        target = (IMPORT_CHANNELS[name].series, IMPORT_CHANNELS[name].array)
        if target in seen:
            raise InputError(f"{source}: channels.{name}: is the same quantity as {seen[target]}; keep one")
        seen[target] = name
