"""Reads MCAP files of any recorder into a RigLog."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import yaml

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.log.import_record import RECORD, ImportRecord
from slider_drilling.log.mcap_chunk import MessageBlock
from slider_drilling.log.mcap_reader import McapReader
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import build_series
from slider_drilling.log.timestamps import MAX_CLOCK_OFFSET, SECOND, StampedSamples, drop_foreign_stamps, sort_by_stamp
from slider_drilling.log.value_limits import mask_impossible_values
from slider_drilling.messages.decoder import Array, Integers, TopicDecoder
from slider_drilling.messages.topics import CLOCK_TOPICS, TOPICS, canonical_type, namespace_of

# Approximate limit of samples: a week at 10 Hz, in a bit more than 1 GB of memory.
MAX_SAMPLES = 25_000_000


@dataclass
class TopicSamples:
    """Samples of one topic as they are read.

    Attributes:
        key: Its key in the registry of topics.
        topic: Its name in the log.
        decoder: Reads its messages.
        parts: The samples, block by block.
        count: Number of samples so far.
        ends: Number of samples after each file.
    """

    key: str
    topic: str
    decoder: TopicDecoder
    parts: list[StampedSamples] = field(default_factory=list)
    count: int = 0
    ends: dict[Path, int] = field(default_factory=dict)

    def add(self, block: MessageBlock, file: Path) -> None:
        """Read a block of messages of this topic."""
        readable, stamp, values = self.decoder.decode(block.data, block.start, block.end)
        self.parts.append(StampedSamples(stamp, block.log_time[readable].astype(np.int64), values))
        self.count += len(stamp)
        self.ends[file] = self.count

    def track(self) -> StampedSamples:
        """All samples, in the order of the files."""
        parts = self.parts
        return StampedSamples(
            np.concatenate([part.stamp for part in parts]),
            np.concatenate([part.logged for part in parts]),
            np.concatenate([part.values for part in parts]),
        )


def read_log(
    path: str | os.PathLike[str], rig_path: str | os.PathLike[str] | None = None, namespace: str | None = None
) -> RigLog:
    """Read a log: an MCAP file, or the folder of a bag that `ros2 bag record` writes.

    Truncated and damaged files are read as far as possible; `RigLog.notes` tells what is lost.

    Args:
        path: The file or folder.
        rig_path: A rig file that replaces the log's own.
        namespace: The rig whose topics to read, where a log holds several.

    Returns:
        The log in memory.

    Raises:
        InputError: The file is missing, is no MCAP file, has no topic of a rig, or holds two runs.
    """
    source = printable(str(path))
    try:
        return _read(Path(path), source, rig_path, namespace)
    except InputError as error:
        # The message may hold names of topics and types of any log.
        raise InputError(printable(str(error))) from None


def _read(path: Path, source: str, rig_path: str | os.PathLike[str] | None, namespace: str | None) -> RigLog:
    readers = [McapReader(file) for file in log_files(path)]
    sampled: dict[str, TopicSamples] = {}
    ignored: dict[str, str] = {}
    for reader in readers:
        _collect(reader, sampled, ignored)
    notes = [f"{reader.path.name}: {note}" for reader in readers for note in reader.notes]
    notes += [f"{topic}: ignored, {why}" for topic, why in sorted(ignored.items())]
    chosen = _choose([samples for samples in sampled.values() if samples.count], namespace, source)
    for samples in sampled.values():
        notes += [f"{samples.topic}: {n} unreadable messages: {why}" for why, n in samples.decoder.unreadable.items()]
    if not chosen:
        raise InputError(_nothing_found(source, readers, notes, namespace))
    moved = any(reader.chunks_out_of_order for reader in readers)
    tracks = {}
    for key, samples in chosen.items():
        track = samples.track()
        if TOPICS[key].is_surface:
            _check_one_run(samples, track, source)
        tracks[key] = sort_by_stamp(track, samples.topic, TOPICS[key].is_surface, moved, source, notes)
    _drop_foreign_stamps(tracks, chosen, notes)
    rig_text, rig_source = _rig(source, rig_path, readers, notes)
    log = _assemble(source, tracks, notes, rig_text, rig_source, _metadata(readers, "slider_drilling"))
    record = _metadata(readers, RECORD)
    return mask_impossible_values(replace(log, imported=ImportRecord.from_metadata(record) if record else None))


def _drop_foreign_stamps(tracks: dict[str, StampedSamples], chosen: dict[str, TopicSamples], notes: list[str]) -> None:
    """Keep the samples of each series that are stamped within the time of the log's clock."""
    clock = next(key for key in CLOCK_TOPICS if key in tracks)
    for key in [key for key in tracks if key != clock]:
        kept = drop_foreign_stamps(tracks[key], tracks[clock], chosen[key].topic, TOPICS[key].is_surface, notes)
        if kept is None:
            del tracks[key]
        else:
            tracks[key] = kept


