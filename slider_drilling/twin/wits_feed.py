"""A stream of WITS level 0 as samples of a twin, record by record."""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.table_import.mapping import ColumnMapping, TableMapping
from slider_drilling.table_import.numbers import numbers
from slider_drilling.table_import.recognise import recognise
from slider_drilling.table_import.rocking_signs import looks_unsigned
from slider_drilling.table_import.source import TableInMemory
from slider_drilling.table_import.wits import ITEMS, TIME, is_usable, iterate_records, wits_table
from slider_drilling.twin.feed import Samples
from slider_drilling.twin.samples import Array

_FIRST_RECORDS = 5  # from which the channels are recognised
_MANY_RECORDS = 120  # after which it is said that none can be used, or that a speed rocks without a sign


class WitsFeed:
    """Reads what a stream has sent.

    Args:
        receive: See `slider_drilling.table_import.live_wits.open_stream`.
        source: Its name, for messages.
        units: "field" or "metric".
        rig: For the pump's displacement.
        note: Called with each sentence on how columns were recognised.
    """

    def __init__(
        self, receive: Callable[[], bytes | None], source: str, units: str, rig: Rig,
        note: Callable[[str], None] = lambda text: None,
    ) -> None:  # fmt: skip
        self._receive, self._source, self._units, self._rig, self._note = receive, source, units, rig, note
        self._text = ""
        self._records: list[tuple[int, dict[str, str]]] = []
        self._mapping: TableMapping | None = None
        self._seen: dict[str, str] = {}  # the first value of each item, as one record
        self._noted: set[str] = set()
        self._start: datetime.datetime | None = None
        self._first: dict[str, float] = {}
        self._last: dict[str, float] = {}
        self._signs: list[tuple[float, float]] = []
        self.ended = False

    def poll(self) -> list[Samples]:
        """See `Feed`. Raises InputError for a stream that cannot be used."""
        block = self._receive()
        self.ended = block == b""
        self._text += (block or b"").decode("latin-1")
        whole = self._text.rfind("!!")
        if whole >= 0:
            self._records += iterate_records(self._text[: whole + 2].splitlines())
            self._text = self._text[whole + 2 :]
        usable = [(line, record) for line, record in self._records if is_usable(record)]
        if self._mapping is None and not self._shows_channels(len(usable)):
            return []
        if not usable and self._mapping is not None:
            self._records.clear()
            return []
        records, self._records = usable or self._records, []
        self._recognise([record for _, record in records])
        # Each by itself, in the order in which they came: that shows a clock that is set back.
        return [self._samples(wits_table([each], self._source, self._units)) for each in records]

    def _shows_channels(self, usable: int) -> bool:
        """Whether so many usable records are enough to begin. Raises InputError for a stream without a record."""
        if self.ended and not self._records:
            raise InputError(f"{self._source}: sent no whole WITS record (&& to !!); check that the sender is on")
        return self.ended or usable >= _FIRST_RECORDS or len(self._records) >= _MANY_RECORDS

    def _recognise(self, records: list[dict[str, str]]) -> None:
        """Find the channels of items that are new; a stream sends some of them less often than others."""
        known = set(self._seen) & set(ITEMS)
        for record in records:
            for item, text in record.items():
                if text:
                    self._seen.setdefault(item, text)
        if self._mapping is not None and set(self._seen) & set(ITEMS) == known:
            return
        found = recognise(wits_table([(1, self._seen)], self._source, self._units), self._source, {}, True)
        mapping, before = found.mapping(self._source), self._mapping
        if before is None:
            if not {"top_drive_angle", "top_drive_speed"} & set(mapping.channels):
                raise InputError(f"{self._source}: holds no top drive (RPMA); without it nothing drives the twin")
        else:
            # What a channel is made of stays: another column may have another zero.
            held = {*before.channels, *(["pump_speed"] if "pump_flow" in before.channels else [])}
            added = {name: entry for name, entry in mapping.channels.items() if name not in held}
            mapping = replace(before, channels={**before.channels, **added}, scale={**mapping.scale, **before.scale})
        self._mapping = mapping
        for text in found.notes:
            if text not in self._noted:
                self._noted.add(text)
                self._note(text)

    def _samples(self, table: TableInMemory) -> Samples:
        assert self._mapping is not None
        time = self._seconds(table)
        samples: Samples = {}
        for name, entry in self._mapping.channels.items():
            # The twin integrates speeds itself.
            if entry.integral or entry.column not in table.heads.names:
                continue
            values = self._values(name, entry, table)
            if name == "pump_flow":
                name, values = "pump_speed", values / self._rig.mud_pump.displacement
            if name == "bit_depth":
                continue
            changed = self._changed(name, values) if entry.on_change else np.ones(values.size, dtype=bool)
            samples[name] = time[changed], values[changed]
        self._check_sign(samples)
        return samples

    def _seconds(self, table: TableInMemory) -> Array:
        seconds = np.full(len(table.table.rows), math.nan)
        for index, text in enumerate(table.table.columns[TIME]):
            if text:
                moment = datetime.datetime.fromisoformat(str(text))
                self._start = self._start or moment
                seconds[index] = (moment - self._start).total_seconds()
        return seconds

    def _values(self, name: str, entry: ColumnMapping, table: TableInMemory) -> Array:
        assert self._mapping is not None
        total = np.full(len(table.table.rows), entry.offset - entry.tare)
        for column in (entry.column, *entry.plus):
            if column in table.heads.names:
                total = total + numbers(table.table, column, table.heads.nulls, ".").values
        values = self._mapping.scale[name] * total
        values = np.abs(values) if entry.abs else values
        if entry.from_first and np.isfinite(values).any():
            values = values - self._first.setdefault(name, float(values[np.isfinite(values)][0]))
        return np.asarray(values)

    def _changed(self, name: str, values: Array) -> Array:
        """Where a value is given and differs from the one before."""
        changed = np.zeros(values.size, dtype=bool)
        for index, value in enumerate(values):
            changed[index] = math.isfinite(value) and value != self._last.get(name)
            if math.isfinite(value):
                self._last[name] = float(value)
        return changed

    def _check_sign(self, samples: Samples) -> None:
        """Raise InputError for a speed that has lost its sign although the drive rocks."""
        if len(self._signs) >= _MANY_RECORDS or not {"top_drive_speed", "surface_torque"} <= set(samples):
            return
        speed, torque = samples["top_drive_speed"][1], samples["surface_torque"][1]
        if speed.size == torque.size:
            self._signs += list(zip(speed.tolist(), torque.tolist(), strict=True))
        if len(self._signs) >= _MANY_RECORDS:
            speeds, torques = np.array(self._signs).T
            if looks_unsigned(speeds, torques, of_speed=True):
                raise InputError(
                    f"{self._source}: RPMA rocks without a sign, so nothing tells which way the drive turns; send a "
                    "signed speed, or record the stream and import it, which restores the signs"
                )
