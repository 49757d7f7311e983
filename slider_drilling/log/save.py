"""A RigLog back into an MCAP file."""

from __future__ import annotations

import math
import os
from collections.abc import Callable

from slider_drilling.log.series import JointSeries, RigLog, ScalarSeries
from slider_drilling.log.write import LogWriter
from slider_drilling.messages.topics import FLUID_PRESSURE, TOPICS

# When, which series, which sample of it.
Entry = tuple[float, str, int]


def save_log(
    log: RigLog,
    path: str | os.PathLike[str],
    recorded_by: str,
    notes: str = "",
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Write a log with its rig file, messages in the order in which they arrived.

    progress is told how many messages are written, of how many. Raises InputError where the file cannot be written.
    """
    there = {key: getattr(log, key) for key in TOPICS if getattr(log, key) is not None}
    entries = sorted(
        (float(arrival), key, index) for key, series in there.items() for index, arrival in enumerate(series.arrival)
    )
    with LogWriter(path, log.rig_text, recorded_by, notes, whole=True) as writer:
        for count, (arrival, key, index) in enumerate(entries):
            _write(writer, log.start, key, there[key], index, arrival)
            if progress is not None and count % 1000 == 0:
                progress(count, len(entries))


def _given(value: float) -> float | None:
    return None if math.isnan(value) else value


def _write(
    writer: LogWriter, start: float, key: str, series: JointSeries | ScalarSeries, index: int, arrival: float
) -> None:
    topic = TOPICS[key]
    stamp, logged = start + float(series.time[index]), start + arrival
    if isinstance(series, JointSeries):
        arrays = (series.position, series.velocity, series.effort)
        position, velocity, effort = (_given(float(array[index])) for array in arrays)
        writer.joint_state(topic.name, stamp, topic.joint, position, velocity, effort, logged)
    elif topic.type == FLUID_PRESSURE:
        writer.fluid_pressure(
            topic.name, stamp, float(series.value[index]), float(series.variance[index]), log_time_s=logged
        )
    else:
        writer.wrench(topic.name, stamp, (float(series.value[index]), 0.0, 0.0), log_time_s=logged)
