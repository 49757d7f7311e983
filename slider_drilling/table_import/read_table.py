"""A table of a rig's recorder into a RigLog, by a mapping file or by the heads that are recognised."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.files.paths import as_path
from slider_drilling.log.rig_log import RigLog
from slider_drilling.rig import parse_rig
from slider_drilling.table_import.build_log import build_log
from slider_drilling.table_import.channel_values import ChannelValues
from slider_drilling.table_import.check_columns import check_columns
from slider_drilling.table_import.column_reader import ColumnReader
from slider_drilling.table_import.delimited_text import TextTable
from slider_drilling.table_import.doubtful import contradicted_units
from slider_drilling.table_import.findings import Findings
from slider_drilling.table_import.mapping import (
    AUTO,
    ISO_TIME,
    UNSIGNED,
    TableMapping,
    load_mapping,
)
from slider_drilling.table_import.mnemonics import DATE_HEADS, plain_head
from slider_drilling.table_import.numbers import numbers
from slider_drilling.table_import.open_table import open_table
from slider_drilling.table_import.recognise import Recognised, mapping_text, mark_unsigned, recognise
from slider_drilling.table_import.row_times import row_times
from slider_drilling.table_import.source import Table, TableSource


@dataclass(frozen=True)
class ImportedTable:
    """A table that was read.

    Attributes:
        log: The log in memory; `log.imported` tells what was found and done.
        mapping: The mapping that was used, as the text of a mapping file.
    """

    log: RigLog
    mapping: str


def read_table(
    path: str | os.PathLike[str],
    mapping_path: str | os.PathLike[str] | None = None,
    rig_path: str | os.PathLike[str] | None = None,
    rows: tuple[int, int] | None = None,
) -> RigLog:
    """Read a table of a rig's recorder into a RigLog; see `import_table`."""
    return import_table(path, mapping_path, rig_path, rows).log


def import_table(
    path: str | os.PathLike[str],
    mapping_path: str | os.PathLike[str] | None = None,
    rig_path: str | os.PathLike[str] | None = None,
    rows: tuple[int, int] | None = None,
    *,
    units: Mapping[str, str] | None = None,
    time_zone: str = "",
    wits_units: str = "",
) -> ImportedTable:
    """Read a table of a rig's recorder: text, LAS, workbook, Parquet, WITSML or WITS.

    Args:
        path: The table.
        mapping_path: The mapping file; without one, columns are recognised by their heads.
        rig_path: The rig file to attach; the channel pump_flow needs it.
        rows: First and last data row to keep, counted from 0.
        units: Units of columns that the table does not give, by the columns' names; not with a mapping file.
        time_zone: IANA zone of the table's clock, where neither table nor mapping file names it.
        wits_units: Units of WITS: "field" or "metric".

    Returns:
        The log in memory, and the mapping that was used.

    Raises:
        InputError: A cell is no number, times go back, or a unit is missing; the message names file, line and column.
    """
    table_path = as_path(path, "table")
    rig_text = read_text(rig_path, "rig file") if rig_path is not None else None
    found = Findings()
    if mapping_path is not None:
        mapping = load_mapping(mapping_path)
        source = open_table(table_path, mapping.layout, wits_units)
        text = read_text(mapping_path, "mapping file")
        if time_zone:
            mapping = replace(mapping, layout=replace(mapping.layout, time_zone=time_zone))
        mapping = _with_date_column(mapping, source, found)
        mapping = check_columns(mapping, source, found, _delimiter(source))
        table = source.read(mapping.columns(), rows)
    else:
        source = open_table(table_path, None, wits_units)
        recognised = recognise(source, printable(str(path)), units or {}, rig_text is not None)
        if time_zone:
            recognised.tree = {**recognised.tree, "time_zone": time_zone}
        mapping = recognised.mapping(printable(str(path)))
        mapping = check_columns(mapping, source, found, _delimiter(source))
        table = source.read(mapping.columns(), rows)
        mapping = _with_unsigned(recognised, mapping, table, _delimiter(source), found)
        text = mapping_text(recognised.tree, printable(str(path)))
    return ImportedTable(_log(source, table, mapping, found, (rig_text, rig_path)), text)


def _with_unsigned(
    recognised: Recognised, mapping: TableMapping, table: Table, delimiter: str, found: Findings
) -> TableMapping:
    """The recognised mapping with channels marked that have lost their sign."""
    wanted: list[str] = [
        key
        for key in UNSIGNED
        if key in mapping.channels and (key != "top_drive_angle" or mapping.channels[key].integral)
    ]
    nulls = mapping.layout.null_values
    values = {
        key: numbers(table, mapping.channels[key].column, nulls, AUTO, delimiter=delimiter).values for key in wanted
    }
    if mark_unsigned(recognised.tree, values, recognised.notes):
        mapping = recognised.mapping(mapping.source)
    for note in recognised.notes:
        found.add("columns", note)
    return mapping


def _delimiter(source: TableSource) -> str:
    """The mark between the cells of a text; empty for other tables."""
    return source.format.delimiter if isinstance(source, TextTable) else ""


def _with_date_column(mapping: TableMapping, source: TableSource, found: Findings) -> TableMapping:
    """The mapping with the table's column of dates, where it names only times of day."""
    time = mapping.layout.time
    if time.unit != ISO_TIME or time.date_column or mapping.layout.start or time.column not in source.heads.names:
        return mapping
    dates = [name for name in source.heads.names if plain_head(name) in DATE_HEADS and name != time.column]
    cells = source.sample().columns[time.column] if dates else ()
    if not dates or isinstance(cells, np.ndarray) or any(re.search(r"\d[-/.]\w+[-/.]\d", cell) for cell in cells[:5]):
        return mapping
    found.add("clock", f"dates are those of column {dates[0]!r}")
    return replace(mapping, layout=replace(mapping.layout, time=replace(time, date_column=dates[0])))


def _log(
    source: TableSource,
    table: Table,
    mapping: TableMapping,
    found: Findings,
    rig: tuple[str | None, str | os.PathLike[str] | None],
) -> RigLog:
    """The log of a table; rig: text and path of the rig file. Raises InputError."""
    for note in table.notes:
        found.add("table", note)
    for note in contradicted_units(source.heads, mapping):
        found.add("columns", note)
    nulls = (*mapping.layout.null_values, *source.heads.nulls)
    reader = ColumnReader(table, mapping.layout, nulls, _delimiter(source))
    times = row_times(reader, mapping, mapping.layout.time.date_order or source.heads.date_order, found)
    channels = ChannelValues(reader, mapping, times, found)
    channels.read_columns()
    values = {name: channels.channel(name) for name in mapping.channels}
    if "pump_flow" in values:
        rig_text, rig_path = rig
        if rig_text is None:
            raise InputError(f"{mapping.source}: channels.pump_flow: needs the rig file's mud_pump.displacement")
        values["pump_flow"] = values["pump_flow"] / parse_rig(rig_text, str(rig_path)).mud_pump.displacement
    reader.note(found)
    return build_log(values, times, mapping, found, table.source, rig)
