"""Reads the log of any recorder into a RigLog."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.files.paths import as_path
from slider_drilling.log.find_nulls import mask_shared_nulls
from slider_drilling.log.import_record import RECORD, ImportRecord
from slider_drilling.log.interleaved import keep_one_of_interleaved
from slider_drilling.log.log_files import find_log_files, open_readers
from slider_drilling.log.log_reader import LogReader
from slider_drilling.log.publishers import keep_one_publisher, split_signals
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import build_series
from slider_drilling.log.timestamps import MAX_CLOCK_OFFSET, SECOND, StampedSamples, drop_foreign_stamps, sort_by_stamp
from slider_drilling.log.topic_map import NO_TOPICS, TopicMap, read_topic_map
from slider_drilling.log.topic_samples import SampleCollector, TopicSamples
from slider_drilling.log.value_limits import mask_impossible_values
from slider_drilling.log.write import PROGRAMME
from slider_drilling.messages.decoder import Array, Integers
from slider_drilling.messages.topics import CLOCK_TOPICS, TOPICS


def read_log(
    path: str | os.PathLike[str],
    rig_path: str | os.PathLike[str] | None = None,
    namespace: str | None = None,
    topics: str | os.PathLike[str] | None = None,
) -> RigLog:
    """Read a log: an MCAP or sqlite3 file, a bag of ROS 1, or the folder of a bag that `ros2 bag record` writes.

    Truncated and damaged files are read as far as possible; `RigLog.notes` lists what is lost.

    Args:
        path: The file or folder; compressed or not.
        rig_path: A rig file that replaces the log's own.
        namespace: The rig whose topics to read, where a log holds several.
        topics: A topics file, which says which topic and joint is which series, where the log has other names.

    Returns:
        The log in memory.

    Raises:
        InputError: The file is missing, is no log, has no topic of a rig, or holds two runs or two publishers.
    """
    given = as_path(path, "log")
    source = printable(str(given))
    try:
        return _read(given, source, rig_path, namespace, NO_TOPICS if topics is None else read_topic_map(topics))
    except InputError as error:
        # The message may hold names of topics and types of any log.
        raise InputError(printable(str(error))) from None


def _read(
    path: Path, source: str, rig_path: str | os.PathLike[str] | None, namespace: str | None, topics: TopicMap
) -> RigLog:
    found = find_log_files(path)
    readers = open_readers(found.files)
    collector = SampleCollector(topics)
    for reader in readers:
        collector.collect(reader)
    notes = [*found.notes, *(f"{reader.path.name}: {note}" for reader in readers for note in reader.notes)]
    notes += [f"{topic}: ignored, {why}" for topic, why in sorted(collector.ignored.items())]
    chosen = collector.choose(namespace, source)
    notes += collector.remarks(chosen)
    if not chosen:
        raise InputError(_nothing_found(source, readers, notes, namespace))
    moved = any(reader.chunks_out_of_order for reader in readers)
    tracks = {}
    for key, samples in chosen.items():
        track = _one_publisher(samples, source, notes)
        if track is not None:
            tracks[key] = sort_by_stamp(track, samples.match.topic, TOPICS[key].is_surface, moved, source, notes)
    if not tracks:
        raise InputError(_nothing_found(source, readers, notes, namespace))
    _drop_foreign_stamps(tracks, chosen, notes)
    rig_text, rig_source = _rig(source, rig_path, readers, notes)
    programme, _ = _attached_text(PROGRAMME, source, readers, notes)
    log = _assemble(source, tracks, notes, rig_text, rig_source, _metadata(readers, "slider_drilling"))
    unreadable = {key: printable(why) for key, why in collector.missing(chosen).items()}
    record = _metadata(readers, RECORD)
    imported = ImportRecord.from_metadata(record) if record else None
    # What is wrong with a rig file that is not used concerns nobody.
    replaced = None if rig_path is None else _attached_text("rig.yaml", source, readers, [])[0]
    log = replace(log, programme_text=programme, imported=imported, replaced_rig_text=replaced, unreadable=unreadable)
    return mask_impossible_values(mask_shared_nulls(log))


def _one_publisher(samples: TopicSamples, source: str, notes: list[str]) -> StampedSamples | None:
    """Samples of one run and one publisher; None for a setpoint whose publishers differ. Raises InputError."""
    topic, track = TOPICS[samples.match.key], samples.track()
    if topic.is_surface:
        _check_one_run(samples, track, source)
    try:
        if len(split_signals(track)) == 1:
            cells = topic.quantities
            continuous = [k for k, one in enumerate(cells) if one.array == "position" and not one.is_wrapped]
            track = keep_one_of_interleaved(track, continuous, samples.match.topic, source, notes)
        return keep_one_publisher(track, samples.match.topic, source, notes)
    except InputError as error:
        # Setpoints may come from several programs in turn, and no plant is driven by them.
        if topic.is_measured:
            raise
        notes.append(f"{str(error).removeprefix(source + ': ')}; left out")
        return None


def _drop_foreign_stamps(tracks: dict[str, StampedSamples], chosen: dict[str, TopicSamples], notes: list[str]) -> None:
    """Keep the samples of each series that are stamped within the time of the log's clock."""
    clock = next(key for key in CLOCK_TOPICS if key in tracks)
    for key in [key for key in tracks if key != clock]:
        kept = drop_foreign_stamps(tracks[key], tracks[clock], chosen[key].match.topic, TOPICS[key].is_surface, notes)
        if kept is None:
            del tracks[key]
        else:
            tracks[key] = kept


