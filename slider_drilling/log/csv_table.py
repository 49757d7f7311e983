"""Reads a CSV table, such as the export of a rig's recorder, into a RigLog by a mapping file."""

from __future__ import annotations

import csv
import datetime
import math
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_lines, read_text
from slider_drilling.log.csv_mapping import IMPORT_CHANNELS, ISO_TIME, CsvMapping, TableLayout, load_mapping
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import Array, Series, build_series
from slider_drilling.log.value_limits import mask_impossible_values
from slider_drilling.messages.topics import CLOCK_TOPICS, TOPICS
from slider_drilling.rig import parse_rig
from slider_drilling.schema.yaml_tree import shorten

MAX_EPOCH_S = 2.0**31  # the last second that a message's stamp can hold: January 2038
_MAX_CELLS = 10_000_000  # of the columns that are kept: a gigabyte, as text and as numbers
_MAX_CELL_LINES = 50  # a cell with more comes from a quote that is never closed
Words = dict[str, list[str]]


@dataclass(frozen=True)
class TextTable:
    """The mapped columns as text.

    Attributes:
        source: The file, for messages.
        columns: Cells of each column by its name.
        lines: Line of the file that each row ends on.
    """

    source: str
    columns: Words
    lines: list[int]


def read_table(
    path: str | os.PathLike[str],
    mapping_path: str | os.PathLike[str],
    rig_path: str | os.PathLike[str] | None = None,
    rows: tuple[int, int] | None = None,
) -> RigLog:
    """Read a CSV table into a RigLog.

    Args:
        path: The table.
        mapping_path: The mapping file.
        rig_path: The rig file to attach; the channel pump_flow needs it.
        rows: First and last data row to keep, counted from 0.

    Returns:
        The log in memory.

    Raises:
        InputError: A cell is no number, or times go back; the message names file, line and column.
    """
    mapping = load_mapping(mapping_path)
    rig_text = read_text(rig_path, "rig file") if rig_path is not None else None
    table = _read_words(Path(path), mapping, rows)
    notes: list[str] = []
    seconds, epoch_ns = _times(table, mapping)
    values = {name: _channel(table, mapping, name, seconds) for name in mapping.channels}
    if "pump_flow" in values:
        if rig_text is None:
            raise InputError(f"{mapping.source}: channels.pump_flow: needs the rig file's mud_pump.displacement")
        values["pump_flow"] = values["pump_flow"] / parse_rig(rig_text, str(rig_path)).mud_pump.displacement
    kept = _increasing(seconds, table, notes)
    built = {key: _series(key, mapping, values, seconds, kept, notes) for key in TOPICS}
    filled = {key: series for key, series in built.items() if series is not None}
    if not filled:
        raise InputError(f"{table.source}: all mapped columns are empty or null")
    origin = float(filled[next(key for key in CLOCK_TOPICS if key in filled)].time[0])
    series = {key: replace(s, time=s.time - origin, arrival=s.arrival - origin) for key, s in filled.items()}
    last = epoch_ns * 1e-9 + origin + max(float(s.arrival[-1]) for s in series.values())
    log = RigLog(
        source=table.source,
        start_ns=_start_ns(mapping, epoch_ns, origin, last),
        rig_text=rig_text,
        rig_source=None if rig_path is None else str(rig_path),
        metadata={},
        notes=tuple(notes),
        **series,  # type: ignore[arg-type]
    )
    return mask_impossible_values(log)


def _start_ns(mapping: CsvMapping, epoch_ns: int, origin: float, last: float) -> int:
    """ns since the epoch of the first time, `origin`. Raises InputError for times that a stamp cannot hold."""
    if last >= MAX_EPOCH_S or origin < -MAX_EPOCH_S:
        raise InputError(
            f"{mapping.source}: time.unit = {mapping.layout.time.unit!r}: times would end in the year "
            f"{round(1970 + last / 31_556_952, 0):.6g}; are they in ms or ns?"
        )
    start_ns = epoch_ns + round(origin * 1e9)
    if start_ns < 0:
        raise InputError(f"{mapping.source}: start: times begin at {start_ns * 1e-9:g} s; give the table's start time")
    return start_ns


