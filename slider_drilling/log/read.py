"""From MCAP files to a RigLog, whoever recorded them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.files import read_text
from slider_drilling.log.container import Container
from slider_drilling.log.decode import Row, row_decoder
from slider_drilling.log.series import Array, JointSeries, RigLog, ScalarSeries
from slider_drilling.messages.topics import CLOCKS, JOINT_STATE, SURFACE, TOPICS, canonical_type, namespace_of

# A log whose clock differs from its stamps' by more was recorded on another clock (wall against simulated time).
OTHER_CLOCK = 10.0
# A surface channel whose stamps step back by more holds two runs.
STEP_BACK = 1.0

Integers = NDArray[np.int64]


@dataclass
class Samples:
    """Rows of one topic as they were read, and the decoder that reads them; ends: how many after each file."""

    key: str
    topic: str
    decode: Callable[[bytes], Row]
    rows: list[Row] = field(default_factory=list)
    logged: list[int] = field(default_factory=list)
    ends: dict[Path, int] = field(default_factory=dict)
    unreadable: Counter[str] = field(default_factory=Counter)

    def add(self, data: bytes, log_time: int) -> None:
        try:
            row = self.decode(data)
        except InputError as error:
            self.unreadable[str(error)] += 1
            return
        self.rows.append(row)
        self.logged.append(log_time)


@dataclass(frozen=True)
class Track:
    """One series in the stamps' clock: stamps and log times, ns, stamps strictly increasing; values, shape (n, 3)."""

    stamp: Integers
    logged: Integers
    values: Array


def read_log(
    path: str | os.PathLike[str], rig_path: str | os.PathLike[str] | None = None, namespace: str | None = None
) -> RigLog:
    """Read a log: an MCAP file, or the folder of them that `ros2 bag record` leaves.

    rig_path: a rig file that takes the place of the log's own; namespace: whose topics to read where a log holds
    several rigs'. Truncated and damaged files are read as far as they go; RigLog.notes says so. Raises InputError
    for a file that is missing, no MCAP file, or without any topic of a rig, and for two runs in one log.
    """
    source = str(path)
    containers = [Container(file) for file in _files(Path(path))]
    sampled: dict[str, Samples] = {}
    ignored: dict[str, str] = {}
    for container in containers:
        _collect(container, sampled, ignored)
    notes = [f"{container.path.name}: {note}" for container in containers for note in container.notes]
    notes += [f"{topic}: ignored, {why}" for topic, why in sorted(ignored.items())]
    chosen = _choose([samples for samples in sampled.values() if samples.rows], namespace, source)
    for samples in sampled.values():
        notes += [f"{samples.topic}: {n} unreadable messages: {why}" for why, n in samples.unreadable.items()]
    if not chosen:
        raise InputError(_nothing(source, containers, notes, namespace))
    for key in SURFACE:
        if key in chosen:
            _check_one_run(chosen[key], source)
    tracks = {key: _track(samples, source, notes) for key, samples in chosen.items()}
    rig_text, rig_source = _rig(source, rig_path, containers, notes)
    return _assemble(source, tracks, notes, rig_text, rig_source, _metadata(containers))


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    files = sorted(path.glob("*.mcap"), key=lambda file: (len(file.name), file.name))
    if not files:
        raise InputError(f"{path}: a folder without .mcap files; give a log, or the folder of an MCAP bag")
    return files


def _collect(container: Container, sampled: dict[str, Samples], ignored: dict[str, str]) -> None:
    """Sort the container's messages by topic, decoding those of a rig."""
    by_channel: dict[int, Samples | None] = {}
    for channel, message in container.messages():
        if channel.id not in by_channel:
            schema = container.schemas.get(channel.schema_id)
            matched = _match(channel.topic, schema.name if schema is not None else None)
            if isinstance(matched, Samples) and channel.message_encoding != "cdr":
                matched = f"its messages are encoded as {channel.message_encoding!r}, not cdr"
            if isinstance(matched, str):
                ignored[channel.topic] = matched
                matched = None
            by_channel[channel.id] = sampled.setdefault(channel.topic, matched) if matched is not None else None
        samples = by_channel[channel.id]
        if samples is not None:
            samples.add(message.data, message.log_time)
            samples.ends[container.path] = len(samples.rows)


def _match(topic: str, type_name: str | None) -> Samples | str | None:
    """Where samples of the topic go; why not, if it looks like a rig's and is not; None for any other topic."""
    for key, known in TOPICS.items():
        if namespace_of(topic, known.name) is None:
            continue
        if type_name is not None and canonical_type(type_name) != known.type:
            return f"its type is {type_name}, not {known.type}"
        return Samples(key, topic, row_decoder(known))
    return None


def _choose(found: Iterable[Samples], namespace: str | None, source: str) -> dict[str, Samples]:
    """One topic a series. Raises InputError where two rigs' topics could be meant."""
    chosen: dict[str, Samples] = {}
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


