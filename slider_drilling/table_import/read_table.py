"""A table of a rig's recorder into a RigLog, by a mapping file or by the heads that are recognised."""

from __future__ import annotations

import datetime
import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.log.import_record import ImportRecord, IntegratedQuantity
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import Array, Series, build_series
from slider_drilling.log.value_limits import mask_impossible_values, outside_range
from slider_drilling.messages.topics import CLOCK_TOPICS, TOPICS
from slider_drilling.rig import parse_rig
from slider_drilling.schema.yaml_tree import shorten
from slider_drilling.table_import.delimited_text import TextTable
from slider_drilling.table_import.doubtful import check_points, contradicted_units
from slider_drilling.table_import.integrate import integrate
from slider_drilling.table_import.mapping import (
    AUTO,
    EXCEL_DAYS,
    IMPORT_CHANNELS,
    ISO_TIME,
    UNSIGNED,
    ColumnMapping,
    TableMapping,
    load_mapping,
)
from slider_drilling.table_import.mnemonics import DATE_HEADS, plain_head
from slider_drilling.table_import.numbers import Numbers, numbers
from slider_drilling.table_import.open_table import open_table
from slider_drilling.table_import.recognise import Recognised, mapping_text, mark_unsigned, recognise
from slider_drilling.table_import.rocking_signs import signed_by
from slider_drilling.table_import.source import Table, TableSource
from slider_drilling.table_import.times import NO_TIME, SECOND, ClockNotes, read_stamps

MAX_EPOCH_S = 2.0**31  # the last second that a message's stamp can hold: January 2038
_EXCEL_EPOCH_DAYS = 25_569.0  # from the start of a spreadsheet's days to 1970
_POSITIVE = ("hook_load", "standpipe_pressure", "pump_speed", "pump_flow", "bit_depth")
_HOUR, _HOUR_TOLERANCE = 3600.0, 90.0  # s: a step of the clock that may be summer or winter time
_SHOWN = 5  # names or numbers in a note


@dataclass(frozen=True)
class ImportedTable:
    """A table that was read.

    Attributes:
        log: The log in memory; `log.imported` tells what was found and done.
        mapping: The mapping that was used, as the text of a mapping file.
    """

    log: RigLog
    mapping: str