def _check_one_run(samples: TopicSamples, track: StampedSamples, source: str) -> None:
    """Raise InputError where the files of a folder overlap in time: they are several runs, not one in parts."""
    before, last, first = "", 0, 0
    for path, end in samples.ends.items():
        stamps = track.stamp[first:end]
        if not len(stamps):
            continue
        # Quantiles, since single stamps may be wrong.
        low, high = np.quantile(stamps, (0.02, 0.98), method="nearest").tolist()
        if before and low < last:
            raise InputError(
                f"{source}: {before} and {path.name} overlap in time, so they are two runs; give one of them"
            )
        before, last, first = path.name, high, end


def _nothing_found(source: str, readers: list[LogReader], notes: list[str], namespace: str | None) -> str:
    topics = sorted({channel.topic for reader in readers for channel in reader.channels.values()})
    held = f"it holds {', '.join(topics)}" if topics else "it holds no topics"
    where = "" if namespace is None else f" in namespace {namespace!r}"
    reasons = "".join(f"; {note}" for note in notes)
    return f"{source}: no message of a rig's topics{where} (top_drive/joint_states and so on); {held}{reasons}"


def _seconds(nanoseconds: Integers) -> Array:
    return np.multiply(nanoseconds, 1e-9, dtype=np.float64)


def _assemble(
    source: str,
    tracks: dict[str, StampedSamples],
    notes: list[str],
    rig_text: str | None,
    rig_source: str | None,
    metadata: dict[str, str],
) -> RigLog:
    """The log from the samples of its topics; t = 0 is the first sample of the first topic of CLOCK_TOPICS."""
    clock = tracks[next(key for key in CLOCK_TOPICS if key in tracks)]
    start = clock.stamp[0]
    offset = float(np.median(clock.logged.astype(np.float64) - clock.stamp))
    other_clock = abs(offset) > MAX_CLOCK_OFFSET
    if other_clock:
        shift = f"{offset / SECOND:.1f} s"
        notes.append(f"log times are {shift} off the stamps; arrivals are converted to the stamps' clock")

    def arrival(track: StampedSamples) -> Array:
        if not other_clock:
            return _seconds(track.logged - start)
        # The clocks may run at different rates: take the stamp of the clock topic at the same log time.
        order = np.argsort(clock.logged, kind="stable")
        logged, stamp = clock.logged[order], clock.stamp[order]
        return np.interp(_seconds(track.logged - logged[0]), _seconds(logged - logged[0]), _seconds(stamp - start))

    arrays = {key: np.ascontiguousarray(track.values.T) for key, track in tracks.items()}
    series = {
        key: build_series(
            TOPICS[key],
            _seconds(track.stamp - start),
            arrival(track),
            {logged.array: array for logged, array in zip(TOPICS[key].message_type().logged, arrays[key], strict=True)},
        )
        for key, track in tracks.items()
    }
    return RigLog(
        source=source,
        start_ns=int(start),
        rig_text=rig_text,
        rig_source=rig_source,
        metadata={key: printable(value) for key, value in metadata.items()},
        notes=tuple(printable(note) for note in notes),
        **series,  # type: ignore[arg-type]
    )


def _rig(
    source: str, rig_path: str | os.PathLike[str] | None, readers: list[LogReader], notes: list[str]
) -> tuple[str | None, str | None]:
    """Text and origin of the rig file: of the given one, else of the first such attachment."""
    if rig_path is not None:
        return read_text(rig_path, "rig file"), str(rig_path)
    return _attached_text("rig.yaml", source, readers, notes)


def _attached_text(
    name: str, source: str, readers: list[LogReader], notes: list[str]
) -> tuple[str | None, str | None]:
    """Text and origin of the first attachment of this name that is text."""
    for reader in readers:
        for attachment in reader.attachments:
            if Path(attachment.name).name == name:
                try:
                    return attachment.data.decode("utf-8"), f"{reader.path}: {attachment.name}"
                except UnicodeDecodeError:
                    notes.append(f"{source}: attachment {attachment.name} is no text and was ignored")
    return None, None


def _metadata(readers: list[LogReader], name: str) -> dict[str, str]:
    """The first metadata record of that name; empty where there is none."""
    records = [record for reader in readers for record in reader.metadata]
    return next((dict(record.metadata) for record in records if record.name == name), {})
