"""Logs damaged at random: each is read right, or with a remark, or refused in one line.

`SLIDER_DRILLING_FUZZ=10000 pytest test/test_log_fuzz.py` tries so many; a seed that fails is tried alone with
`damaged(seed, data, others)`.
"""

import os
import random
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, RigLog, read_log

TRIED = int(os.environ.get("SLIDER_DRILLING_FUZZ", "300"))
SERIES = ("top_drive", "standpipe_pressure", "mwd_tool_face")
STEPS = 600


def write(path: Path) -> None:
    with LogWriter(path, rig_text="schema: x\n" * 20, notes="a note", whole=True) as writer:
        for step in range(STEPS):
            time = 100.0 + 0.1 * step
            writer.joint_state("top_drive/joint_states", time, "top_drive", step, 0.05 * step, 3.0 * step)
            writer.fluid_pressure("standpipe_pressure", time, 1e6 + step, 1.0)
            if step % 50 == 0:
                writer.joint_state("mwd/tool_face", time - 6.0, "tool_face", 0.01 * step, log_time_s=time)


def rewritten(source: Path, path: Path, **options: object) -> bytes:
    """The same log as the mcap package's own writer puts it."""
    with path.open("wb") as file, source.open("rb") as origin:
        writer = Writer(file, enable_data_crcs=True, **options)  # type: ignore[arg-type]
        writer.start("ros2")
        reader = make_reader(origin)
        channels: dict[str, int] = {}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None
            if channel.topic not in channels:
                schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, "cdr", schema_id)
            writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
        for attachment in reader.iter_attachments():
            writer.add_attachment(0, 0, attachment.name, attachment.media_type, attachment.data)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, metadata.metadata)
        writer.finish()
    return path.read_bytes()


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    """One log as this package writes it, without chunks, and in chunks of three compressions."""
    folder = tmp_path_factory.mktemp("logs")
    own = folder / "own.mcap"
    write(own)
    options: list[dict[str, object]] = [
        {"use_chunking": False}, {"compression": CompressionType.LZ4, "chunk_size": 8000},
        {"compression": CompressionType.NONE, "chunk_size": 8000}]
    return [own.read_bytes(), *(rewritten(own, folder / f"{k}.mcap", **each) for k, each in enumerate(options))]


def flip_bits(random: random.Random, data: bytearray) -> None:
    for _ in range(random.choice([1, 1, 1, 2, 5])):
        data[random.randrange(len(data))] ^= 1 << random.randrange(8)


def overwrite(random: random.Random, data: bytearray) -> None:
    at, length = random.randrange(len(data)), random.randrange(1, 3000)
    length = min(length, len(data) - at)
    data[at : at + length] = random.choice([random.randbytes(length), bytes(length)])


def cut(random: random.Random, data: bytearray) -> None:
    del data[random.randrange(len(data)) :]


def insert(random: random.Random, data: bytearray) -> None:
    at = random.randrange(len(data))
    data[at:at] = random.randbytes(random.randrange(1, 3000))


def delete(random: random.Random, data: bytearray) -> None:
    at = random.randrange(len(data))
    del data[at : at + random.randrange(1, 5000)]


def swap(random: random.Random, data: bytearray) -> None:
    one, two = sorted((random.randrange(len(data)), random.randrange(len(data))))
    length = min(random.randrange(1, 9000), two - one, len(data) - two)
    data[one : one + length], data[two : two + length] = data[two : two + length], data[one : one + length]


def double(random: random.Random, data: bytearray) -> None:
    at = random.randrange(len(data))
    data[at:at] = data[at : at + random.randrange(1, 9000)]


def false_length(random: random.Random, data: bytearray) -> None:
    at = data.find(6, random.randrange(len(data)))
    if at >= 0:
        lengths = [0, 1, 2**63, 2**64 - 1, len(data), random.randrange(2**20)]
        data[at + 1 : at + 9] = struct.pack("<Q", random.choice(lengths))


def spoil_ends(random: random.Random, data: bytearray) -> None:
    place = random.randrange(min(len(data), 600))
    data[random.choice([place, len(data) - 1 - place])] ^= 1 << random.randrange(8)


DAMAGES: list[Callable[[random.Random, bytearray], None]] = [
    flip_bits, flip_bits, flip_bits, overwrite, cut, insert, delete, swap, double, false_length, spoil_ends]


def damaged(seed: int, logs: list[bytes]) -> bytes:
    """The log of this seed, damaged; now and then with another behind it."""
    chosen = random.Random(seed)
    data = bytearray(logs[seed % len(logs)])
    chosen.choice(DAMAGES)(chosen, data)
    return bytes(data) + (chosen.choice(logs) if chosen.random() < 0.05 else b"")


def differences(expected: RigLog, found: RigLog) -> int:
    """Samples that are missing, or are there and are not those that were written."""
    count = 0
    for name in SERIES:
        one, two = getattr(expected, name), getattr(found, name)
        rows = [] if two is None else list(zip(
            np.round(two.time + (found.start_ns - expected.start_ns) * 1e-9, 5).tolist(), *_columns(two), strict=True))
        wanted = set(zip(np.round(one.time, 5).tolist(), *_columns(one), strict=True))
        count += len(wanted.symmetric_difference(rows))
    return count


def _columns(series: object) -> list[list[float]]:
    names = ("position", "velocity", "effort") if hasattr(series, "position") else ("value", "variance")
    return [np.nan_to_num(getattr(series, name), nan=-1.0).tolist() for name in names]


def test_damage_is_borne_or_said(logs: list[bytes], tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    path.write_bytes(logs[0])
    expected = read_log(path)
    assert expected.notes == ()
    silent, read = [], 0
    for seed in range(TRIED):
        path.write_bytes(damaged(seed, logs))
        try:
            found = read_log(path)
        except InputError as error:
            assert str(error).startswith(str(path)) and "\n" not in str(error)
            continue
        read += 1
        about = (found.rig_text, found.metadata.get("notes")) != (expected.rig_text, "a note")
        if not found.notes and (about or differences(expected, found)):
            silent.append(seed)
    assert silent == []
    assert read > TRIED / 2


def test_a_flipped_bit_never_loses_a_channel(logs: list[bytes], tmp_path: Path) -> None:
    """One bit anywhere: every channel keeps all but a chunk."""
    path = tmp_path / "log.mcap"
    for seed in range(100):
        chosen = random.Random(seed)
        data = bytearray(logs[seed % len(logs)])
        data[chosen.randrange(len(data))] ^= 1 << chosen.randrange(8)
        path.write_bytes(data)
        log = read_log(path)
        assert log.top_drive is not None and log.standpipe_pressure is not None and log.mwd_tool_face is not None
        assert min(len(log.top_drive.time), len(log.standpipe_pressure.time)) > 0.75 * STEPS, seed
