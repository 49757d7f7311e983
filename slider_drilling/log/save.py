"""Writing a log in memory to an MCAP file."""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np

from slider_drilling.log.import_record import RECORD
from slider_drilling.log.series import Array, LogContents
from slider_drilling.log.write import LogWriter
from slider_drilling.messages.decoder import Integers
from slider_drilling.messages.topics import TOPICS


def save_log(
    log: LogContents,
    path: str | os.PathLike[str],
    recorded_by: str,
    notes: str = "",
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write a log with its rig file and programme, messages in the order in which they arrived.

    Args:
        log: What to write.
        path: The MCAP file; it replaces whatever has that name.
        recorded_by: What made the log, for its metadata.
        notes: Free text for its metadata.
        progress: Called with the number of messages written so far and of all.

    Raises:
        InputError: The file cannot be written.
    """
    parts = [
        (
            TOPICS[key],
            _nanoseconds(log, series.time),
            np.column_stack([getattr(series, logged.array) for logged in TOPICS[key].message_type().logged]),
            _nanoseconds(log, series.arrival),
        )
        for key, series in log.series().items()
    ]
    with LogWriter(path, log.rig_text, recorded_by, notes, whole=True) as writer:
        if log.programme_text is not None:
            writer.attach_programme(log.programme_text)
        if log.imported is not None:
            writer.add_metadata(RECORD, log.imported.to_metadata())
        writer.samples(parts, progress)


def _nanoseconds(log: LogContents, time: Array) -> Integers:
    """Times of a log, s since its start, as ns since the epoch."""
    return log.start_ns + np.round(time * 1e9).astype(np.int64)