def log_files(path: Path) -> list[Path]:
    """The files of a log: itself, those that a bag lists, or all MCAP files in a folder. Raises InputError for none."""
    if not path.is_dir():
        return [path]
    listed = _listed(path / "metadata.yaml")
    files = [file for file in listed if file.is_file()] or sorted(
        path.glob("*.mcap"), key=lambda file: (len(file.name), file.name)
    )
    if not files:
        raise InputError(f"{path}: holds no .mcap files; give a log, or the folder of an MCAP bag")
    return files


def _listed(metadata: Path) -> list[Path]:
    """The files that a bag's metadata.yaml lists; none where it is missing or invalid."""
    try:
        content = yaml.safe_load(metadata.read_text(encoding="utf-8"))
        names = content["rosbag2_bagfile_information"]["relative_file_paths"]
        return [metadata.parent / Path(str(name)).name for name in names if str(name).endswith(".mcap")]
    except (OSError, UnicodeDecodeError, yaml.YAMLError, TypeError, KeyError, RecursionError):
        return []


def _collect(reader: McapReader, sampled: dict[str, TopicSamples], ignored: dict[str, str]) -> None:
    """Decode the messages of a rig's topics. Raises InputError for more than MAX_SAMPLES."""
    by_channel: dict[int, TopicSamples | None] = {}
    for block in reader.blocks():
        for number in np.unique(block.channel).tolist():
            if number not in by_channel:
                by_channel[number] = _samples_of(reader, number, sampled, ignored)
            samples = by_channel[number]
            if samples is not None:
                samples.add(block.select(block.channel == number), reader.path)
        if sum(samples.count for samples in sampled.values()) > MAX_SAMPLES:
            raise InputError(
                f"{reader.path}: holds more than {MAX_SAMPLES:,} samples of a rig's channels; "
                "split it with another tool, such as `mcap filter`"
            )


def _samples_of(
    reader: McapReader, number: int, sampled: dict[str, TopicSamples], ignored: dict[str, str]
) -> TopicSamples | None:
    """The samples that a channel's messages belong to; None where it is not read."""
    channel = reader.channels[number]
    schema = reader.schemas.get(channel.schema_id)
    matched = _match(channel.topic, schema.name if schema is not None else None)
    if isinstance(matched, TopicSamples) and channel.message_encoding != "cdr":
        matched = f"its messages are encoded as {channel.message_encoding!r}, not cdr"
    if isinstance(matched, str):
        ignored[channel.topic] = matched
        return None
    return sampled.setdefault(channel.topic, matched) if matched is not None else None


def series_of_topic(topic: str, type_name: str | None) -> str:
    """Key of the registered topic that a topic of a log is; empty where there is none, or its type differs.

    Args:
        topic: Name in the log, with any namespace.
        type_name: Its message type in any spelling; None where the log does not say.
    """
    matched = _match(topic, type_name)
    return matched.key if isinstance(matched, TopicSamples) else ""


def _match(topic: str, type_name: str | None) -> TopicSamples | str | None:
    """New samples for a registered topic; the reason where only its name fits; None for any other topic."""
    for key, known in TOPICS.items():
        if namespace_of(topic, known.name) is None:
            continue
        if type_name is not None and canonical_type(type_name) != known.type:
            return f"its type is {type_name}, not {known.type}"
        return TopicSamples(key, topic, TopicDecoder(known))
    return None


def _choose(candidates: Iterable[TopicSamples], namespace: str | None, source: str) -> dict[str, TopicSamples]:
    """One topic for each series. Raises InputError where topics of two rigs fit."""
    chosen: dict[str, TopicSamples] = {}
    wanted = None if namespace is None else f"/{namespace.strip('/')}".rstrip("/")
    for samples in candidates:
        own = namespace_of(samples.topic, TOPICS[samples.key].name)
        if wanted is not None and own != wanted:
            continue
        if samples.key in chosen:
            raise InputError(
                f"{source}: holds both {chosen[samples.key].topic} and {samples.topic}; "
                "choose one with --namespace"
            )
        chosen[samples.key] = samples
    return chosen


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


def _nothing_found(source: str, readers: list[McapReader], notes: list[str], namespace: str | None) -> str:
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
    source: str, rig_path: str | os.PathLike[str] | None, readers: list[McapReader], notes: list[str]
) -> tuple[str | None, str | None]:
    """Text and origin of the rig file: of the given one, else of the first such attachment."""
    if rig_path is not None:
        return read_text(rig_path, "rig file"), str(rig_path)
    for reader in readers:
        for attachment in reader.attachments:
            if Path(attachment.name).name == "rig.yaml":
                try:
                    return attachment.data.decode("utf-8"), f"{reader.path}: {attachment.name}"
                except UnicodeDecodeError:
                    notes.append(f"{source}: attachment {attachment.name} is no text and was ignored")
    return None, None


def _metadata(readers: list[McapReader], name: str) -> dict[str, str]:
    """The first metadata record of that name; empty where there is none."""
    records = [record for reader in readers for record in reader.metadata]
    return next((dict(record.metadata) for record in records if record.name == name), {})