def _read_words(path: Path, mapping: CsvMapping, rows: tuple[int, int] | None) -> TextTable:
    """The mapped columns of the chosen rows, as text."""
    layout = mapping.layout
    body = _rows(path, layout)
    header = list(layout.names) or [word.strip() for word in next(body, (0, []))[1]]
    if not header:
        raise InputError(f"{path}: is empty; expected a header line and rows of numbers")
    if layout.unit_line:
        next(body, None)
    indices = _column_indices(mapping, header, path)
    columns: Words = {name: [] for name in indices}
    first, last = rows if rows is not None else (0, math.inf)
    lines: list[int] = []
    count = 0
    for index, (line, row) in enumerate(body):
        count = index + 1
        if not first <= index <= last:
            continue
        if len(row) != len(header):
            raise InputError(f"{path}: line {line}: {len(row)} cells where {len(header)} columns are named")
        if len(lines) * len(indices) >= _MAX_CELLS:
            raise InputError(
                f"{path}: line {line}: more than {_MAX_CELLS} cells so far, in {len(indices)} columns that the mapping "
                f"names; import it in parts, the first with --rows {int(first)}:{int(first) + len(lines) - 1}"
            )
        lines.append(line)
        for name, position in indices.items():
            columns[name].append(row[position].strip())
    if rows is not None and not first <= last < count:
        raise InputError(f"{path}: rows {first}:{last}: the table has rows 0 to {count - 1}")
    if not lines:
        raise InputError(f"{path}: has no rows of numbers")
    return TextTable(printable(str(path)), columns, lines)


