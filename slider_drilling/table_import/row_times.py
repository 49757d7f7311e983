"""The time of every row of a table, and which rows to keep."""

from __future__ import annotations

import datetime
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.log.timestamps import SECOND
from slider_drilling.schema.yaml_tree import shorten
from slider_drilling.table_import.column_reader import ColumnReader
from slider_drilling.table_import.findings import Findings
from slider_drilling.table_import.mapping import EXCEL_DAYS, ISO_TIME, TableLayout, TableMapping
from slider_drilling.table_import.source import Array, Table
from slider_drilling.table_import.times import NO_TIME, ClockNotes, read_stamps

MAX_EPOCH_S = 2.0**31  # the last second that a message's stamp can hold: January 2038
_EXCEL_EPOCH_DAYS = 25_569.0  # from the start of a spreadsheet's days to 1970
_HOUR, _HOUR_TOLERANCE = 3600.0, 90.0  # s: a step of the clock that may be summer or winter time


@dataclass(frozen=True)
class RowTimes:
    """Times of the rows.

    Attributes:
        seconds: s since `epoch_ns`, NaN in rows without a time, (n,).
        epoch_ns: ns since 1970.
        kept: Rows with a time, the last one of each, (n,).
    """

    seconds: Array
    epoch_ns: int
    kept: NDArray[np.bool_]

    @property
    def interval(self) -> float:
        """Median time between two rows, s."""
        kept = self.seconds[self.kept]
        return float(np.median(np.diff(kept))) if kept.size > 1 else 1.0


def row_times(reader: ColumnReader, mapping: TableMapping, date_order: str, found: Findings) -> RowTimes:
    """The times of a table's rows.

    Args:
        reader: Of the table.
        mapping: Its mapping.
        date_order: Order of the parts of its dates; empty where nothing declares it.
        found: Gets what was assumed.

    Raises:
        InputError: A cell is no time, there is none, or times go back.
    """
    seconds, epoch_ns, zone_unknown = _seconds(reader, mapping, date_order, found)
    kept = _increasing(seconds, reader.table, zone_unknown, found)
    return RowTimes(seconds, epoch_ns, kept)


def _seconds(
    reader: ColumnReader, mapping: TableMapping, date_order: str, found: Findings
) -> tuple[Array, int, bool]:
    """Time of every row, s, NaN where it has none; the epoch ns of time 0; whether a zone would change the times."""
    layout, time = mapping.layout, mapping.layout.time
    start = 0 if not layout.start else _epoch_ns(layout.start, f"{mapping.source}: start")
    if time.unit == EXCEL_DAYS:
        return (reader.values(time.column) - _EXCEL_EPOCH_DAYS) * 86_400.0, 0, False
    if time.unit != ISO_TIME:
        return reader.values(time.column) * mapping.scale["time"], start, False
    stamps, notes = read_stamps(
        reader.table, time.column, time.date_column, date_order, layout.time_zone, mapping.source, layout.start
    )
    known = stamps != NO_TIME
    if not known.any():
        raise InputError(f"{reader.table.source}: no row with a time")
    first = int(stamps[known][0])
    seconds = np.where(known, (stamps - first) * 1e-9, np.nan)
    _note_clock(seconds, first, notes, layout, found)
    return seconds, first, not notes.offset_known


def _note_clock(seconds: Array, first: int, notes: ClockNotes, layout: TableLayout, found: Findings) -> None:
    """Tell what was assumed about dates and zone, and where the clock seems to have been set."""
    add = found.add
    if notes.date_order:
        add("clock", f"dates are read as {notes.date_order} (M is the month); if they are not, set "
                     "time.date_order in the mapping")  # fmt: skip
    if notes.without_date:
        add("clock", "the times have no date: counted from 1970-01-01; give the first row's with start")
    if notes.midnights:
        add("clock", f"the time of day passes midnight {notes.midnights} times")
    if notes.changes:
        add("clock", f"the clock was set back {len(notes.changes)} times for winter time, as {layout.time_zone} has it")
    if notes.offset_known:
        return
    steps = np.diff(seconds)
    ahead = np.flatnonzero(np.abs(steps - _HOUR) < _HOUR_TOLERANCE)
    if ahead.size:
        clock = _clock(first, float(seconds[ahead[0]]))
        add("clock", f"the clock goes ahead by an hour at {clock}: summer time, or an outage; name the clock's "
                     f"zone with time_zone ({layout.time.column!r} names none)")  # fmt: skip


def _clock(epoch_ns: int, seconds: float) -> str:
    moment = datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=epoch_ns / SECOND + seconds)
    return moment.strftime("%Y-%m-%d %H:%M:%S")


def _increasing(seconds: Array, table: Table, zone_unknown: bool, found: Findings) -> NDArray[np.bool_]:
    """Which rows to keep: those with a time, the last one of each. Raises InputError where times go back."""
    timed = np.flatnonzero(~np.isnan(seconds))
    if not timed.size:
        raise InputError(f"{table.source}: no row with a time")
    steps = np.diff(seconds[timed])
    back = np.flatnonzero(steps < 0.0)
    if back.size:
        before, after = timed[back[0]], timed[back[0] + 1]
        advice = "if these are two runs, import each with --rows"
        if abs(steps[back[0]] + _HOUR) < _HOUR_TOLERANCE and zone_unknown:
            advice = "an hour: if the clock was set to winter time, give its zone with --time-zone or time_zone"
        raise InputError(
            f"{table.where(after)}: time goes back from {seconds[before]:g} s to {seconds[after]:g} s; {advice}"
        )
    kept = np.zeros(seconds.shape, dtype=np.bool_)
    kept[timed[np.append(steps > 0.0, True)]] = True
    if not kept.all():
        untimed, repeated = seconds.size - timed.size, int(timed.size - np.count_nonzero(kept))
        if untimed:
            found.add("clock", f"{untimed} of {seconds.size} rows have no time: left out")
        if repeated:
            coarse = 2 * repeated > timed.size
            advice = "; the times are coarser than the rows: export them with fractions of a second" if coarse else ""
            found.add("clock", f"{repeated} of {seconds.size} rows repeat a time: the last of each is kept{advice}")
    return kept


def start_ns(mapping: TableMapping, times: RowTimes, origin: float, last: float) -> int:
    """When the log begins, ns since the epoch.

    Args:
        mapping: Names unit and start of the times.
        times: Of the rows.
        origin: The log's first time, s, as the rows count it.
        last: Its last time, s since the epoch.

    Raises:
        InputError: A stamp cannot hold these times.
    """
    if last >= MAX_EPOCH_S or origin < -MAX_EPOCH_S:
        raise InputError(
            f"{mapping.source}: time.unit = {mapping.layout.time.unit!r}: times would end in the year "
            f"{round(1970 + last / 31_556_952, 0):.6g}; are they in ms, us or ns?"
        )
    begin = times.epoch_ns + round(origin * 1e9)
    if begin < 0:
        raise InputError(f"{mapping.source}: start: times begin at {begin * 1e-9:g} s; give the table's start time")
    return begin


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