@dataclass
class _Findings:
    """What is found and done on the way, for the record of the import and the log's notes."""

    checks: list[tuple[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    integrated: dict[str, IntegratedQuantity] = field(default_factory=dict)

    def add(self, check: str, text: str) -> None:
        """A sentence for the log checks, which is a note of the log as well."""
        if (check, text) not in self.checks:
            self.checks.append((check, text))
            self.notes.append(text)


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
    table_path = Path(path)
    rig_text = read_text(rig_path, "rig file") if rig_path is not None else None
    found = _Findings()
    if mapping_path is not None:
        mapping = load_mapping(mapping_path)
        source = open_table(table_path, mapping.layout, wits_units)
        text = read_text(mapping_path, "mapping file")
        if time_zone:
            mapping = replace(mapping, layout=replace(mapping.layout, time_zone=time_zone))
        mapping = _with_date_column(mapping, source, found)
        _check_columns(mapping, source)
        table = source.read(mapping.columns(), rows)
    else:
        source = open_table(table_path, None, wits_units)
        recognised = recognise(source, printable(str(path)), units or {}, rig_text is not None)
        if time_zone:
            recognised.tree = {**recognised.tree, "time_zone": time_zone}
        mapping = recognised.mapping(printable(str(path)))
        _check_columns(mapping, source)
        table = source.read(mapping.columns(), rows)
        mapping = _with_unsigned(recognised, mapping, table, found)
        text = mapping_text(recognised.tree, printable(str(path)))
    return ImportedTable(_Import(source, table, mapping, found).log(rig_text, rig_path), text)


def _with_unsigned(recognised: Recognised, mapping: TableMapping, table: Table, found: _Findings) -> TableMapping:
    """The recognised mapping with channels marked that have lost their sign."""
    wanted: list[str] = [
        key
        for key in UNSIGNED
        if key in mapping.channels and (key != "top_drive_angle" or mapping.channels[key].integral)
    ]
    values = {
        key: numbers(table, mapping.channels[key].column, mapping.layout.null_values, AUTO).values for key in wanted
    }
    if mark_unsigned(recognised.tree, values, recognised.notes):
        mapping = recognised.mapping(mapping.source)
    for note in recognised.notes:
        found.add("columns", note)
    return mapping


def _with_date_column(mapping: TableMapping, source: TableSource, found: _Findings) -> TableMapping:
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


class _Import:
    """One table on its way into a log."""

    def __init__(self, source: TableSource, table: Table, mapping: TableMapping, found: _Findings) -> None:
        self.mapping, self.found = mapping, found
        self.delimiter = source.format.delimiter if isinstance(source, TextTable) else ""
        self.nulls = (*mapping.layout.null_values, *source.heads.nulls)
        date_order = mapping.layout.time.date_order or source.heads.date_order
        self.table = table
        for note in self.table.notes:
            found.add("table", note)
        for note in contradicted_units(source.heads, mapping):
            found.add("columns", note)
        self.read: dict[str, Numbers] = {}
        self.nulls_of: dict[int, list[str]] = {}
        self.seconds, self.epoch_ns = self._times(date_order)
        self.kept = self._increasing()

    def log(self, rig_text: str | None, rig_path: str | os.PathLike[str] | None) -> RigLog:
        """The log with all channels."""
        mapping, found = self.mapping, self.found
        values = {name: self._channel(name) for name in mapping.channels}
        if "pump_flow" in values:
            if rig_text is None:
                raise InputError(f"{mapping.source}: channels.pump_flow: needs the rig file's mud_pump.displacement")
            values["pump_flow"] = values["pump_flow"] / parse_rig(rig_text, str(rig_path)).mud_pump.displacement
        self._note_numbers()
        built = {key: self._series(key, values) for key in TOPICS}
        for count, names in self.nulls_of.items():
            found.notes.append(f"{', '.join(names)}: {count} of {np.count_nonzero(self.kept)} rows are null")
        filled = {key: series for key, series in built.items() if series is not None}
        if not filled:
            raise InputError(f"{self.table.source}: all mapped columns are empty or null")
        origin = float(filled[next(key for key in CLOCK_TOPICS if key in filled)].time[0])
        series = {key: replace(s, time=s.time - origin, arrival=s.arrival - origin) for key, s in filled.items()}
        last = self.epoch_ns * 1e-9 + origin + max(float(s.arrival[-1]) for s in series.values())
        log = RigLog(
            source=self.table.source,
            start_ns=_start_ns(mapping, self.epoch_ns, origin, last),
            rig_text=rig_text,
            rig_source=None if rig_path is None else str(rig_path),
            metadata={},
            notes=tuple(found.notes),
            imported=ImportRecord(tuple(found.checks), found.integrated),
            **series,  # type: ignore[arg-type]
        )
        return mask_impossible_values(log)

    def _column(self, name: str, positive: bool = False) -> Array:
        """A column as numbers."""
        if name not in self.read:
            layout = self.mapping.layout
            decimal = layout.decimal
            if layout.null_words:
                self.table = _without_words(self.table, name, layout.null_words)
            self.read[name] = numbers(self.table, name, self.nulls, decimal, positive, self.delimiter)
        return self.read[name].values

    def _note_numbers(self) -> None:
        """Tell which nulls were not declared, and which marks were read. Raises InputError for doubtful points."""
        if self.mapping.layout.decimal == AUTO and any(column.comma for column in self.read.values()):
            check_points(self.table, list(self.read))
        for name, column in self.read.items():
            for null, count in column.undeclared:
                times = "once" if count == 1 else f"{count} times"
                self.found.add(
                    "nulls",
                    f"{name!r}: {null:g}, {times}, is no value of a rig: taken as null; declare it in null_values",
                )
        for mark, what in (
            ("comma", "commas are read as decimal marks"),
            ("thousands", "marks between thousands are left out"),
        ):
            if any(getattr(column, mark) for column in self.read.values()):
                self.found.add("table", what)

    def _times(self, date_order: str) -> tuple[Array, int]:
        """Time of every row, s, NaN where it has none; and the epoch ns of time 0."""
        layout, time = self.mapping.layout, self.mapping.layout.time
        start_ns = 0 if not layout.start else _epoch_ns(layout.start, f"{self.mapping.source}: start")
        if time.unit == EXCEL_DAYS:
            return (self._column(time.column) - _EXCEL_EPOCH_DAYS) * 86_400.0, 0
        if time.unit != ISO_TIME:
            return self._column(time.column) * self.mapping.scale["time"], start_ns
        stamps, notes = read_stamps(
            self.table, time.column, time.date_column, date_order, layout.time_zone, self.mapping.source, layout.start
        )
        known = stamps != NO_TIME
        if not known.any():
            raise InputError(f"{self.table.source}: no row with a time")
        first = int(stamps[known][0])
        seconds = np.where(known, (stamps - first) * 1e-9, np.nan)
        self._note_clock(seconds, first, notes)
        return seconds, first

    def _note_clock(self, seconds: Array, first: int, notes: ClockNotes) -> None:
        """Tell what was assumed about dates and zone, and where the clock seems to have been set."""
        add, time = self.found.add, self.mapping.layout.time
        if notes.date_order:
            add("clock", f"dates are read as {notes.date_order} (M is the month); if they are not, set "
                         "time.date_order in the mapping")  # fmt: skip
        if notes.without_date:
            add("clock", "the times have no date: counted from 1970-01-01; give the first row's with start")
        if notes.midnights:
            add("clock", f"the time of day passes midnight {notes.midnights} times")
        if notes.changes:
            zone = self.mapping.layout.time_zone
            add("clock", f"the clock was set back {len(notes.changes)} times for winter time, as {zone} has it")
        if notes.offset_known:
            return
        steps = np.diff(seconds)
        ahead = np.flatnonzero(np.abs(steps - _HOUR) < _HOUR_TOLERANCE)
        if ahead.size:
            clock = _clock(first, float(seconds[ahead[0]]))
            add("clock", f"the clock goes ahead by an hour at {clock}: summer time, or an outage; name the clock's "
                         f"zone with time_zone ({time.column!r} names none)")  # fmt: skip

    def _increasing(self) -> NDArray[np.bool_]:
        """Which rows to keep: those with a time, the last one of each. Raises InputError where times go back."""
        seconds, table = self.seconds, self.table
        timed = np.flatnonzero(~np.isnan(seconds))
        if not timed.size:
            raise InputError(f"{table.source}: no row with a time")
        steps = np.diff(seconds[timed])
        back = np.flatnonzero(steps < 0.0)
        if back.size:
            before, after = timed[back[0]], timed[back[0] + 1]
            advice = "if these are two runs, import each with --rows"
            if abs(steps[back[0]] + _HOUR) < _HOUR_TOLERANCE and self.mapping.layout.time.unit == ISO_TIME:
                advice = "an hour: if the clock was set to winter time, give its zone with --time-zone or time_zone"
            raise InputError(
                f"{table.where(after)}: time goes back from {seconds[before]:g} s to {seconds[after]:g} s; {advice}"
            )
        kept = np.zeros(seconds.shape, dtype=np.bool_)
        kept[timed[np.append(steps > 0.0, True)]] = True
        if not kept.all():
            self.found.add(
                "clock", f"{np.count_nonzero(~kept)} rows without a time, or with a repeated one, were left out"
            )
        return kept

    def _channel(self, name: str) -> Array:
        """One channel in SI units."""
        entry = self.mapping.channels[name]
        total = self._plain(name, entry)
        if entry.unsigned:
            total = self._signed(name, entry, total)
        if entry.integral:
            total = self._integrated(name, total)
        if entry.from_first:
            given = total[~np.isnan(total)]
            total = total - (given[0] if given.size else 0.0)
        if IMPORT_CHANNELS[name].is_wrapped:
            total = math.pi - np.mod(math.pi - total, 2.0 * math.pi)
        return total

    def _plain(self, name: str, entry: ColumnMapping) -> Array:
        positive = name in _POSITIVE
        total = self._column(entry.column, positive)
        for more in entry.plus:
            total = total + self._column(more, positive)
        if entry.abs:
            total = np.abs(total)
        return (total + (entry.offset - entry.tare)) * self.mapping.scale[name]

    def _signed(self, name: str, entry: ColumnMapping, values: Array) -> Array:
        """An unsigned speed or torque with the signs that the other gives."""
        of_speed = name != "surface_torque"
        other = "surface_torque" if of_speed else "top_drive_speed"
        where = f"{self.table.source}: column {entry.column!r} ({name})"
        if other not in self.mapping.channels:
            raise InputError(
                f"{where}: rocks without a sign, and there is no {other} to tell it; leave the channel out"
            )
        interval = float(np.median(np.diff(self.seconds[self.kept]))) if np.count_nonzero(self.kept) > 1 else 1.0
        result = signed_by(values, self._plain(other, self.mapping.channels[other]), of_speed, where, interval)
        self.found.add("signs", f"{entry.column!r} has no sign: restored from {other}, half-turn by half-turn")
        return result

    def _integrated(self, name: str, rate: Array) -> Array:
        """A speed integrated, with the error and the gaps on record."""
        # A value that no rig has is masked in the speed later; it must not turn the angle for good.
        wrong, is_other_unit = outside_range(rate, TOPICS[IMPORT_CHANNELS[name].series].quantity("velocity"))
        known = self.kept & (is_other_unit | ~wrong)
        integral = integrate(np.where(known, rate, np.nan), self.seconds)
        key = next(part.column for part in TOPICS[IMPORT_CHANNELS[name].series].quantities
                   if part.array == IMPORT_CHANNELS[name].array)  # fmt: skip
        self.found.integrated[key] = IntegratedQuantity(integral.error, integral.gaps, integral.in_gaps)
        if integral.gaps:
            many = f"{integral.gaps} gaps" if integral.gaps > 1 else "a gap"
            self.found.add(
                "integrated", f"{name} stands still over {many} of {integral.in_gaps:.0f} s in the speed: what it "
                "turned there is not known; import a stretch without gaps with --rows"
            )  # fmt: skip
        return integral.values

    def _series(self, key: str, values: Mapping[str, Array]) -> Series | None:
        """One series from its channels, without rows where all of them are null; None where nothing is left."""
        own = {IMPORT_CHANNELS[name].array: (name, values[name]) for name in values
               if IMPORT_CHANNELS[name].series == key}  # fmt: skip
        if not own:
            return None
        some = self.kept & ~np.all([np.isnan(column) for _, column in own.values()], axis=0)
        channels = self.mapping.channels
        for name, column in own.values():
            if channels[name].on_change:
                some &= _changes(column)
            missing = int(np.count_nonzero(self.kept & np.isnan(column)))
            if missing:
                self.nulls_of.setdefault(missing, []).append(name)
        if not some.any():
            return None
        arrival = self.seconds[some]
        measured = arrival - max(channels[name].delay for name, _ in own.values())
        arrays = {array: column[some] for array, (_, column) in own.items()}
        return build_series(TOPICS[key], measured, arrival, arrays)


def _clock(epoch_ns: int, seconds: float) -> str:
    moment = datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=epoch_ns / SECOND + seconds)
    return moment.strftime("%Y-%m-%d %H:%M:%S")


def _without_words(table: Table, name: str, words: tuple[str, ...]) -> Table:
    """A table with cells of one column empty where they hold one of these words."""
    cells = table.columns[name]
    if isinstance(cells, np.ndarray):
        return table
    lower = {word.strip().lower() for word in words}
    cleaned = ["" if str(cell).strip().lower() in lower else str(cell) for cell in cells]
    return replace(table, columns={**table.columns, name: cleaned})


def _start_ns(mapping: TableMapping, epoch_ns: int, origin: float, last: float) -> int:
    """ns since the epoch of the first time, `origin`. Raises InputError for times that a stamp cannot hold."""
    if last >= MAX_EPOCH_S or origin < -MAX_EPOCH_S:
        raise InputError(
            f"{mapping.source}: time.unit = {mapping.layout.time.unit!r}: times would end in the year "
            f"{round(1970 + last / 31_556_952, 0):.6g}; are they in ms, us or ns?"
        )
    start_ns = epoch_ns + round(origin * 1e9)
    if start_ns < 0:
        raise InputError(f"{mapping.source}: start: times begin at {start_ns * 1e-9:g} s; give the table's start time")
    return start_ns


def _check_columns(mapping: TableMapping, source: TableSource) -> None:
    """Raise InputError for a column that is missing, or there twice with different values."""
    names = source.heads.names
    layout = mapping.layout.time
    entries: list[tuple[str, str]] = [("time", layout.column)]
    entries += [("time.date_column", layout.date_column)] if layout.date_column else []
    for key, channel in mapping.channels.items():
        entries += [(f"channels.{key}", name) for name in (channel.column, *channel.plus)]
    for where, name in entries:
        twins = [other for other in names if other == name or re.fullmatch(re.escape(name) + r" \(\d+\)", other)]
        if name not in names or (len(twins) > 1 and f"{name} (2)" not in [entry for _, entry in entries]):
            if name in names and _equal_columns(source, twins):
                continue
            count = len(twins) if name in names else "no"
            advice = f"; write {twins[1]!r} for the second" if len(twins) > 1 else ""
            raise InputError(
                f"{mapping.source}: {where}: column {name!r}: {count} such column in the table, "
                f"which has {' '.join(', '.join(names).split())[:300]}{advice}"
            )


def _equal_columns(source: TableSource, names: list[str]) -> bool:
    columns = source.read(names, None).columns
    return all(list(columns[name]) == list(columns[names[0]]) for name in names[1:])


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
    return (since.days * 86400 + since.seconds) * SECOND + since.microseconds * 1000


def _changes(column: Array) -> NDArray[np.bool_]:
    """Where a value is given and differs from the last given one."""
    given = np.flatnonzero(~np.isnan(column))
    changed = np.zeros(column.shape, dtype=np.bool_)
    changed[given] = np.append(True, np.diff(column[given]) != 0.0)[: given.size]
    return changed
