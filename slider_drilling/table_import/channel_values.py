"""The channels of a log from the columns of a table: units, signs, integrals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.angles import wrap_angle
from slider_drilling.errors import InputError
from slider_drilling.log.import_record import IntegratedQuantity
from slider_drilling.log.value_limits import outside_range
from slider_drilling.messages.topics import TOPICS
from slider_drilling.table_import.column_reader import ColumnReader
from slider_drilling.table_import.findings import Findings
from slider_drilling.table_import.integrate import integrate
from slider_drilling.table_import.mapping import IMPORT_CHANNELS, ColumnMapping, TableMapping
from slider_drilling.table_import.rocking_signs import signed_by
from slider_drilling.table_import.row_times import RowTimes
from slider_drilling.table_import.source import Array

_POSITIVE = ("hook_load", "standpipe_pressure", "pump_speed", "pump_flow", "bit_depth")


@dataclass(frozen=True)
class ChannelValues:
    """The channels of a table.

    Attributes:
        reader: Of its columns.
        mapping: Its mapping.
        times: Of its rows.
        found: Gets what was done.
    """

    reader: ColumnReader
    mapping: TableMapping
    times: RowTimes
    found: Findings

    def read_columns(self) -> None:
        """Read the columns of all channels, for what one shows of the nulls of the others. Raises InputError."""
        names = []
        for name, entry in self.mapping.channels.items():
            for column in (entry.column, *entry.plus):
                self.reader.values(column, name in _POSITIVE)
                names.append(column)
        self.reader.share_nulls(names)

    def channel(self, name: str) -> Array:
        """One channel in SI units, (n,), NaN where it has no value. Raises InputError."""
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
            total = wrap_angle(total)
        return total

    def _plain(self, name: str, entry: ColumnMapping) -> Array:
        positive = name in _POSITIVE
        total = self.reader.values(entry.column, positive)
        for more in entry.plus:
            total = total + self.reader.values(more, positive)
        if entry.abs:
            total = np.abs(total)
        return (total + (entry.offset - entry.tare)) * self.mapping.scale[name]

    def _signed(self, name: str, entry: ColumnMapping, values: Array) -> Array:
        """An unsigned speed or torque with the signs that the other gives."""
        of_speed = name != "surface_torque"
        other = "surface_torque" if of_speed else "top_drive_speed"
        where = f"{self.reader.table.source}: column {entry.column!r} ({name})"
        if other not in self.mapping.channels:
            raise InputError(
                f"{where}: rocks without a sign, and there is no {other} to tell it; leave the channel out"
            )
        known = self._plain(other, self.mapping.channels[other])
        result = signed_by(values, known, of_speed, where, self.times.interval)
        self.found.add("signs", f"{entry.column!r} has no sign: restored from {other}, half-turn by half-turn")
        return result

    def _integrated(self, name: str, rate: Array) -> Array:
        """A speed integrated, with the error and the gaps on record."""
        # A value that no rig has is masked in the speed later; it must not turn the angle for good.
        wrong, is_other_unit = outside_range(rate, TOPICS[IMPORT_CHANNELS[name].series].quantity("velocity"))
        known = self.times.kept & (is_other_unit | ~wrong)
        integral = integrate(np.where(known, rate, np.nan), self.times.seconds)
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
