"""Dates and times of a table as ns since the epoch: any order of the date, AM and PM, time zones, clock changes."""

from __future__ import annotations

import datetime
import functools
import re
import zoneinfo
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.log.timestamps import SECOND
from slider_drilling.schema.yaml_tree import shorten
from slider_drilling.table_import.numbers import NULL_WORDS
from slider_drilling.table_import.source import Table

Stamps = NDArray[np.int64]
DAY = 86_400 * SECOND
HOUR = 3_600 * SECOND
NO_TIME = np.iinfo(np.int64).min

_EPOCH = datetime.date(1970, 1, 1).toordinal()
_TIME = re.compile(
    r"(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2})(?:[.,:](?P<fraction>\d+))?)?"
    r"\s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*(?P<zone>[Zz]|UTC|GMT|[+-]\d{2}:?\d{2})?$"
)
_MONTHS = {name: number for number, name in enumerate(
    ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"], 1)}  # fmt: skip
ORDERS = ("YMD", "MDY", "DMY")


@dataclass
class ClockNotes:
    """What was done to read the times.

    Attributes:
        date_order: Order of the date's parts that was used; empty where the dates leave no doubt.
        without_date: Whether times of day had no date.
        midnights: How often a time of day without a date passed midnight.
        changes: Times (ns) at which the clock of `time_zone` was set back.
        offset_known: Whether the times name their zone, or `time_zone` does.
    """

    date_order: str = ""
    without_date: bool = False
    midnights: int = 0
    changes: list[int] = field(default_factory=list)
    offset_known: bool = False


def read_stamps(
    table: Table, column: str, date_column: str, date_order: str, time_zone: str, source: str, start: str = ""
) -> tuple[Stamps, ClockNotes]:
    """Times of all rows.

    Args:
        table: The table.
        column: With the times, or dates and times.
        date_column: With the dates; empty where `column` holds them.
        date_order: "DMY", "MDY" or "YMD" where dates could be read in two ways; empty for what they show.
        time_zone: IANA name of the zone of times that name none, such as Europe/Oslo; empty for UTC.
        source: The mapping file, for messages.
        start: Date of the first row, where the table has only times of day.

    Returns:
        ns since the epoch, NO_TIME where a row has none; and what was done.

    Raises:
        InputError: A cell is no time, or the zone is unknown.
    """
    notes = ClockNotes()
    cells = table.columns[column]
    if isinstance(cells, np.ndarray) and cells.dtype.kind == "M":
        stamps = cells.astype("datetime64[ns]").astype(np.int64)
        if date_column:
            stamps = stamps % DAY + _days_of(table, date_column)
        elif np.all((stamps == NO_TIME) | ((stamps >= 0) & (stamps < DAY))):
            _count_days(stamps, notes, start)  # times of day of a workbook
        return _to_utc(stamps, np.isin(stamps, NO_TIME), time_zone, source, notes), notes
    if isinstance(cells, np.ndarray):
        raise InputError(
            f"{table.source}: column {column!r}: holds numbers, not dates; give time.unit, such as s or ms"
        )
    dates = table.columns[date_column] if date_column else None
    stamps, zoned = _parse(table, column, cells, dates, date_column, date_order, notes, start)  # type: ignore[arg-type]
    notes.offset_known = bool(time_zone) or bool(zoned.any())
    bare = np.flatnonzero(~zoned & (stamps != NO_TIME))
    if zoned.any() and bare.size and not time_zone:
        raise InputError(
            f"{table.where(int(bare[0]))}: column {column!r} = {shorten(cells[bare[0]])}: names no zone, others do; "
            "give it with --time-zone or time_zone"
        )
    return _to_utc(stamps, zoned | (stamps == NO_TIME), time_zone, source, notes), notes


def _days_of(table: Table, column: str) -> Stamps:
    cells = table.columns[column]
    if not (isinstance(cells, np.ndarray) and cells.dtype.kind == "M"):
        raise InputError(f"{table.source}: column {column!r}: holds no dates beside times")
    return cells.astype("datetime64[D]").astype(np.int64) * DAY


def _parse(
    table: Table,
    column: str,
    cells: Sequence[str],
    dates: Sequence[str] | None,
    date_column: str,
    order: str,
    notes: ClockNotes,
    start: str,
) -> tuple[Stamps, NDArray[np.bool_]]:
    """Stamps in the table's own clock, and which of them are UTC already."""
    split = [_split(cell) for cell in cells]
    if dates is not None:
        split = [(str(date).strip().split(" ")[0], time) for date, (_, time) in zip(dates, split, strict=True)]
    written = {date for date, time in split if date and date.lower() not in NULL_WORDS}
    if dates is None and len(written) < sum(bool(date) for date, _ in split) and not any(time for _, time in split):
        raise InputError(
            f"{table.source}: column {column!r}: holds dates without times of day, and repeats them; name the column "
            "of times in a mapping file (--mapping), and this one as its date_column"
        )
    where = f"{table.source}: column {(date_column or column)!r}"
    days = _days(written, order, notes, where)
    stamps = np.full(len(split), NO_TIME, dtype=np.int64)
    zoned = np.zeros(len(split), dtype=np.bool_)
    for index, (date, time) in enumerate(split):
        if time.lower() in NULL_WORDS and (not date or date.lower() in NULL_WORDS or time):
            continue
        if date and date.lower() in NULL_WORDS:
            continue
        clock, offset = _time_of_day(time) if time else (0, None)
        day = days.get(date) if date else 0
        if clock is None or day is None:
            raise InputError(
                f"{table.where(index)}: column {column!r} = {shorten(cells[index])}: not a time; "
                "write 2024-05-01T12:00:00Z"
            )
        stamps[index] = day * DAY + clock - (offset or 0)
        zoned[index] = offset is not None
    if not written:
        _count_days(stamps, notes, start)
    return stamps, zoned


def _split(cell: str) -> tuple[str, str]:
    """Date and time of day as they are written; either may be empty."""
    text = cell.strip()
    match = re.search(r"\d{1,2}:\d{2}.*$", text)
    if match is None:
        return ("", text) if text.lower() in NULL_WORDS else (text, "")
    date = text[: match.start()].rstrip(" ,-\t")
    return date[:-1] if len(date) > 8 and date[-1] in "Tt" and date[-2].isdigit() else date, match[0]


@functools.lru_cache(maxsize=200_000)
def _time_of_day(text: str) -> tuple[int | None, int | None]:
    """ns since midnight, None for no time; and the offset from UTC in ns, None where it names none."""
    match = _TIME.match(text)
    if match is None:
        return None, None
    hour, minute, second = int(match["hour"]), int(match["minute"]), int(match["second"] or 0)
    if match["half"]:
        if not 1 <= hour <= 12:
            return None, None
        hour = hour % 12 + (12 if match["half"][0] in "pP" else 0)
    if hour > 24 or minute > 59 or second > 60:
        return None, None
    fraction = int(f"{match['fraction'] or '0':0<9.9}")
    zone = match["zone"]
    offset = None
    if zone:
        sign = -1 if zone[0] == "-" else 1
        digits = zone[1:].replace(":", "")
        offset = sign * (int(digits[:2]) * HOUR + int(digits[2:]) * 60 * SECOND) if zone[0] in "+-" else 0
    return hour * HOUR + (minute * 60 + second) * SECOND + fraction, offset


def _days(written: set[str], order: str, notes: ClockNotes, where: str) -> dict[str, int | None]:
    """Days since the epoch of each date that is written; None for no date."""
    parts = {date: _date_parts(date) for date in written}
    known = [part for part in parts.values() if part is not None]
    fits = [candidate for candidate in ORDERS if all(_day(part, candidate) is not None for part in known)]
    if order and known and order not in fits:
        raise InputError(f"{where}: dates such as {shorten(min(written))} are not in date_order {order}")
    if not order and known and len(fits) > 1:
        spans = {one: _span([_day(part, one) for part in known]) for one in fits}
        shortest = [one for one in _usual_orders(min(written)) if spans.get(one) == min(spans.values())]
        # A log lasts days, not months: the wrong order tears the days of a log apart.
        order = shortest[0]
        if len(shortest) > 1:
            notes.date_order = order
    elif not order and fits:
        order = fits[0]
    return {date: None if part is None or not order else _day(part, order) for date, part in parts.items()}


def _usual_orders(date: str) -> tuple[str, ...]:
    """Orders of the date's parts, the usual one for its separator first: 14.3. and 14-3, but 3/14."""
    return ("YMD", "MDY", "DMY") if "/" in date else ("YMD", "DMY", "MDY")


def _span(days: list[int | None]) -> int:
    known = [day for day in days if day is not None]
    return max(known, default=0) - min(known, default=0)


def _date_parts(date: str) -> tuple[str, str, str] | None:
    """The three parts of a date as they are written, a month's name as its number."""
    text = date.strip().strip(",")
    if re.fullmatch(r"\d{8}", text):
        return text[:4], text[4:6], text[6:]
    parts = [part for part in re.split(r"[-/., ]+", text) if part]
    parts = [part for part in parts if part.lower()[:3] not in ("mon", "tue", "wed", "thu", "fri", "sat", "sun")]
    if len(parts) != 3:
        return None
    named = [index for index, part in enumerate(parts) if part.lower()[:3] in _MONTHS]
    if len(named) == 1:
        month = f"m{_MONTHS[parts[named[0]].lower()[:3]]}"
        parts[named[0]] = month
    return (parts[0], parts[1], parts[2]) if all(re.fullmatch(r"m?\d{1,4}", part) for part in parts) else None


def _day(parts: tuple[str, str, str], order: str) -> int | None:
    """Days since the epoch of a date in this order of its parts; None where they do not fit."""
    by_letter = dict(zip(order, parts, strict=True))
    month, day, year = by_letter["M"], by_letter["D"], by_letter["Y"]
    if "m" in day or "m" in year or (any("m" in part for part in parts) and "m" not in month):
        return None
    if len(year) not in (2, 4) or len(day) > 2 or len(month.lstrip("m")) > 2:
        return None
    # Two digits of a year stand at the end, unless the table says otherwise.
    if len(year) == 2 and order == "YMD":
        return None
    number = int(year) + (0 if len(year) == 4 else 2000 if int(year) < 70 else 1900)
    try:
        return datetime.date(number, int(month.lstrip("m")), int(day)).toordinal() - _EPOCH
    except ValueError:
        return None


def _count_days(stamps: Stamps, notes: ClockNotes, start: str) -> None:
    """Let times of day without a date pass midnight, from the date of `start` on."""
    known = np.flatnonzero(stamps != NO_TIME)
    if not known.size:
        return
    notes.without_date = not start
    times = stamps[known]
    # A step back by more than half a day is midnight; a smaller one is an error of the table.
    passed = np.cumsum(np.r_[0, np.diff(times) < -DAY // 2])
    notes.midnights = int(passed[-1])
    first = 0
    if start:
        parts = _date_parts(_split(start)[0])
        first = (_day(parts, "YMD") or 0) if parts is not None else 0
    stamps[known] = times + (passed + first) * DAY


def _to_utc(stamps: Stamps, ready: NDArray[np.bool_], time_zone: str, source: str, notes: ClockNotes) -> Stamps:
    """Stamps of a local clock in UTC; the second pass through the hour before winter time is found by its order."""
    if not time_zone:
        return stamps
    try:
        zone = zoneinfo.ZoneInfo(time_zone)
    except (zoneinfo.ZoneInfoNotFoundError, ValueError, OSError):
        raise InputError(
            f"{source}: time_zone = {shorten(time_zone)}: not known; write an IANA name such as Europe/Oslo or UTC"
        ) from None
    result, second_pass, before = stamps.copy(), False, NO_TIME
    for index in np.flatnonzero(~ready).tolist():
        local = int(stamps[index])
        early, late = _offsets(zone, local // (900 * SECOND))
        if early == late:
            second_pass = False
        elif early > late and not second_pass and before != NO_TIME and local < before - 60 * SECOND:
            second_pass = True
            notes.changes.append(index)
        result[index] = local - (late if second_pass else early)
        before = local
    return result


@functools.lru_cache(maxsize=100_000)
def _offsets(zone: zoneinfo.ZoneInfo, quarter: int) -> tuple[int, int]:
    """Offsets from UTC (ns) of a quarter of an hour of the local clock, in its first and its second pass."""
    moment = datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=quarter * 900)
    found = []
    for fold in (0, 1):
        shift = moment.replace(fold=fold, tzinfo=zone).utcoffset() or datetime.timedelta(0)
        found.append(round(shift.total_seconds()) * SECOND)
    return found[0], found[1]