def _check_one_run(samples: Samples, source: str) -> None:
    """Raises InputError where the files of a folder overlap in time: they are several runs, not one in parts."""
    before, last, first_row = "", 0, 0
    for path, end in samples.ends.items():
        stamps = [row[0] for row in samples.rows[first_row:end]]
        if before and stamps and min(stamps) < last:
            raise InputError(
                f"{source}: {before} and {path.name} overlap in time, so they are two runs; give one of them"
            )
        before, last, first_row = path.name, max(stamps, default=last), end


def _nothing(source: str, containers: list[Container], notes: list[str], namespace: str | None) -> str:
    topics = sorted({channel.topic for container in containers for channel in container.channels.values()})
    there = f"topics there: {', '.join(topics)}" if topics else "it holds no topics"
    where = "" if namespace is None else f" in namespace {namespace!r}"
    why = "".join(f"; {note}" for note in notes)
    return f"{source}: no message of a rig's topics{where} (top_drive/joint_states and so on); {there}{why}"


def _track(samples: Samples, source: str, notes: list[str]) -> Track:
    """Rows in the order of their stamps, one a stamp."""
    stamp = np.array([row[0] for row in samples.rows], dtype=np.int64)
    logged = np.array(samples.logged, dtype=np.int64)
    values = np.array([row[1:] for row in samples.rows], dtype=np.float64)
    order = np.argsort(logged, kind="stable")
    stamp, logged, values = stamp[order], logged[order], values[order]
    if not stamp.any() and logged.any():
        notes.append(f"{samples.topic}: no stamps in its headers; log times taken instead")
        stamp = logged.copy()
    back = -np.diff(stamp, prepend=stamp[:1]) * 1e-9
    if samples.key in SURFACE and back.max() > STEP_BACK:
        at = (stamp[int(back.argmax()) - 1] - stamp[0]) * 1e-9
        raise InputError(
            f"{source}: {samples.topic}: stamps step back by {back.max():.1f} s after {at:.1f} s: "
            "two runs in one log; split it"
        )
    order = np.argsort(stamp, kind="stable")
    stamp, logged, values = stamp[order], logged[order], values[order]
    last = np.append(np.diff(stamp) > 0, True)
    if not last.all():
        notes.append(f"{samples.topic}: {np.count_nonzero(~last)} repeated stamps; the last message of each kept")
    return Track(stamp[last], logged[last], values[last])


def _seconds(nanoseconds: Integers) -> Array:
    return np.multiply(nanoseconds, 1e-9, dtype=np.float64)


def _assemble(
    source: str,
    tracks: dict[str, Track],
    notes: list[str],
    rig_text: str | None,
    rig_source: str | None,
    metadata: dict[str, str],
) -> RigLog:
    """Series in seconds since the first sample of the top drive, or of the first channel there is."""
    clock = tracks[next(key for key in CLOCKS if key in tracks)]
    start = clock.stamp[0]
    offset = float(np.median(clock.logged - clock.stamp)) * 1e-9
    other_clock = abs(offset) > OTHER_CLOCK
    if other_clock:
        notes.append(f"log times are {offset:.1f} s off the stamps; arrivals are given in the stamps' clock")

    def arrival(track: Track) -> Array:
        if not other_clock:
            return _seconds(track.logged - start)
        # Whatever the two clocks' rates, a message arrived when the surface channel logged beside it was stamped.
        order = np.argsort(clock.logged, kind="stable")
        logged, stamp = clock.logged[order], clock.stamp[order]
        return np.interp(_seconds(track.logged - logged[0]), _seconds(logged - logged[0]), _seconds(stamp - start))

    joints = {
        key: JointSeries(_seconds(track.stamp - start), arrival(track), *np.ascontiguousarray(track.values.T))
        for key, track in tracks.items()
        if TOPICS[key].type == JOINT_STATE
    }
    scalars = {
        key: ScalarSeries(_seconds(track.stamp - start), arrival(track), *np.ascontiguousarray(track.values.T[:2]))
        for key, track in tracks.items()
        if TOPICS[key].type != JOINT_STATE
    }
    return RigLog(
        source=source,
        start_ns=int(start),
        rig_text=rig_text,
        rig_source=rig_source,
        metadata=metadata,
        notes=tuple(notes),
        top_drive=joints.get("top_drive"),
        top_drive_command=joints.get("top_drive_command"),
        draw_works=joints.get("draw_works"),
        draw_works_command=joints.get("draw_works_command"),
        standpipe_pressure=scalars.get("standpipe_pressure"),
        mud_pump=joints.get("mud_pump"),
        mwd_tool_face=joints.get("mwd_tool_face"),
        tool_face_target=joints.get("tool_face_target"),
        bit_depth=joints.get("bit_depth"),
        truth_bit=joints.get("truth_bit"),
        truth_weight_on_bit=scalars.get("truth_weight_on_bit"),
        truth_depth=joints.get("truth_depth"),
    )


def _rig(
    source: str, rig_path: str | os.PathLike[str] | None, containers: list[Container], notes: list[str]
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


def _metadata(containers: list[Container]) -> dict[str, str]:
    """The `slider_drilling` metadata record of the first file that has one."""
    records = [record for container in containers for record in container.metadata]
    return next((dict(record.metadata) for record in records if record.name == "slider_drilling"), {})
