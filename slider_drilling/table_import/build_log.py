"""A log from the channels of a table."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.log.import_record import ImportRecord
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import Array, Series, build_series
from slider_drilling.log.value_limits import mask_impossible_values
from slider_drilling.messages.topics import CLOCK_TOPICS, TOPICS
from slider_drilling.table_import.findings import Findings
from slider_drilling.table_import.mapping import IMPORT_CHANNELS, TableMapping
from slider_drilling.table_import.row_times import RowTimes, start_ns


def build_log(
    values: Mapping[str, Array],
    times: RowTimes,
    mapping: TableMapping,
    found: Findings,
    source: str,
    rig: tuple[str | None, str | os.PathLike[str] | None] = (None, None),
) -> RigLog:
    """The log with all channels, values that no rig has masked.

    Args:
        values: Each channel in SI units, (n,).
        times: Of the rows.
        mapping: Of the table.
        found: What was found and done so far.
        source: The table's file.
        rig: Text and path of the rig file to attach.

    Raises:
        InputError: Nothing is left, or a stamp cannot hold the times.
    """
    built = {key: _series(key, values, times, mapping) for key in TOPICS}
    _note_nulls(values, times, found)
    filled = {key: series for key, series in built.items() if series is not None}
    if not filled:
        raise InputError(f"{source}: all mapped columns are empty or null")
    origin = float(filled[next(key for key in CLOCK_TOPICS if key in filled)].time[0])
    series = {key: replace(s, time=s.time - origin, arrival=s.arrival - origin) for key, s in filled.items()}
    last = times.epoch_ns * 1e-9 + origin + max(float(s.arrival[-1]) for s in series.values())
    rig_text, rig_path = rig
    log = RigLog(
        source=source,
        start_ns=start_ns(mapping, times, origin, last),
        rig_text=rig_text,
        rig_source=None if rig_path is None else str(rig_path),
        metadata={},
        notes=tuple(found.notes),
        imported=ImportRecord(
            tuple(found.checks), found.integrated, {name: mapping.channels[name].unit for name in values}
        ),
        **series,  # type: ignore[arg-type]
    )
    return mask_impossible_values(log)


def _channels_of(key: str, values: Mapping[str, Array]) -> list[str]:
    return [name for name in values if IMPORT_CHANNELS[name].series == key]


def _series(key: str, values: Mapping[str, Array], times: RowTimes, mapping: TableMapping) -> Series | None:
    """One series from its channels, without rows where all of them are null; None where nothing is left."""
    own = _channels_of(key, values)
    if not own:
        return None
    some = times.kept & ~np.all([np.isnan(values[name]) for name in own], axis=0)
    for name in own:
        if mapping.channels[name].on_change:
            some &= _changes(values[name])
    if not some.any():
        return None
    arrival = times.seconds[some]
    measured = arrival - max(mapping.channels[name].delay for name in own)
    arrays = {IMPORT_CHANNELS[name].array: values[name][some] for name in own}
    return build_series(TOPICS[key], measured, arrival, arrays)


def _note_nulls(values: Mapping[str, Array], times: RowTimes, found: Findings) -> None:
    """Tell how many rows of which channels are null; channels with as many share a sentence."""
    channels: dict[int, list[str]] = {}
    for key in TOPICS:
        for name in _channels_of(key, values):
            missing = int(np.count_nonzero(times.kept & np.isnan(values[name])))
            if missing:
                channels.setdefault(missing, []).append(name)
    for count, names in channels.items():
        found.notes.append(f"{', '.join(names)}: {count} of {np.count_nonzero(times.kept)} rows are null")


def _changes(column: Array) -> NDArray[np.bool_]:
    """Where a value is given and differs from the last given one."""
    given = np.flatnonzero(~np.isnan(column))
    changed = np.zeros(column.shape, dtype=np.bool_)
    changed[given] = np.append(True, np.diff(column[given]) != 0.0)[: given.size]
    return changed
