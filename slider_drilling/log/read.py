"""From MCAP files to a RigLog, whoever recorded them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml

from slider_drilling.console.printable import printable
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.log.mcap_chunk import MessageBlock
from slider_drilling.log.mcap_reader import McapReader
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import build_series
from slider_drilling.log.timestamps import MAX_CLOCK_OFFSET, SECOND, StampedSamples, drop_foreign_stamps, sort_by_stamp
from slider_drilling.log.value_limits import mask_impossible_values
from slider_drilling.messages.decoder import Array, Integers, TopicDecoder
from slider_drilling.messages.topics import CLOCK_TOPICS, TOPICS, canonical_type, namespace_of

# Samples of a rig's channels that are read, about: at 10 Hz a week, in a bit more than 1 GB.
MAX_SAMPLES = 25_000_000


@dataclass
class TopicSamples:
    """Samples of one topic as they were read, and what reads them; ends: how many there are after each file."""

    key: str
    topic: str
    decoder: TopicDecoder
    parts: list[StampedSamples] = field(default_factory=list)
    count: int = 0
    ends: dict[Path, int] = field(default_factory=dict)

    def add(self, block: MessageBlock, file: Path) -> None:
        """Read the messages of this topic alone."""
        readable, stamp, values = self.decoder.decode(block.data, block.start, block.end)
        self.parts.append(StampedSamples(stamp, block.log_time[readable].astype(np.int64), values))
        self.count += len(stamp)
        self.ends[file] = self.count

    def track(self) -> StampedSamples:
        """All of them, in the order of the files."""
        parts = self.parts
        return StampedSamples(
            np.concatenate([part.stamp for part in parts]),
            np.concatenate([part.logged for part in parts]),
            np.concatenate([part.values for part in parts]),
        )


def read_log(
    path: str | os.PathLike[str], rig_path: str | os.PathLike[str] | None = None, namespace: str | None = None
) -> RigLog:
    """Read a log: an MCAP file, or the folder of them that `ros2 bag record` leaves.

    rig_path: a rig file that takes the place of the log's own; namespace: whose topics to read where a log holds
    several rigs'. Truncated and damaged files are read as far as they go; RigLog.notes says so. Raises InputError
    for a file that is missing, no MCAP file, or without any topic of a rig, and for two runs in one log.
    """
    source = printable(str(path))
    try:
        return _read(Path(path), source, rig_path, namespace)
    except InputError as error:
        # Topics and types of any log may be in it.
        raise InputError(printable(str(error))) from None


def _read(path: Path, source: str, rig_path: str | os.PathLike[str] | None, namespace: str | None) -> RigLog:
    containers = [McapReader(file) for file in log_files(path)]
    sampled: dict[str, TopicSamples] = {}
    ignored: dict[str, str] = {}
    for container in containers:
        _collect(container, sampled, ignored)
    notes = [f"{container.path.name}: {note}" for container in containers for note in container.notes]
    notes += [f"{topic}: ignored, {why}" for topic, why in sorted(ignored.items())]
    chosen = _choose([samples for samples in sampled.values() if samples.count], namespace, source)
    for samples in sampled.values():
        notes += [f"{samples.topic}: {n} unreadable messages: {why}" for why, n in samples.decoder.unreadable.items()]
    if not chosen:
        raise InputError(_nothing(source, containers, notes, namespace))
    moved = any(container.chunks_out_of_order for container in containers)
    tracks = {}
    for key, samples in chosen.items():
        track = samples.track()
        if TOPICS[key].is_surface:
            _check_one_run(samples, track, source)
        tracks[key] = sort_by_stamp(track, samples.topic, TOPICS[key].is_surface, moved, source, notes)
    _leave_out_far(tracks, chosen, notes)
    rig_text, rig_source = _rig(source, rig_path, containers, notes)
    return mask_impossible_values(_assemble(source, tracks, notes, rig_text, rig_source, _metadata(containers)))


def _leave_out_far(tracks: dict[str, StampedSamples], chosen: dict[str, TopicSamples], notes: list[str]) -> None:
    """Keep of every series what was stamped within the time of the log's clock."""
    clock = next(key for key in CLOCK_TOPICS if key in tracks)
    for key in [key for key in tracks if key != clock]:
        kept = drop_foreign_stamps(tracks[key], tracks[clock], chosen[key].topic, TOPICS[key].is_surface, notes)
        if kept is None:
            del tracks[key]
        else:
            tracks[key] = kept


def log_files(path: Path) -> list[Path]:
    """The files of a log: itself, or those that a bag's folder lists, or all MCAP files in a folder."""
    if not path.is_dir():
        return [path]
    listed = _listed(path / "metadata.yaml")
    files = [file for file in listed if file.is_file()] or sorted(
        path.glob("*.mcap"), key=lambda file: (len(file.name), file.name)
    )
    if not files:
        raise InputError(f"{path}: a folder without .mcap files; give a log, or the folder of an MCAP bag")
    return files


def _listed(metadata: Path) -> list[Path]:
    """The files that a bag's metadata.yaml lists; none where there is no such file, or it says something else."""
    try:
        found = yaml.safe_load(metadata.read_text(encoding="utf-8"))
        names = found["rosbag2_bagfile_information"]["relative_file_paths"]
        return [metadata.parent / Path(str(name)).name for name in names if str(name).endswith(".mcap")]
    except (OSError, UnicodeDecodeError, yaml.YAMLError, TypeError, KeyError, RecursionError):
        return []


