"""Finds numbers of a recorded log that mean "no value" (-999.25, -9999, ...), in whatever unit they were written."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import Array
from slider_drilling.log.timestamps import Mask
from slider_drilling.messages.topics import TOPICS, TopicQuantity
from slider_drilling.null_values import is_null_of_others, null_in_some_unit, stands_apart
from slider_drilling.units import KINDS

_CHANNELS = ("top_drive", "draw_works", "standpipe_pressure", "mud_pump", "mwd_tool_face")
_POSITIVE = ("hook_load", "standpipe_pressure", "pump_speed")
_MAX_SHARE = 0.5  # of the values
_MAX_NULLS = 4  # different ones of one quantity
_ROUNDING = 1e-9  # of a null's value in another unit


@dataclass(frozen=True)
class FoundNull:
    """A number that means no value in one quantity of a log.

    Attributes:
        key: Of the series.
        quantity: What it is a null of.
        where: Its samples, (n,).
        time: When they were measured, s, (n,).
        number: As it was written.
        unit: In which it was written.
        shared_with: The other quantity whose null it is, where its own values leave it in doubt.
    """

    key: str
    quantity: TopicQuantity
    where: Mask
    time: Array
    number: float
    unit: str
    shared_with: str = ""

    def __str__(self) -> str:
        label, count, first = self.quantity.label, np.count_nonzero(self.where), self.time[self.where][0]
        null = f"{self.number:.10g} {self.unit}"
        shared = f", a null as in {self.shared_with}" if self.shared_with else ""
        return f"{label}: {count} of {self.where.size} samples are {null}{shared}, the first at {first:.1f} s"


def find_nulls(log: RigLog) -> list[FoundNull]:
    """Undeclared nulls of measured channels: by a quantity's own values, then by those of the others."""
    own = [null for key, quantity, time, values in _quantities(log) for null in _own(key, quantity, time, values)]
    return own + [
        null
        for key, quantity, time, values in _quantities(log)
        for null in _shared(key, quantity, time, values, own)
    ]  # fmt: skip


def without_nulls(log: RigLog, nulls: Sequence[FoundNull]) -> RigLog:
    """The log with these nulls as NaN."""
    series: dict[str, Any] = {}
    for null in nulls:
        of_key = series.get(null.key, getattr(log, null.key))
        values = np.where(null.where, math.nan, getattr(of_key, null.quantity.array))
        series[null.key] = replace(of_key, **{null.quantity.array: values})
    return replace(log, **series)


def mask_shared_nulls(log: RigLog) -> RigLog:
    """The log without nulls that only other channels show, with a note for each.

    Values that no rig has are nulls of the others, too: look for shared ones before they are taken out.
    """
    shared = [null for null in find_nulls(log) if null.shared_with]
    return replace(without_nulls(log, shared), notes=(*log.notes, *(f"{null}: left out" for null in shared)))


def _quantities(log: RigLog) -> Iterator[tuple[str, TopicQuantity, Array, Array]]:
    """Series, quantity, time and values of what may hold nulls."""
    for key in _CHANNELS:
        series: Any = log.series().get(key)
        for quantity in TOPICS[key].quantities if series is not None else ():
            yield key, quantity, series.time, getattr(series, quantity.array)


def _own(key: str, quantity: TopicQuantity, time: Array, values: Array) -> Iterator[FoundNull]:
    """Nulls that stand far outside all other values of a quantity."""
    known = values[np.isfinite(values)]
    total = known.size
    for _ in range(_MAX_NULLS):
        found = _null_at_an_end(known, total, quantity)
        if found is None:
            return
        end, number, unit = found
        yield FoundNull(key, quantity, values == end, time, number, unit)
        known = known[known != end]


def _null_at_an_end(known: Array, total: int, quantity: TopicQuantity) -> tuple[float, float, str] | None:
    """The lowest or highest value if it is a null, with number and unit as it was written."""
    if known.size < 3:
        return None
    for end in (float(known.min()), float(known.max())):
        written = null_in_some_unit(end, quantity.unit)
        if written is None:
            continue
        others = known[known != end]
        few = others.size >= 2 and total - others.size <= _MAX_SHARE * total
        if few and stands_apart(end, others, quantity.column in _POSITIVE):
            return end, *written
    return None


def _shared(
    key: str, quantity: TopicQuantity, time: Array, values: Array, own: Sequence[FoundNull]
) -> Iterator[FoundNull]:
    """Nulls of other quantities that stand among the values of this one, in any unit of its kind."""
    taken = [null for null in own if null.key == key and null.quantity is quantity]
    units = next((units for units in KINDS.values() if next(iter(units)) == quantity.unit), {quantity.unit: 1.0})
    left = np.isfinite(values)
    for null in taken:
        left &= ~null.where
    for number in dict.fromkeys(null.number for null in own if null not in taken):
        owners = [null for null in own if null.number == number and null not in taken]
        beside = _beside(time, np.concatenate([owner.time[owner.where] for owner in owners]))
        for unit, factor in units.items():
            where = left & np.isclose(values, number * factor, rtol=_ROUNDING, atol=0.0)
            if where.any() and is_null_of_others(number * factor, where, values[left & ~where], beside):
                yield FoundNull(key, quantity, where, time, number, unit, owners[0].quantity.label)
                left &= ~where


def _beside(time: Array, nulls: Array) -> Mask:
    """Which times are within half a sample of one of the others, (n,)."""
    nulls = np.sort(nulls)
    after = np.searchsorted(nulls, time).clip(max=nulls.size - 1)
    distance = np.minimum(np.abs(nulls[after] - time), np.abs(nulls[np.maximum(after - 1, 0)] - time))
    step = float(np.median(np.diff(time))) if time.size > 1 else 0.0
    return np.asarray(distance <= 0.5 * step)
