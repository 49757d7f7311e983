"""Damaged logs: read as far as they go or refused in one line, never a traceback, never a wrong number."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import ChunkIndex

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, read_log

STEPS = 2000


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A log of several chunks in which the value of every sample tells its place."""
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    with LogWriter(path, rig_text="schema: x") as writer:
        for step in range(STEPS):
            writer.joint_state("top_drive/joint_states", step * 0.1, "top_drive", step, 0.02 * step, 3.0 * step)
    return path.read_bytes()


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("damaged") / "run.mcap"


def read_or_refuse(path: Path, data: bytes) -> int:
    """How many samples were read, all of them right; -1 where the log was refused in one line."""
    path.write_bytes(data)
    try:
        log = read_log(path)
    except InputError as error:
        assert str(path) in str(error) and "\n" not in str(error)
        return -1
    assert log.top_drive is not None
    step = np.round(log.top_drive.time * 10.0 + log.start * 10.0)
    np.testing.assert_array_equal(log.top_drive.position, step)
    np.testing.assert_array_equal(log.top_drive.velocity, 0.02 * step)
    np.testing.assert_array_equal(log.top_drive.effort, 3.0 * step)
    return len(step)


def test_the_whole_file(whole: bytes, place: Path) -> None:
    assert read_or_refuse(place, whole) == STEPS
    assert read_log(place).notes == ()


@settings(max_examples=20)
@given(share=st.floats(0.0, 1.0))
def test_truncated_anywhere(whole: bytes, place: Path, share: float) -> None:
    kept = int(share * len(whole))
    count = read_or_refuse(place, whole[:kept])
    if kept < len(whole) and count != -1:
        assert read_log(place).notes != ()


def test_the_further_it_goes_the_more_is_read(whole: bytes, place: Path) -> None:
    counts = [read_or_refuse(place, whole[: len(whole) * tenth // 10]) for tenth in range(1, 11)]
    assert counts == sorted(counts)
    assert counts[-1] == STEPS and 0 < counts[5] < STEPS


@settings(max_examples=30)
@given(where=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_one_flipped_bit(whole: bytes, place: Path, where: float, bit: int) -> None:
    damaged = bytearray(whole)
    damaged[int(where * len(whole))] ^= 1 << bit
    read_or_refuse(place, bytes(damaged))


@settings(max_examples=15)
@given(where=st.floats(0.0, 1.0, exclude_max=True), junk=st.binary(min_size=1, max_size=200))
def test_overwritten_stretch(whole: bytes, place: Path, where: float, junk: bytes) -> None:
    at = int(where * len(whole))
    read_or_refuse(place, (whole[:at] + junk + whole[at + len(junk) :])[: len(whole)])


def chunks_of(whole: bytes, place: Path) -> list[ChunkIndex]:
    """Where the chunks of a whole log are."""
    place.write_bytes(whole)
    with place.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None and len(summary.chunk_indexes) >= 3
    return summary.chunk_indexes


def test_damaged_chunk_is_a_gap(whole: bytes, place: Path) -> None:
    middle = chunks_of(whole, place)[1]
    damaged = bytearray(whole)
    damaged[middle.chunk_start_offset + middle.chunk_length // 2] ^= 0xFF
    count = read_or_refuse(place, bytes(damaged))
    assert STEPS / 2 < count < STEPS
    assert any("damaged chunk was left out" in note for note in read_log(place).notes)


def test_lost_messages_are_said(whole: bytes, place: Path) -> None:
    chunks = chunks_of(whole, place)
    first, length = chunks[1].chunk_start_offset, chunks[1].chunk_length + chunks[1].message_index_length
    count = read_or_refuse(place, whole[:first] + whole[first + length :])
    assert 0 < count < STEPS
    assert any(f"holds {count} messages of the {STEPS}" in note for note in read_log(place).notes)


def test_chunk_with_damaged_opcode_is_read(whole: bytes, place: Path) -> None:
    for opcode in (0x7F, 0x07, 0x05):
        damaged = bytearray(whole)
        damaged[chunks_of(whole, place)[-1].chunk_start_offset] = opcode
        count = read_or_refuse(place, bytes(damaged))
        assert count == STEPS or (opcode == 0x05 and count > STEPS / 2 and read_log(place).notes)


def test_damaged_rig_file_is_no_rig_file(whole: bytes, place: Path) -> None:
    assert whole.count(b"schema: x") == 1
    place.write_bytes(whole.replace(b"schema: x", b"schema: y"))
    log = read_log(place)
    assert log.rig_text is None
    assert any("attachment rig.yaml is damaged" in note for note in log.notes)


@settings(max_examples=40)
@given(junk=st.binary(max_size=300))
def test_not_a_log_at_all(place: Path, junk: bytes) -> None:
    assert read_or_refuse(place, junk) == -1


@settings(max_examples=20)
@given(junk=st.binary(max_size=300))
def test_only_the_first_bytes_are_right(place: Path, whole: bytes, junk: bytes) -> None:
    assert read_or_refuse(place, whole[:8] + junk) == -1


def test_missing_unreadable_and_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"missing\.mcap: no such log"):
        read_log(tmp_path / "missing.mcap")
    (tmp_path / "empty").touch()
    with pytest.raises(InputError, match="empty: is empty; expected an MCAP file"):
        read_log(tmp_path / "empty")
    with pytest.raises(InputError, match=r"holds no logs"):
        read_log(tmp_path)
    with pytest.raises(InputError, match=r"cannot read this log: Not a directory"):
        (tmp_path / "file").write_text("x")
        read_log(tmp_path / "file" / "run.mcap")


def test_log_of_other_topics_names_them(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with LogWriter(path) as writer:
        writer.joint_state("arm/joint_states", 0.0, "elbow", 0.0)
    with pytest.raises(InputError, match=r"no message of a rig's topics .* it holds /arm/joint_states"):
        read_log(path)
