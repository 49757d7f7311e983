"""Writing a log in memory to an MCAP file."""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np

from slider_drilling.log.import_record import RECORD
from slider_drilling.log.series import LogContents
from slider_drilling.log.write import LogWriter
from slider_drilling.messages.topics import TOPICS


def save_log(
    log: LogContents,
    path: str | os.PathLike[str],
    recorded_by: str,
    notes: str = "",
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write a log with its rig file, messages in the order in which they arrived.

    Args:
        log: What to write.
        path: The MCAP file; it replaces whatever has that name.
        recorded_by: What made the log, for its metadata.
        notes: Free text for its metadata.
        progress: Called with the number of messages written so far and of all.

    Raises:
        InputError: The file cannot be written.
    """
    held = log.series()
    entries = sorted(
        (float(arrival), key, index) for key, series in held.items() for index, arrival in enumerate(series.arrival)
    )
    numbers = {
        key: np.column_stack([getattr(series, logged.array) for logged in TOPICS[key].message_type().logged])
        for key, series in held.items()
    }
    with LogWriter(path, log.rig_text, recorded_by, notes, whole=True) as writer:
        if log.imported is not None:
            writer.add_metadata(RECORD, log.imported.to_metadata())
        for count, (arrival, key, index) in enumerate(entries):
            stamp = log.start + float(held[key].time[index])
            writer.sample(TOPICS[key], stamp, numbers[key][index].tolist(), log.start + arrival)
            if progress is not None and count % 1000 == 0:
                progress(count, len(entries))
