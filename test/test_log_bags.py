"""Bags of any storage, compressed or not, and with files that metadata.yaml does not tell right, are read whole."""

import bz2
import gzip
import lzma
import math
import os
import socket
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import rosbags.rosbag1
import yaml
import zstandard
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, RigLog, read_log
from slider_drilling.log.follow_recording import RecordingFollower
from slider_drilling.log.info import log_info
from slider_drilling.log.recover import recover
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import FLUID_PRESSURE, JOINT_STATE

COUNT = 50
START_NS = 1_700_000_000_000_000_000


def rows() -> list[tuple[str, str, int, bytes]]:
    """Topic, type, time and CDR bytes of a short run."""
    made = []
    for step in range(COUNT):
        now = START_NS + step * 100_000_000
        state = cdr.encode_joint_state(now, "top_drive", 0.1 * step, 1.0, 5000.0 + step)
        made.append(("/rig/top_drive/joint_states", JOINT_STATE, now, state))
        made.append(("/rig/standpipe_pressure", FLUID_PRESSURE, now, cdr.encode_fluid_pressure(now, 2e7 + step, 0.0)))
    return made


def write_bag(path: Path, storage: StoragePlugin, mode: CompressionMode) -> Path:
    writer = Writer(path, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    store = get_typestore(Stores.ROS2_JAZZY)
    with writer:
        made = {}
        for topic, kind, now, data in rows():
            if topic not in made:
                made[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(made[topic], now, data)
    return path


def check_whole(log: RigLog) -> None:
    assert log.notes == ()
    assert log.top_drive is not None and log.standpipe_pressure is not None
    np.testing.assert_allclose(log.top_drive.time, 0.1 * np.arange(COUNT), atol=1e-9)
    np.testing.assert_array_equal(log.top_drive.effort, 5000.0 + np.arange(COUNT))
    np.testing.assert_array_equal(log.standpipe_pressure.value, 2e7 + np.arange(COUNT))


@pytest.mark.parametrize("mode", [CompressionMode.NONE, CompressionMode.FILE, CompressionMode.MESSAGE])
@pytest.mark.parametrize("storage", [StoragePlugin.SQLITE3, StoragePlugin.MCAP])
def test_any_storage_and_compression_is_read(tmp_path: Path, storage: StoragePlugin, mode: CompressionMode) -> None:
    bag = write_bag(tmp_path / "bag", storage, mode)
    parts = [file for file in bag.iterdir() if file.name != "metadata.yaml"]
    for path in (bag, bag / "metadata.yaml", *parts):
        check_whole(read_log(path))
    info = log_info(bag)
    assert info.notes == () and sum(topic.messages for topic in info.topics) == 2 * COUNT
    _, notes = recover(bag, tmp_path / "whole.mcap")
    assert notes == []
    check_whole(read_log(tmp_path / "whole.mcap"))


@pytest.mark.parametrize("compression", [None, *rosbags.rosbag1.Writer.CompressionFormat])
def test_a_bag_of_ros_1_is_read(tmp_path: Path, compression: object) -> None:
    writer = rosbags.rosbag1.Writer(tmp_path / "run.bag")
    if compression is not None:
        writer.set_compression(compression)  # type: ignore[arg-type]
    store = get_typestore(Stores.ROS1_NOETIC)
    with writer:
        made = {}
        for number, (topic, kind, now, data) in enumerate(rows()):
            if topic not in made:
                made[topic] = writer.add_connection(topic, kind, typestore=store)
            raw = bytes(get_typestore(Stores.ROS2_JAZZY).cdr_to_ros1(data, kind))
            # The sequence number of a header grows with each message.
            writer.write(made[topic], now, number.to_bytes(4, "little") + raw[4:])
    check_whole(read_log(tmp_path / "run.bag"))
    _, notes = recover(tmp_path / "run.bag", tmp_path / "whole.mcap")
    assert notes == []
    check_whole(read_log(tmp_path / "whole.mcap"))


def test_a_broken_bag_of_ros_1_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "run.bag").write_bytes(b"#ROSBAG V2.0\nnothing")
    with pytest.raises(InputError, match=r"run\.bag: no whole bag of ROS 1: [^\n]*$"):
        read_log(tmp_path / "run.bag")


@pytest.mark.parametrize(("ending", "compress"), [
    ("zst", zstandard.compress), ("gz", gzip.compress), ("bz2", bz2.compress), ("xz", lzma.compress),
    ("lz4", lz4.frame.compress),
])  # fmt: skip
def test_a_file_compressed_as_a_whole_is_read(
    tmp_path: Path, ending: str, compress: Callable[[bytes], bytes]
) -> None:
    write_part(tmp_path / "run.mcap", 0, COUNT)
    packed = compress((tmp_path / "run.mcap").read_bytes())
    path = tmp_path / f"run.mcap.{ending}"
    path.write_bytes(packed)
    log = read_log(path)
    assert log.notes == () and log.top_drive is not None and len(log.top_drive.time) == COUNT
    path.write_bytes(packed[: len(packed) * 9 // 10])
    try:
        assert log_info(path).notes
    except InputError as error:
        assert "is damaged from the beginning" in str(error)


def write_part(path: Path, first: int, last: int) -> None:
    with LogWriter(path, rig_text="schema: x", whole=True) as writer:
        for step in range(first, last):
            now = 1000.0 + 0.1 * step
            writer.joint_state("top_drive/joint_states", now, "top_drive", 0.1 * step, 1.0, 5000.0)


def write_parts(folder: Path, names: list[str], listed: list[str]) -> Path:
    """A bag of files of ten samples each, and its metadata.yaml."""
    folder.mkdir(exist_ok=True)
    for number, name in enumerate(names):
        write_part(folder / name, 10 * number, 10 * number + 10)
    content = {"version": 9, "storage_identifier": "mcap", "relative_file_paths": listed}
    (folder / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": content}))
    return folder


def samples(log: RigLog) -> int:
    assert log.top_drive is not None
    return len(log.top_drive.time)


@pytest.mark.parametrize("names", [
    ["run_0.mcap", "run_1.mcap", "run_2.mcap"], ["run.mcap", "run_1.mcap", "run_2.mcap"],
    ["a_20260101_120000.mcap", "a_20260101_120000_1.mcap", "a_20260101_120000_2.mcap"],
    ["0.mcap", "1.mcap", "2.mcap"],
    ["run_8.mcap", "run_9.mcap", "run_10.mcap"],
])  # fmt: skip
def test_a_part_that_is_not_listed_is_read_and_said(tmp_path: Path, names: list[str]) -> None:
    log = read_log(write_parts(tmp_path / "bag", names, names[:-1]))
    assert samples(log) == 30
    assert [note for note in log.notes if names[-1] in note and "not listed" in note] == list(log.notes)


def test_a_listed_part_that_is_missing_is_named(tmp_path: Path) -> None:
    bag = write_parts(tmp_path / "bag", ["run_0.mcap", "run_1.mcap", "run_2.mcap"],
                      ["run_0.mcap", "run_1.mcap", "run_2.mcap"])  # fmt: skip
    (bag / "run_1.mcap").unlink()
    for notes in (read_log(bag).notes, log_info(bag).notes, recover(bag, tmp_path / "x.mcap")[1]):
        assert [note.partition(":")[0] for note in notes] == ["run_1.mcap"] and "missing" in notes[0]
    (bag / "run_0.mcap").unlink()
    (bag / "run_2.mcap").unlink()
    with pytest.raises(InputError, match=r"holds no logs .* lists run_0\.mcap, run_1\.mcap, run_2\.mcap"):
        read_log(bag)


@pytest.mark.parametrize("content", [
    b"", b"no log at all", b"\x89MCAP0\r\n", b"SQLite format 3\x00" + bytes(100), b"#ROSBAG V2.0\nnothing",
    gzip.compress(b"", mtime=0)[:5], None,
])  # fmt: skip
@pytest.mark.parametrize("broken", ["run_0.mcap", "run_2.mcap"])
def test_a_part_that_cannot_be_read_is_named_and_skipped(tmp_path: Path, broken: str, content: bytes | None) -> None:
    names = ["run_0.mcap", "run_1.mcap", "run_2.mcap"]
    bag = write_parts(tmp_path / "bag", names, names)
    (bag / broken).unlink()
    (bag / broken).mkdir() if content is None else (bag / broken).write_bytes(content)
    log = read_log(bag)
    assert samples(log) == 20 and log.rig_text == "schema: x"
    for notes in (log.notes, log_info(bag).notes, recover(bag, tmp_path / "x.mcap")[1]):
        assert {note.partition(":")[0] for note in notes} == {broken} and "\n" not in "".join(notes)
    assert samples(read_log(tmp_path / "x.mcap")) == 20
    for name in names:
        if (bag / name).is_file():
            (bag / name).write_bytes(b"")
    for read in (read_log, log_info, lambda path: recover(path, tmp_path / "y.mcap")):
        with pytest.raises(InputError, match=r"run_1\.mcap: skipped: is empty[^\n]*$"):
            read(bag)
    with pytest.raises(InputError, match="is empty"):
        read_log(bag / "run_1.mcap")


def make_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(path))


@pytest.mark.parametrize("listed", [["run_0.mcap", "run_1.mcap"], []])
@pytest.mark.parametrize("make", [os.mkfifo, make_socket])
def test_a_pipe_or_a_socket_among_the_parts_is_named_and_skipped(
    tmp_path: Path, listed: list[str], make: Callable[[Path], None]
) -> None:
    bag = write_parts(tmp_path / "bag", ["run_0.mcap", "run_1.mcap"], listed)
    (bag / "run_1.mcap").unlink()
    make(bag / "run_1.mcap")
    for read in (lambda path: read_log(path).notes, lambda path: log_info(path).notes,
                 lambda path: recover(path, tmp_path / "x.mcap")[1]):  # fmt: skip
        assert read(bag) in ((note := "run_1.mcap: skipped: is a pipe, a socket or a device",), [note])
    assert set(RecordingFollower(bag).poll()) == set(read_log(bag).series())
    (bag / "run_0.mcap").unlink()
    for path in (bag, bag / "run_1.mcap"):
        for read in (read_log, log_info, RecordingFollower.poll):
            with pytest.raises(InputError, match=r"is a pipe, a socket or a device[^\n]*$"):
                read(RecordingFollower(path) if read is RecordingFollower.poll else path)


def test_a_metadata_file_that_is_a_pipe_is_no_list_of_files(tmp_path: Path) -> None:
    bag = write_parts(tmp_path / "bag", ["run_0.mcap"], [])
    (bag / "metadata.yaml").unlink()
    os.mkfifo(bag / "metadata.yaml")
    assert [note.partition(":")[0] for note in read_log(bag).notes] == ["metadata.yaml"]


@pytest.mark.parametrize("text", ["", "{", "a: 1", "rosbag2_bagfile_information: {relative_file_paths: run}", "\0"])
def test_a_metadata_file_that_lists_no_files_is_noted(tmp_path: Path, text: str) -> None:
    bag = write_parts(tmp_path / "bag", ["run_0.mcap", "run_1.mcap"], [])
    assert read_log(bag).notes == ()
    (bag / "metadata.yaml").write_text(text)
    log = read_log(bag)
    assert samples(log) == 20
    assert [note.partition(":")[0] for note in log.notes] == ["metadata.yaml"]


def test_another_recording_beside_the_bag_is_not_read(tmp_path: Path) -> None:
    names = ["a_20260101_120000.mcap", "a_20260101_130000.mcap", "other.mcap"]
    log = read_log(write_parts(tmp_path / "bag", names, names[:1]))
    assert samples(log) == 10
    assert [note.partition(":")[0] for note in log.notes] == names[1:]


def test_listed_parts_that_were_packed_by_hand_are_read(tmp_path: Path) -> None:
    bag = write_parts(tmp_path / "bag", ["run_0.mcap", "run_1.mcap"], ["run_0.mcap", "run_1.mcap"])
    (bag / "run_1.mcap.gz").write_bytes(gzip.compress((bag / "run_1.mcap").read_bytes()))
    (bag / "run_1.mcap").unlink()
    log = read_log(bag)
    assert samples(log) == 20 and log.notes == ()


def test_a_damaged_sqlite_bag_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", StoragePlugin.SQLITE3, CompressionMode.NONE)
    [path] = bag.glob("*.db3")
    whole = path.read_bytes()
    path.write_bytes(whole[:4096] + bytes(len(whole) - 4096))
    with pytest.raises(InputError, match=r"\.db3: [^\n]*$"):
        read_log(path)
    path.write_bytes(whole[: len(whole) // 2])
    try:
        log = read_log(path)
    except InputError as error:
        assert "\n" not in str(error)
    else:
        assert log.notes and samples(log) <= COUNT and math.isfinite(log.start)