def _rows(path: Path, layout: TableLayout) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows that are not empty, each with the line that it ends on."""
    lines = read_lines(path, "table")
    for _ in range(layout.skip_lines):
        next(lines, None)
    reader = csv.reader(lines, delimiter=layout.delimiter)
    row_start = layout.skip_lines + 1
    try:
        for row in reader:
            if any(word.count("\n") > _MAX_CELL_LINES for word in row):
                raise csv.Error(f"a cell of more than {_MAX_CELL_LINES} lines")
            if any(word.strip() for word in row):
                yield layout.skip_lines + reader.line_num, row
                row_start = layout.skip_lines + reader.line_num + 1
    except csv.Error as error:
        raise InputError(f"{path}: line {row_start}: {error}; is a quote opened there and never closed?") from None


def _column_indices(mapping: CsvMapping, header: list[str], path: Path) -> dict[str, int]:
    """Index of each mapped column. Raises InputError for a column that is missing or there twice."""
    indices = {}
    channels = {f"channels.{name}": channel for name, channel in mapping.channels.items()}
    entries = {"time": mapping.layout.time, **channels}
    for where, entry in entries.items():
        for name in (entry.column, *entry.plus):
            if header.count(name) != 1:
                count = header.count(name) or "no"
                raise InputError(
                    f"{mapping.source}: {where}: column {name!r}: {count} such column in {path}, "
                    f"which has {' '.join(', '.join(header).split())[:300]}"
                )
            indices[name] = header.index(name)
    return indices


def _numbers(table: TextTable, name: str, layout: TableLayout) -> Array:
    """One column as numbers; NaN where a cell is empty or null."""
    numbers = np.empty(len(table.lines))
    for index, word in enumerate(table.columns[name]):
        try:
            numbers[index] = float(word) if word else math.nan
        except ValueError:
            raise InputError(
                f"{table.source}: line {table.lines[index]}: column {name!r} = {shorten(word)}: not a number"
            ) from None
    numbers[np.isin(numbers, layout.null_values) | np.isinf(numbers)] = math.nan
    return numbers


def _times(table: TextTable, mapping: CsvMapping) -> tuple[Array, int]:
    """Time of every row, s, NaN where it has none; and the epoch ns of time 0."""
    layout = mapping.layout
    start_ns = 0 if not layout.start else _epoch_ns(layout.start, f"{mapping.source}: start")
    if layout.time.unit != ISO_TIME:
        return _numbers(table, layout.time.column, layout) * mapping.scale["time"], start_ns
    stamps = []
    for line, word in zip(table.lines, table.columns[layout.time.column], strict=True):
        stamps.append(_epoch_ns(word, f"{table.source}: line {line}: column {layout.time.column!r}"))
    return np.subtract(stamps, stamps[0]) * 1e-9, stamps[0]


def _epoch_ns(text: str, where: str) -> int:
    """ns since the epoch of a date and time; UTC where it names no zone. Raises InputError, beginning with `where`."""
    # Python 3.10 reads neither Z nor fractions of other than three or six digits.
    written = re.sub(r"[.,](\d+)", lambda fraction: f".{fraction[1]:0<6.6}", text.strip()).replace("Z", "+00:00")
    try:
        moment = datetime.datetime.fromisoformat(written)
    except ValueError:
        raise InputError(f"{where} = {shorten(text)}: not a time; write 2024-05-01T12:00:00Z") from None
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=datetime.timezone.utc)
    since = moment - datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)
    return (since.days * 86400 + since.seconds) * 1_000_000_000 + since.microseconds * 1000


def _channel(table: TextTable, mapping: CsvMapping, name: str, seconds: Array) -> Array:
    """One channel in SI units."""
    entry = mapping.channels[name]
    total = _numbers(table, entry.column, mapping.layout)
    for more in entry.plus:
        total = total + _numbers(table, more, mapping.layout)
    total = total * mapping.scale[name]
    if entry.integral:
        total = _integral(total, seconds)
    if entry.from_first:
        given = total[~np.isnan(total)]
        total = total - (given[0] if given.size else 0.0)
    if IMPORT_CHANNELS[name].is_wrapped:
        total = math.pi - np.mod(math.pi - total, 2.0 * math.pi)
    return total


def _integral(rate: Array, seconds: Array) -> Array:
    """Trapezoidal integral from zero over the rows that have both; NaN elsewhere."""
    # Not scipy's: the recorder imports this package and must start without scipy.
    given = ~np.isnan(rate) & ~np.isnan(seconds)
    total = np.full(rate.shape, math.nan)
    value = rate[given]
    steps = np.diff(seconds[given]) * (value[1:] + value[:-1]) / 2.0
    total[given] = np.concatenate([[0.0], np.cumsum(steps)])[: value.size]
    return total


def _increasing(seconds: Array, table: TextTable, notes: list[str]) -> NDArray[np.bool_]:
    """Which rows to keep: those with a time, the last one of each time. Raises InputError where times go back."""
    timed = np.flatnonzero(~np.isnan(seconds))
    if not timed.size:
        raise InputError(f"{table.source}: no row with a time")
    steps = np.diff(seconds[timed])
    back = np.flatnonzero(steps < 0.0)
    if back.size:
        before, after = timed[back[0]], timed[back[0] + 1]
        raise InputError(
            f"{table.source}: line {table.lines[after]}: time goes back from {seconds[before]:g} s to "
            f"{seconds[after]:g} s; if these are two runs, import each with --rows"
        )
    kept = np.zeros(seconds.shape, dtype=np.bool_)
    kept[timed[np.append(steps > 0.0, True)]] = True
    if not kept.all():
        notes.append(f"{np.count_nonzero(~kept)} rows without a time, or with a repeated one, were left out")
    return kept


def _series(
    key: str,
    mapping: CsvMapping,
    values: dict[str, Array],
    time: Array,
    kept: NDArray[np.bool_],
    notes: list[str],
) -> Series | None:
    """One series from its channels, without rows where all of them are null; None where nothing is left."""
    own = {IMPORT_CHANNELS[name].array: (name, values[name]) for name in values if IMPORT_CHANNELS[name].series == key}
    if not own:
        return None
    some = kept & ~np.all([np.isnan(column) for _, column in own.values()], axis=0)
    for name, column in own.values():
        if mapping.channels[name].on_change:
            some &= _changes(column)
        missing = np.count_nonzero(kept & np.isnan(column))
        if missing:
            notes.append(f"{name}: {missing} of {np.count_nonzero(kept)} rows are null")
    if not some.any():
        return None
    arrival = time[some]
    measured = arrival - max(mapping.channels[name].delay for name, _ in own.values())
    arrays = {array: column[some] for array, (_, column) in own.items()}
    return build_series(TOPICS[key], measured, arrival, arrays)


def _changes(column: Array) -> NDArray[np.bool_]:
    """Where a value is given and differs from the last given one."""
    given = np.flatnonzero(~np.isnan(column))
    changed = np.zeros(column.shape, dtype=np.bool_)
    changed[given] = np.append(True, np.diff(column[given]) != 0.0)[: given.size]
    return changed