def _collect(container: McapReader, sampled: dict[str, TopicSamples], ignored: dict[str, str]) -> None:
    """Sort the container's messages by topic, decoding those of a rig. Raises InputError for more than can be held."""
    by_channel: dict[int, TopicSamples | None] = {}
    for block in container.blocks():
        for number in np.unique(block.channel).tolist():
            if number not in by_channel:
                by_channel[number] = _samples_of(container, number, sampled, ignored)
            samples = by_channel[number]
            if samples is not None:
                samples.add(block.select(block.channel == number), container.path)
        if sum(samples.count for samples in sampled.values()) > MAX_SAMPLES:
            raise InputError(
                f"{container.path}: holds more than {MAX_SAMPLES:,} samples of a rig's channels, which is more than "
                "is read at once; split it with another tool, such as `mcap filter`"
            )


def _samples_of(
    container: McapReader, number: int, sampled: dict[str, TopicSamples], ignored: dict[str, str]
) -> TopicSamples | None:
    """Where the messages of a channel go; None for nowhere."""
    channel = container.channels[number]
    schema = container.schemas.get(channel.schema_id)
    matched = _match(channel.topic, schema.name if schema is not None else None)
    if isinstance(matched, TopicSamples) and channel.message_encoding != "cdr":
        matched = f"its messages are encoded as {channel.message_encoding!r}, not cdr"
    if isinstance(matched, str):
        ignored[channel.topic] = matched
        return None
    return sampled.setdefault(channel.topic, matched) if matched is not None else None


def series_of_topic(topic: str, type_name: str | None) -> str:
    """The series that a topic is; empty where it is none, or its type is another one."""
    matched = _match(topic, type_name)
    return matched.key if isinstance(matched, TopicSamples) else ""


def _match(topic: str, type_name: str | None) -> TopicSamples | str | None:
    """Where samples of the topic go; why not, if it looks like a rig's and is not; None for any other topic."""
    for key, known in TOPICS.items():
        if namespace_of(topic, known.name) is None:
            continue
        if type_name is not None and canonical_type(type_name) != known.type:
            return f"its type is {type_name}, not {known.type}"
        return TopicSamples(key, topic, TopicDecoder(known))
    return None


def _choose(found: Iterable[TopicSamples], namespace: str | None, source: str) -> dict[str, TopicSamples]:
    """One topic a series. Raises InputError where two rigs' topics could be meant."""
    chosen: dict[str, TopicSamples] = {}
    wanted = None if namespace is None else f"/{namespace.strip('/')}".rstrip("/")
    for samples in found:
        own = namespace_of(samples.topic, TOPICS[samples.key].name)
        if wanted is not None and own != wanted:
            continue
        if samples.key in chosen:
            raise InputError(
                f"{source}: topics {chosen[samples.key].topic} and {samples.topic} are both there; "
                "say with --namespace which to read"
            )
        chosen[samples.key] = samples
    return chosen


def _check_one_run(samples: TopicSamples, track: StampedSamples, source: str) -> None:
    """Raises InputError where the files of a folder overlap in time: they are several runs, not one in parts."""
    before, last, first = "", 0, 0
    for path, end in samples.ends.items():
        stamps = track.stamp[first:end]
        if not len(stamps):
            continue
        # Single stamps may be wrong: the bulk of them tells.
        low, high = np.quantile(stamps, (0.02, 0.98), method="nearest").tolist()
        if before and low < last:
            raise InputError(
                f"{source}: {before} and {path.name} overlap in time, so they are two runs; give one of them"
            )
        before, last, first = path.name, high, end


def _nothing(source: str, containers: list[McapReader], notes: list[str], namespace: str | None) -> str:
    topics = sorted({channel.topic for container in containers for channel in container.channels.values()})
    there = f"topics there: {', '.join(topics)}" if topics else "it holds no topics"
    where = "" if namespace is None else f" in namespace {namespace!r}"
    why = "".join(f"; {note}" for note in notes)
    return f"{source}: no message of a rig's topics{where} (top_drive/joint_states and so on); {there}{why}"


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
    """Series in seconds since the first sample of the top drive, or of the first channel there is."""
    clock = tracks[next(key for key in CLOCK_TOPICS if key in tracks)]
    start = clock.stamp[0]
    offset = float(np.median(clock.logged.astype(np.float64) - clock.stamp))
    other_clock = abs(offset) > MAX_CLOCK_OFFSET
    if other_clock:
        notes.append(f"log times are {offset / SECOND:.1f} s off the stamps; arrivals are given in the stamps' clock")

    def arrival(track: StampedSamples) -> Array:
        if not other_clock:
            return _seconds(track.logged - start)
        # Whatever the two clocks' rates, a message arrived when the surface channel logged beside it was stamped.
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
    source: str, rig_path: str | os.PathLike[str] | None, containers: list[McapReader], notes: list[str]
) -> tuple[str | None, str | None]:
    """Text and origin of the rig file: the one given, or the first attachment that is one."""
    if rig_path is not None:
        return read_text(rig_path, "rig file"), str(rig_path)
    for container in containers:
        for attachment in container.attachments:
            if Path(attachment.name).name == "rig.yaml":
                try:
                    return attachment.data.decode("utf-8"), f"{container.path}: {attachment.name}"
                except UnicodeDecodeError:
                    notes.append(f"{source}: attachment {attachment.name} is not text and was ignored")
    return None, None


def _metadata(containers: list[McapReader]) -> dict[str, str]:
    """The `slider_drilling` metadata record of the first file that has one."""
    records = [record for container in containers for record in container.metadata]
    return next((dict(record.metadata) for record in records if record.name == "slider_drilling"), {})
